"""One factorisation of a Hermitian positive definite matrix, by that of a real one."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.structure.solvers.factorisation import factorise


class HermitianFactorisation:
    """Factorisation of A = B + i D, with B symmetric and D antisymmetric, (n, n).

    (B + i D)(x + i y) = f + i g is [[B, -D], [D, B]] (x, y) = (f, g), symmetric and positive
    definite as A is. Where D is zero, B is factorised alone.

    Parameters
    ----------
    matrix : (n, n) CSC matrix
    name : str
        Of the matrix, in messages.

    Raises
    ------
    NotPositiveDefiniteError
        If the matrix is not positive definite.
    """

    def __init__(self, matrix: Any, name: str = "stiffness") -> None:
        real, imaginary = matrix.real, matrix.imag
        self._is_real = abs(imaginary).max() == 0.0
        if not self._is_real:
            real = scipy.sparse.block_array([[real, -imaginary], [imaginary, real]], format="csc")
        self._factors = factorise(scipy.sparse.csc_array(real), name)

    def solve(self, right: Complexes) -> Complexes:
        """Return A^-1 right, for right-hand sides (n, m)."""
        size, columns = right.shape
        axis = 1 if self._is_real else 0
        parts: Floats = np.concatenate((right.real, right.imag), axis=axis)
        found = self._factors.solve(parts)
        if self._is_real:
            return np.asarray(found[:, :columns] + 1j * found[:, columns:])
        return np.asarray(found[:size] + 1j * found[size:])
