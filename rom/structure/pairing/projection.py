"""Points of a surface and the target that they meet: facets, or nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage, short_repr
from slipmode.rom.structure.pairing.surfaces import Facets, Indices, Surface, shape_functions

_OVERHANG = 0.1  # distance beyond the edge of a surface at which a point meets it, in facets


@dataclass(frozen=True)
class Met:
    """Points of the surface that meet the target, and the motion of the target there."""

    point: Indices  # (pairs,), ascending
    corners: Indices  # (pairs, corners), nodes of the target
    motion: Floats  # (pairs, corners, 3, 3), displacement there per displacement of each corner
    foot: Floats  # (pairs, 3), place on the target [m]
    normal: Floats  # (pairs, 3), from the surface towards the target

    __repr__ = short_repr


def onto_facets(one: Surface, other: Surface, tolerance: float, outward: Floats | None) -> Met:
    """Find the nearest facet of each point, at most the tolerance [m] away.

    With `outward`, normals (nodes, 3) of the surface, a facet must face it.
    """
    points, facets = one.position, other.facets
    assert facets is not None
    point, facet = _candidates(points, facets, tolerance)
    corners, triangular = facets.corners[facet], facets.triangular[facet]
    at, converged = _feet(points[point], corners, triangular)
    N, slopes = shape_functions(triangular, at)
    foot = np.einsum("ki,kix->kx", N, corners)
    tangents = slopes @ corners
    normal = np.cross(tangents[:, 0], tangents[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, np.newaxis]
    beyond = _overhang(triangular, at)
    size = facets.size()[facet]
    height = np.einsum("kx,kx->k", points[point] - foot, normal)
    distance = np.hypot(height, beyond * size)
    near = converged & (distance <= tolerance) & (beyond <= _OVERHANG)
    faced = near
    if outward is not None:
        # normals face each other within 60 degrees
        faced = near & (np.einsum("kx,kx->k", outward[point], normal) <= -0.5)
    if near.any() and not faced.any():
        raise SlipmodeError(
            "target: the facets near surface do not face it; order the nodes of facets "
            "counter-clockwise as seen from outside the body, or give normal"
        )
    if not near.any():
        raise _nothing_met(one, other, tolerance)
    own = np.flatnonzero(faced)
    # of facets at the same distance but for rounding take the first
    rank = np.round(distance[own] / (1e-9 * max(tolerance, size.max())))
    own = own[np.lexsort((facet[own], rank, point[own]))]
    own = own[np.unique(point[own], return_index=True)[1]]
    # A point at height d off the facet moves as if it were fixed to it: u = sum N_i u_i + d dn,
    # with the rotation of the normal dn = -sum grad N_i (n . u_i).
    gradient = np.einsum("kax,kai->kix", _gradients(tangents[own]), slopes[own])
    turn = np.einsum("k,kix,ky->kixy", height[own], gradient, normal[own])
    motion = N[own][:, :, np.newaxis, np.newaxis] * np.eye(3) - turn
    towards = -normal[own]
    if one.facets is not None and outward is not None:
        towards = outward[point[own]]
    return Met(point[own], facets.nodes[facet[own]], motion, foot[own], towards)


def onto_nodes(one: Surface, other: Surface, tolerance: float, outward: Floats | None) -> Met:
    """Find the nearest node of the target of each point, at most the tolerance [m] away."""
    if outward is None:
        raise SlipmodeError(
            "normal: is required because neither surface nor target has facets; give a direction"
        )
    distance, found = scipy.spatial.cKDTree(other.position).query(one.position)
    point = np.flatnonzero(distance <= tolerance)
    if not point.size:
        raise _nothing_met(one, other, tolerance)
    nearest = np.asarray(found)[point]
    order = np.argsort(nearest, kind="stable")
    twice = np.flatnonzero(np.diff(nearest[order]) == 0)
    if twice.size:
        a, b = one.nodes[point[order[twice[0] : twice[0] + 2]]]
        raise SlipmodeError(
            f"target: node {other.nodes[nearest[order[twice[0]]]]} is the nearest to both nodes "
            f"{a} and {b} of surface; give facets of target, because the meshes do not match"
        )
    motion = np.broadcast_to(np.eye(3), (point.size, 1, 3, 3))
    corners = other.nodes[nearest, np.newaxis]
    return Met(point, corners, motion, other.position[nearest], outward[point])


def _nothing_met(one: Surface, other: Surface, tolerance: float) -> SlipmodeError:

    least = float(np.min(scipy.spatial.cKDTree(other.position).query(one.position)[0]))
    reason = f"the nearest node of target is {least:.3g} m away"
    if other.facets is not None and least <= tolerance:
        reason = f"nodes lie more than {percentage(_OVERHANG)} of a facet beyond the edge"
    return SlipmodeError(
        f"tolerance: no node of surface is within {tolerance:g} m of target; {reason}"
    )


def _candidates(points: Floats, facets: Facets, tolerance: float) -> tuple[Indices, Indices]:
    """Return pairs of point and facet that are near each other."""
    centre, reach = facets.corners.mean(axis=1), 1.5 * facets.size() + tolerance
    found = scipy.spatial.cKDTree(points).query_ball_point(centre, reach)
    facet = np.repeat(np.arange(len(centre)), [len(each) for each in found])
    point = np.fromiter((p for each in found for p in each), dtype=np.intp, count=facet.size)
    return point, facet


def _feet(points: Floats, corners: Floats, triangular: Flags) -> tuple[Floats, Flags]:
    """Return local coordinates (k, 2) of the foot of each point on its facet; whether found."""
    at = np.where(triangular[:, np.newaxis], 1.0 / 3.0, np.zeros((len(points), 2)))
    step = np.zeros(len(points))
    moving = np.arange(len(points))
    for _ in range(30):
        N, slopes = shape_functions(triangular[moving], at[moving])
        offset = points[moving] - np.einsum("ki,kix->kx", N, corners[moving])
        change = np.einsum("kax,kx->ka", _gradients(slopes @ corners[moving]), offset)
        at[moving] = np.clip(at[moving] + change, -3.0, 3.0)
        step[moving] = np.abs(change).max(axis=1)
        moving = moving[step[moving] > 1e-14]  # in local coordinates
    return at, step <= 1e-10


def _gradients(tangents: Floats) -> Floats:
    """Return gradients (k, 2, 3) of the local coordinates, from the tangents (k, 2, 3)."""
    a, b = tangents[:, 0], tangents[:, 1]
    normal = np.cross(a, b)
    square = np.maximum(np.einsum("kx,kx->k", normal, normal), np.finfo(float).tiny)
    dual = np.stack((np.cross(b, normal), np.cross(normal, a)), axis=1)
    return np.asarray(dual / square[:, np.newaxis, np.newaxis])


def _overhang(triangular: Flags, at: Floats) -> Floats:
    """Return the distance of local coordinates (k, 2) from the facet, in facets; 0 inside."""
    a, b = at.T
    beyond = np.where(
        triangular,
        np.max((-a, -b, a + b - 1.0), axis=0),
        0.5 * (np.max((np.abs(a), np.abs(b)), axis=0) - 1.0),
    )
    return np.asarray(np.maximum(beyond, 0.0))
