"""Static response of a sector in any nodal diameter, from one factorisation of its interior.

Nodal diameters differ only in how the boundary moves: the sides where sectors meet, and the
contacts. With interior i and boundary b, K_ii is factorised once, and the boundary has the
stiffness S = K_bb - K_bi K_ii^-1 K_ib. In nodal diameter k, whose boundary moves by T_k x with its
DOFs x that are free, it is the small Hermitian T_k^H S T_k with the springs of the contacts.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np
import scipy.linalg
import scipy.sparse
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import BLOCK, Matrix, as_csc, as_dense
from slipmode.rom.structure.solvers.factorisation import Factorisation, factorise


@frozen
class Condensation:
    """A sector whose interior follows its boundary.

    Attributes
    ----------
    interior, boundary : (i,), (b,) ndarray of int
        DOFs of the sector, both ascending.
    coupling : (i, b) CSC matrix
        K_ib [N/m].
    factors : Factorisation or None
        Of K_ii; None where there is no interior.
    stiffness : (b, b) ndarray
        S [N/m].
    """

    interior: NDArray[np.intp]
    boundary: NDArray[np.intp]
    coupling: Any
    factors: Factorisation | None
    stiffness: Floats

    @classmethod
    def of(cls, stiffness: Matrix, boundary: NDArray[np.intp]) -> Self:
        """Return a sector with stiffness (n, n), condensed to its boundary.

        Raises
        ------
        NotPositiveDefiniteError
            If the interior can move while the boundary is held.
        """
        interior = np.setdiff1d(np.arange(stiffness.shape[0]), boundary)
        K: Any = as_csc(stiffness)
        coupling = K[interior][:, boundary]
        S = as_dense(K[boundary][:, boundary])
        factors = factorise(as_csc(K[interior][:, interior])) if interior.size else None
        if factors is not None:
            for start in range(0, boundary.size, BLOCK):
                block = slice(start, start + BLOCK)
                S[:, block] -= coupling.T @ factors.solve(coupling[:, block].toarray())
        return cls(interior, boundary, coupling, factors, 0.5 * (S + S.T))

    def inside(self, force: Complexes) -> Complexes:
        """Return displacements of the interior (i, m) by forces on it, with held boundary."""
        if self.factors is None:
            return force
        columns = force.shape[1]
        found = self.factors.solve(np.hstack((force.real, force.imag)))
        return np.asarray(found[:, :columns] + 1j * found[:, columns:])


class StaticResponse:
    """Displacements by static forces in one nodal diameter, with springs at the contacts.

    Parameters
    ----------
    sector : Condensation
    expansion : (n, n_s) CSC matrix
        T_k, complex: all DOFs of the sector by those that are free.
    contacts : (N_c, n_s) CSC matrix
        Displacements of the contacts, by the boundary alone.
    reference : (N_c,) ndarray
        Stiffness of their springs [N/m].

    Raises
    ------
    scipy.linalg.LinAlgError
        If the stiffness is not positive definite.
    """

    def __init__(
        self, sector: Condensation, expansion: Any, contacts: Any, reference: Floats
    ) -> None:
        self._sector = sector
        rows = expansion.tocsr()
        # Which free DOFs are inside, and which move the boundary
        self._inside = rows[sector.interior].indices
        self._free = np.setdiff1d(np.arange(expansion.shape[1]), self._inside)
        self._motion = rows[sector.boundary][:, self._free]
        springs = contacts[:, self._free].toarray()
        T = self._motion
        S = T.conj().T @ (T.T @ sector.stiffness.T).T
        S = S + springs.conj().T @ (reference[:, np.newaxis] * springs)
        self._factor = scipy.linalg.cho_factor(S, check_finite=False)

    def __call__(self, force: Complexes) -> Complexes:
        """Return displacements (n_s, m) by forces (n_s, m)."""
        sector, T = self._sector, self._motion
        alone = sector.inside(force[self._inside])
        passed = force[self._free] - T.conj().T @ (sector.coupling.T @ alone)
        moved = scipy.linalg.cho_solve(self._factor, passed, check_finite=False)
        found = np.empty(force.shape, dtype=complex)
        found[self._free] = moved
        found[self._inside] = alone - sector.inside(sector.coupling @ (T @ moved))
        return found
