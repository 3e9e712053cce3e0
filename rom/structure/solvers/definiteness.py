"""Whether a symmetric matrix is positive definite."""

from __future__ import annotations

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import TOLERANCE, Matrix, as_csc, as_dense, largest_entry
from slipmode.rom.structure.solvers.factorisation import NotPositiveDefiniteError, factorise

_SMALL = 500  # up to here a dense factorisation is the faster one
_ACCURACY = 0.1  # of the smallest eigenvalue
_STEPS = 50  # Lanczos restarts, before it is left to a factorisation


def is_positive_definite(matrix: Matrix) -> bool:
    """Whether a symmetric matrix is positive definite, from one factorisation."""
    if not (matrix.diagonal() > 0).all():
        return False
    if isinstance(matrix, np.ndarray) or matrix.shape[0] <= _SMALL:
        try:
            np.linalg.cholesky(as_dense(matrix))
        except np.linalg.LinAlgError:
            return False
        return True
    try:
        factorise(matrix, "damping")
    except NotPositiveDefiniteError:
        return False
    return True


def is_positive_mass(mass: Matrix) -> bool:
    """Whether a mass matrix is positive definite; a large one is not factorised.

    Scaled by its diagonal, a mass matrix of elements has eigenvalues of about 1 (A. J. Wathen,
    1987), so Lanczos steps find the smallest one. Where they do not, it is factorised after all.
    """
    diagonal = mass.diagonal()
    if not (diagonal > 0).all():
        return False
    if isinstance(mass, np.ndarray) or mass.shape[0] <= _SMALL:
        return is_positive_definite(mass)
    if mass.nnz == mass.shape[0]:
        return True
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

    unit = 1.0 / np.sqrt(diagonal)

    def scaled(x: Floats) -> Floats:
        return np.asarray(unit * (mass @ (unit * x.ravel())))

    operator = LinearOperator(mass.shape, matvec=scaled, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    try:
        lowest = eigsh(
            *(operator, 1, None, None, "SA", start, 20, _STEPS, _ACCURACY),
            return_eigenvectors=False,
        )
    except ArpackNoConvergence:
        return is_positive_definite(mass)
    return bool(lowest[0] > TOLERANCE)


def is_positive_semidefinite(matrix: Matrix) -> bool:
    """Whether no eigenvalue of a symmetric matrix is negative beyond rounding.

    The matrix is lifted by the rounding allowance, so that a singular one still factorises.
    """
    shift = TOLERANCE * (largest_entry(matrix) or 1.0)
    size = matrix.shape[0]
    if isinstance(matrix, np.ndarray):
        return is_positive_definite(matrix + shift * np.eye(size))
    return is_positive_definite(as_csc(matrix + shift * scipy.sparse.eye_array(size)))
