"""Contacts from two surfaces of a mesh that face each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.matrices import Sparse, as_csc
from slipmode.rom.structure.pairing.pairs import ContactPairs, local_frames
from slipmode.rom.structure.pairing.projection import onto_facets, onto_nodes
from slipmode.rom.structure.pairing.surfaces import Indices, Surface, as_surface


def contact_pairs(
    coordinates: ArrayLike,
    dofs: ArrayLike,
    surface: ArrayLike,
    target: ArrayLike,
    *,
    tolerance: float,
    normal: ArrayLike | None = None,
    tangent: ArrayLike | None = None,
    area: ArrayLike | None = None,
    tangents: int = 2,
    n_dofs: int | None = None,
) -> ContactPairs:
    """Return contacts between the nodes of a surface and a target surface.

    Each node of the surface is paired with the target facet that lies opposite to it. The corners
    of this facet move the projected point by their shape functions. A target without facets is
    paired by nearest nodes. The meshes need not match.

    Parameters
    ----------
    coordinates : (nodes, 3) array_like
        Positions of all nodes [m].
    dofs : (nodes, 3) array_like of int
        DOFs of the x, y, z displacement of each node; -1 where it is fixed.
    surface, target : (k,) or (facets, 3 or 4) array_like of int
        Nodes as rows of `coordinates`, or facets with their nodes counter-clockwise as seen from
        outside the body. A triangle among quadrilaterals has its last node twice. The surface
        should have the finer mesh.
    tolerance : float
        Largest distance between a node and the target [m], including the gap. A node may lie
        beyond the edge of the target by a tenth of a facet.
    normal : (3,) array_like, optional
        Direction from the surface to the target [-], of any length. Facets are oriented to it,
        so that the order of their nodes does not matter. Surfaces without facets have this normal
        at all contacts.
    tangent : (3,) array_like, optional
        First tangent [-], of any length, projected onto the plane across each normal. Default: one
        global axis for all contacts. Where this axis is along a normal, the global axis
        farthest from the normal.
    area : float or (k,) array_like, optional
        Areas of the nodes of a surface without facets [m^2].
    tangents : {1, 2}, default 2
        Number of tangential directions of each contact. A plane model has one, with DOFs -1 along
        z.
    n_dofs : int, optional
        Number n of DOFs of the structure. Default: the largest entry of `dofs` plus one.

    Returns
    -------
    ContactPairs
        Contact directions, areas, gaps and positions of the paired nodes.

    Raises
    ------
    SlipmodeError
        If arrays have wrong shapes, surface and target share a node, no node of the surface is
        within the tolerance of the target, or all paired nodes are fixed on both sides. If an area
        or a normal is needed and missing.

    Notes
    -----
    A rigid-body motion of both bodies together moves no contact on a facet, even across a gap. It
    moves a contact between two nodes if it rotates nodes that do not coincide.

    Areas are integrals of the shape functions over the facets of the surface, as for a pressure.
    They are not cut at the border of a smaller target.

    Examples
    --------
    Contacts of a mesh, grouped into eight patches, with a law per unit area::

        nodes = rom.contact_pairs(points, dofs, lower, upper, tolerance=1e-4)
        pairs = nodes.gathered(8)
        structure = rom.Structure(M, K, contact=pairs.W)
        law = rom.FrictionalContact.on_areas(
            pairs.area,
            mu=0.3,
            tangential_stiffness=1e12,
            normal_stiffness=1e12,
            gap=pairs.gap,
        )
        rest = rom.preload(structure, law, bolts)
    """
    x, number = _mesh(coordinates, dofs)
    least = int(number.max(initial=-1)) + 1
    if n_dofs is not None and n_dofs < least:
        raise SlipmodeError(f"n_dofs: must be at least {least}, because dofs has DOF {least - 1}")
    size = least if n_dofs is None else int(n_dofs)
    if tangents not in (1, 2):
        raise SlipmodeError(f"tangents: must be 1 or 2, got {tangents}")
    if not (isinstance(tolerance, float | int | np.floating) and 0.0 < tolerance < np.inf):
        raise SlipmodeError(f"tolerance: must be a positive distance [m], got {tolerance}")
    towards = None if normal is None else _unit("normal", normal)
    one = as_surface("surface", surface, x, towards)
    other = as_surface("target", target, x, None if towards is None else -towards)
    shared = np.intersect1d(one.nodes, other.nodes)
    if shared.size:
        raise SlipmodeError(
            f"target: node {shared[0]} is also in surface; bodies in contact must share no nodes"
        )
    weight, outward = _areas_and_normals(one, area, towards)
    meet = onto_nodes if other.facets is None else onto_facets
    found = meet(one, other, tolerance, outward)
    motion = _displacements(number[one.nodes[found.point], np.newaxis], np.eye(3), size)
    relative = as_csc(motion - _displacements(number[found.corners], found.motion, size))
    moved = np.flatnonzero(abs(relative).sum(axis=0).reshape(-1, 3).any(axis=1))
    if not moved.size:
        raise SlipmodeError(
            "dofs: all nodes where surface meets target are fixed on both sides; at least one "
            "must be free"
        )
    point, normals = found.point[moved], found.normal[moved]
    own = one.position[point]
    gap = np.einsum("kx,kx->k", found.foot[moved] - own, normals)
    extent = np.ptp(np.concatenate((one.position, other.position)), axis=0).max()
    # smaller gaps are due to rounded coordinates
    return ContactPairs(
        relative=relative[:, (3 * moved[:, np.newaxis] + np.arange(3)).ravel()],
        frames=local_frames(normals, None if tangent is None else _unit("tangent", tangent)),
        area=weight[point],
        gap=np.where(gap > 1e-6 * extent, gap, 0.0),
        position=own,
        nodes=tuple(one.nodes[point, np.newaxis]),
        unpaired=np.delete(one.nodes, point),
        tangents=tangents,
    )


def _areas_and_normals(
    surface: Surface, area: Any, towards: Floats | None
) -> tuple[Floats, Floats | None]:
    """Return the area (nodes,) and, if known, unit normal (nodes, 3) of each node."""
    if surface.facets is not None:
        if area is not None:
            raise SlipmodeError("area: must be left out if surface has facets, which determine it")
        return surface.areas_and_normals()
    if area is None:
        raise SlipmodeError(
            "area: is required because surface has no facets; give facets, or the area of each "
            "node"
        )
    count = len(surface.nodes)
    given = np.asarray(area, dtype=float)
    if given.shape not in ((), (count,)):
        raise SlipmodeError(f"area: must be one number or {count} (one per node of surface)")
    if not np.all((given > 0.0) & (given < np.inf)):
        raise SlipmodeError("area: must be positive [m^2]")
    normals = None if towards is None else np.tile(towards, (count, 1))
    return np.broadcast_to(given, count).copy(), normals


def _displacements(dofs: Indices, motion: Floats, n_dofs: int) -> Sparse:
    """Return x, y, z displacements of contacts per displacement of the DOFs, (n, 3 contacts).

    `dofs` (contacts, corners, 3) are the DOFs of the corners, `motion` (contacts, corners, 3, 3)
    the displacement of a contact per displacement of each corner.
    """
    shape = (*dofs.shape, 3)
    value = np.broadcast_to(motion.swapaxes(-1, -2), shape)  # [contact, corner, DOF, direction]
    row = np.broadcast_to(dofs[..., np.newaxis], shape)
    column = 3 * np.arange(len(dofs))[:, np.newaxis, np.newaxis, np.newaxis] + np.arange(3)
    column = np.broadcast_to(column, shape)
    # Other corners do not move the point, but for rounding
    kept = (row >= 0) & (np.abs(value) > 1e-14)
    entries = (value[kept], (row[kept], column[kept]))
    return as_csc(scipy.sparse.coo_array(entries, shape=(n_dofs, 3 * len(dofs))))


def _mesh(coordinates: ArrayLike, dofs: ArrayLike) -> tuple[Floats, Indices]:
    try:
        x = np.asarray(coordinates, dtype=float)
        number: Any = np.asarray(dofs)
    except (ValueError, TypeError):
        raise SlipmodeError("coordinates, dofs: must be numbers of shape (nodes, 3)") from None
    if x.ndim != 2 or x.shape[1] != 3 or not np.isfinite(x).all():
        raise SlipmodeError(
            f"coordinates: must be finite numbers of shape (nodes, 3), got shape {x.shape}"
        )
    if number.shape != x.shape or number.dtype.kind not in "iu":
        raise SlipmodeError(
            f"dofs: must be integers of shape {x.shape} like coordinates, got {number.dtype} of "
            f"shape {number.shape}"
        )
    if np.any(number < -1):
        raise SlipmodeError("dofs: must be 0 or more, or -1 where a node is fixed")
    found, count = np.unique(number[number >= 0], return_counts=True)
    if np.any(count > 1):
        raise SlipmodeError(
            f"dofs: DOF {found[np.argmax(count > 1)]} occurs twice; each must occur once"
        )
    return x, np.asarray(number, dtype=np.intp)


def _unit(name: str, given: ArrayLike) -> Floats:
    try:
        vector = np.asarray(given, dtype=float)
    except (ValueError, TypeError):
        vector = np.empty(0)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise SlipmodeError(
            f"{name}: must be a vector of 3 numbers, not all 0, got {np.array2string(vector)}"
        )
    return vector / length
