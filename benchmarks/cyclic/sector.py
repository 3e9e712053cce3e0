"""A sector of a bladed disk, of hexahedra: disk, and a blade with gaps to its neighbours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

from slipmode import rom

_E, _NU, _RHO = 2.0e11, 0.3, 7800.0  # steel [Pa], [-], [kg/m^3]
_INNER, _RIM, _TIP = 0.10, 0.18, 0.30  # radii [m]
_WIDTH = 0.02  # along the axis [m]
_GAP = 0.2  # share of the sector's angle that is open between blades


class Sector(NamedTuple):
    """A sector, held at its inner radius.

    Attributes
    ----------
    mass, stiffness : (n, n) sparse matrix
    mesh : rom.SectorMesh
    left_face, right_face : (k,) ndarray of int
        Nodes of the blade's tip on either side, by their height along the axis.
    """

    mass: Any
    stiffness: Any
    mesh: rom.SectorMesh
    left_face: np.ndarray
    right_face: np.ndarray


def sector(sectors: int, radial: int, across: int, axial: int) -> Sector:
    """Return a sector of so many elements along the radius, across and along the axis."""
    rim = max(round(radial * (_RIM - _INNER) / (_TIP - _INNER)), 1)
    radii = np.concatenate(
        (np.linspace(_INNER, _RIM, rim + 1), np.linspace(_RIM, _TIP, radial - rim + 1)[1:])
    )
    whole = 2.0 * np.pi / sectors
    edge = 0.5 * _GAP * whole
    angles = np.concatenate(([0.0], np.linspace(edge, whole - edge, across - 1), [whole]))
    flat = MeshHex.init_tensor(radii, angles, np.linspace(0.0, _WIDTH, axial + 1))
    middle = flat.p[:, flat.t].mean(axis=1)
    open_cells = (middle[0] > _RIM) & ((middle[1] < edge) | (middle[1] > whole - edge))
    flat = flat.remove_elements(np.flatnonzero(open_cells))
    r, angle, z = flat.p
    solid = MeshHex(np.array([r * np.cos(angle), r * np.sin(angle), z]), flat.t)
    M, K, dofs = _matrices(solid)
    free = np.flatnonzero(r[np.repeat(np.arange(r.size), 3)] > _INNER + 1e-9)
    kept = np.full(3 * r.size, -1)
    kept[dofs.ravel()[free]] = np.arange(free.size)
    order = dofs.ravel()[free]
    tip = np.abs(r - _TIP) < 1e-9

    def face(side: float) -> np.ndarray:
        nodes = np.flatnonzero(tip & (np.abs(angle - side) < 1e-9))
        return np.asarray(nodes[np.argsort(z[nodes])])

    mesh = rom.SectorMesh(
        solid.p.T,
        kept[dofs],
        left=np.flatnonzero((np.abs(angle) < 1e-9) & (r > _INNER + 1e-9)),
        right=np.flatnonzero((np.abs(angle - whole) < 1e-9) & (r > _INNER + 1e-9)),
    )
    return Sector(M[order][:, order], K[order][:, order], mesh, face(edge), face(whole - edge))


def _matrices(solid: Any) -> tuple[Any, Any, np.ndarray]:
    """Return mass, stiffness, and the DOFs (nodes, 3) of x, y, z."""
    basis = Basis(solid, ElementVector(ElementHex1()), intorder=2)
    inertia = BilinearForm(lambda u, v, _: _RHO * dot(u, v))
    K = linear_elasticity(*lame_parameters(_E, _NU)).assemble(basis)
    return inertia.assemble(basis).tocsc(), K.tocsc(), np.asarray(basis.nodal_dofs.T)
