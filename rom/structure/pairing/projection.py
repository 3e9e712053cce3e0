"""Points projected onto facets, and the motion of points that facets carry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.pairing.surfaces import Facets, Indices, shape_functions

OVERHANG = 0.1  # distance beyond the edge of a surface at which a point meets it, in facets
_FACING = -0.5  # largest cosine of the angle between normals that face each other: 60 degrees
_SAME = 1e-9  # rounding of equal distances, relative to the size of facets
_NEWTON_PASSES = 30
_FARTHEST = 3.0  # bound of local coordinates during the iteration
_STEP, _CONVERGED = 1e-14, 1e-10  # last and largest allowed Newton step, in local coordinates


@dataclass(frozen=True)
class Projection:
    """Points x = sum N_i x_i + d n on the facets that they meet.

    Attributes
    ----------
    point, facet : (pairs,) ndarray of int
        Points that meet a facet, in ascending order, and the facet.
    foot : (pairs, 3) ndarray
        sum N_i x_i [m].
    normal : (pairs, 3) ndarray
        Outward normal of the facet at the foot.
    motion : (pairs, 4, 3, 3) ndarray
        Displacement of the point, which the facet carries, per displacement of each corner.
    averted : int
        Number of points near a facet that face away from it.
    """

    point: Indices
    facet: Indices
    foot: Floats
    normal: Floats
    motion: Floats
    averted: int

    __repr__ = short_repr


def project(
    points: Floats, facets: Facets, tolerance: float, outward: Floats | None = None
) -> Projection:
    """Find the nearest facet of each point (p, 3), at most the tolerance [m] away.

    With `outward`, normals (p, 3) of the surface that the points are on, a facet must face it.
    """
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
    near = converged & (distance <= tolerance) & (beyond <= OVERHANG)
    faced = near
    if outward is not None:
        faced = near & (np.einsum("kx,kx->k", outward[point], normal) <= _FACING)
    averted = np.setdiff1d(point[near], point[faced]).size
    own = np.flatnonzero(faced)
    # of facets at the same distance but for rounding take the first
    rank = np.round(distance[own] / (_SAME * max(tolerance, size.max(initial=0.0))))
    own = own[np.lexsort((facet[own], rank, point[own]))]
    own = own[np.unique(point[own], return_index=True)[1]]
    motion = _motion(N[own], slopes[own], tangents[own], normal[own], height[own])
    return Projection(point[own], facet[own], foot[own], normal[own], motion, averted)


def _candidates(points: Floats, facets: Facets, tolerance: float) -> tuple[Indices, Indices]:
    """Return pairs of point and facet that are near each other."""
    from scipy.spatial import cKDTree  # takes a while to import

    centre, reach = facets.corners.mean(axis=1), 1.5 * facets.size() + tolerance
    found = cKDTree(points).query_ball_point(centre, reach)
    facet = np.repeat(np.arange(len(centre)), [len(each) for each in found])
    point = np.fromiter((p for each in found for p in each), dtype=np.intp, count=facet.size)
    return point, facet


def _feet(points: Floats, corners: Floats, triangular: Flags) -> tuple[Floats, Flags]:
    """Return local coordinates (k, 2) of the foot of each point on its facet; whether found."""
    at = np.where(triangular[:, np.newaxis], 1.0 / 3.0, np.zeros((len(points), 2)))
    step = np.zeros(len(points))
    moving = np.arange(len(points))
    for _ in range(_NEWTON_PASSES):
        N, slopes = shape_functions(triangular[moving], at[moving])
        left = points[moving] - np.einsum("ki,kix->kx", N, corners[moving])
        change = np.einsum("kax,kx->ka", _gradients(slopes @ corners[moving]), left)
        at[moving] = np.clip(at[moving] + change, -_FARTHEST, _FARTHEST)
        step[moving] = np.abs(change).max(axis=1)
        moving = moving[step[moving] > _STEP]
    return at, step <= _CONVERGED


def _gradients(tangents: Floats) -> Floats:
    """Return gradients (k, 2, 3) of the local coordinates, from the tangents (k, 2, 3)."""
    a, b = tangents[:, 0], tangents[:, 1]
    normal = np.cross(a, b)
    square = np.maximum(np.einsum("kx,kx->k", normal, normal), np.finfo(float).tiny)
    dual = np.stack((np.cross(b, normal), np.cross(normal, a)), axis=1)
    return np.asarray(dual / square[:, np.newaxis, np.newaxis])


def _motion(N: Floats, slopes: Floats, tangents: Floats, normal: Floats, height: Floats) -> Floats:
    """Return the matrices (k, 4, 3, 3) of u = sum N_i u_i + d dn, dn = -sum grad N_i (n . u_i).

    dn is the rotation of the normal: a point off the facet moves as if it were fixed to it.
    """
    gradient = np.einsum("kax,kai->kix", _gradients(tangents), slopes)
    turn = np.einsum("k,kix,ky->kixy", height, gradient, normal)
    return np.asarray(N[:, :, np.newaxis, np.newaxis] * np.eye(3) - turn)


def _overhang(triangular: Flags, at: Floats) -> Floats:
    """Return the distance of local coordinates (k, 2) from the facet, in facets; 0 inside."""
    a, b = at.T
    beyond = np.where(
        triangular,
        np.max((-a, -b, a + b - 1.0), axis=0),
        0.5 * (np.max((np.abs(a), np.abs(b)), axis=0) - 1.0),
    )
    return np.asarray(np.maximum(beyond, 0.0))
