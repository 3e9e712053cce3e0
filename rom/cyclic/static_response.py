"""Static response of a sector in any nodal diameter, from one elimination of its interior.

Nodal diameters differ only in how the boundary moves: the sides where sectors meet, and the
contacts. With interior i and boundary b, the boundary has the stiffness
S = K_bb - K_bi K_ii^-1 K_ib. In nodal diameter k, whose boundary moves by T_k x with its DOFs x
that are free, it is the small Hermitian T_k^H S T_k with the springs of the contacts.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.cyclic.structure import CyclicStructure


class StaticResponse:
    """Displacements by static forces in one nodal diameter, with springs at the contacts.

    Parameters
    ----------
    structure : CyclicStructure
    nodal_diameter : int
        k.
    reference : (N_c,) ndarray
        Stiffness of the springs [N/m].

    Raises
    ------
    NotPositiveDefiniteError
        If the interior can move while the boundary is held.
    scipy.linalg.LinAlgError
        If the stiffness is not positive definite.
    """

    def __init__(self, structure: CyclicStructure, nodal_diameter: int, reference: Floats) -> None:
        self._sector, self._free_dofs = structure.condensed, structure.free_dofs
        self._size = structure.stiffness.shape[0]
        boundary = self._sector.boundary
        free = np.isin(self._free_dofs, boundary)
        self._motion = T = structure.expansion(nodal_diameter).tocsr()[boundary][:, free]
        springs = structure.contact_motion(nodal_diameter)[:, free].toarray()
        S = T.conj().T @ (T.T @ self._sector.schur.T).T
        S = S + springs.conj().T @ (reference[:, np.newaxis] * springs)
        self._factor = scipy.linalg.cho_factor(S, check_finite=False)

    def __call__(self, force: Complexes) -> Complexes:
        """Return displacements (n_s, m) by forces (n_s, m)."""
        sector, T, free = self._sector, self._motion, self._free_dofs
        on_sector = np.zeros((self._size, 2 * force.shape[1]))
        on_sector[free] = _real(force)
        reduced = sector.forward(on_sector)
        passed = T.conj().T @ _complex(reduced[sector.boundary])
        moved = scipy.linalg.cho_solve(self._factor, passed, check_finite=False)
        reduced[sector.boundary] = _real(T @ moved)
        return _complex(sector.backward(reduced)[free])


def _real(columns: Complexes) -> Floats:
    """Return complex columns (n, m) as real ones (n, 2 m)."""
    return np.hstack((columns.real, columns.imag))


def _complex(columns: Floats) -> Complexes:
    real, imaginary = np.hsplit(columns, 2)
    return np.asarray(real + 1j * imaginary)
