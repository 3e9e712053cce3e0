"""Elimination of the interior of a structure: the stiffness of its boundary, and what follows."""

from __future__ import annotations

import importlib.util
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import BLOCK, Matrix, as_csc, as_dense
from slipmode.rom.structure.solvers.factorisation import SMALL, Pardiso, factorise


class Elimination(Protocol):
    """A matrix K (n, n) whose interior rows i are eliminated; the boundary rows b stay.

    K u = f is solved by `forward` of f, by S u_b = forward(f)_b with anything added to S, and by
    `backward` of forward(f) with u_b in place of its rows b.
    """

    @property
    def boundary(self) -> NDArray[np.intp]:
        """Rows b, ascending."""

    @property
    def schur(self) -> Floats:
        """S = K_bb - K_bi K_ii^-1 K_ib, (b, b)."""

    def forward(self, right: Floats) -> Floats:
        """Return f_b - K_bi K_ii^-1 f_i in the rows b, and any in the rows i, (n, m)."""

    def backward(self, reduced: Floats) -> Floats:
        """Return u (n, m) from u_b in the rows b and the rows i of `forward`."""


def eliminate(matrix: Matrix, boundary: NDArray[np.intp]) -> Elimination:
    """Eliminate the rows of a symmetric matrix (n, n) that are not in `boundary`, ascending.

    Raises
    ------
    NotPositiveDefiniteError
        If K_ii is not positive definite.
    """
    size = matrix.shape[0]
    if size - boundary.size > SMALL and importlib.util.find_spec("pypardiso") is not None:
        return Pardiso(as_csc(matrix), f"factorising stiffness ({size} DOFs)", boundary)
    return InteriorSolutions(matrix, boundary)


class InteriorSolutions:
    """Elimination by solutions with the interior, as many as the boundary has rows."""

    def __init__(self, matrix: Matrix, boundary: NDArray[np.intp]) -> None:
        K: Any = as_csc(matrix)
        self.boundary = boundary
        self._interior = interior = np.setdiff1d(np.arange(K.shape[0]), boundary)
        self._coupling = K[interior][:, boundary]
        self._factors = factorise(as_csc(K[interior][:, interior])) if interior.size else None
        S = as_dense(K[boundary][:, boundary])
        for start in range(0, boundary.size, BLOCK):
            block = slice(start, start + BLOCK)
            S[:, block] -= self._coupling.T @ self._inside(self._coupling[:, block].toarray())
        self.schur = 0.5 * (S + S.T)

    def forward(self, right: Floats) -> Floats:
        """Return f_b - K_bi K_ii^-1 f_i in the rows b, K_ii^-1 f_i in the rows i."""
        reduced = right.copy()
        reduced[self._interior] = self._inside(right[self._interior])
        reduced[self.boundary] -= self._coupling.T @ reduced[self._interior]
        return reduced

    def backward(self, reduced: Floats) -> Floats:
        """Return u, whose rows i are K_ii^-1 (f_i - K_ib u_b)."""
        moved = reduced.copy()
        moved[self._interior] -= self._inside(self._coupling @ reduced[self.boundary])
        return moved

    def _inside(self, force: Floats) -> Floats:
        return force if self._factors is None else self._factors.solve(force)
