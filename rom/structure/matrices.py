"""The matrix type of a structure and the tests that structural matrices must pass."""

import warnings
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import LARGEST

Sparse: TypeAlias = "scipy.sparse.csc_array[np.float64]"
Matrix: TypeAlias = "Floats | Sparse"
MatrixLike: TypeAlias = "ArrayLike | scipy.sparse.sparray | scipy.sparse.spmatrix"

#: Entries may differ from their mirror image, and eigenvalues lie below zero, by this
#: fraction of the largest entry: what assembling in floating point leaves behind.
TOLERANCE = 1e-10


def as_matrix(name: str, value: MatrixLike) -> Matrix:
    """Copy a real, finite, two-dimensional matrix as float64, dense or CSC.

    Raises
    ------
    SlipmodeError
        With `name` in front, if `value` is anything else.
    """
    given: Any = value if scipy.sparse.issparse(value) else _as_array(name, value)
    if given.ndim != 2:
        raise SlipmodeError(f"{name}: must be a matrix (2 dimensions), got {given.ndim}")
    if given.dtype.kind not in "iuf":
        raise SlipmodeError(f"{name}: must hold real numbers, got dtype {given.dtype}")
    matrix: Matrix
    if isinstance(given, np.ndarray):
        entries = matrix = np.array(given, dtype=np.float64)
    else:
        matrix = as_csc(given.copy())
        matrix.sum_duplicates()
        entries = matrix.data
    if not np.isfinite(entries).all():
        raise SlipmodeError(f"{name}: must be finite, found NaN or infinity")
    if np.abs(entries).max(initial=0.0) > LARGEST:
        raise SlipmodeError(f"{name}: must be at most {LARGEST:g} in magnitude; use other units")
    return matrix


def as_symmetric(name: str, value: MatrixLike, size: int | None = None) -> Matrix:
    """Copy a symmetric matrix of shape (size, size); any size if it is None."""
    matrix = as_matrix(name, value)
    rows, columns = matrix.shape
    if rows != columns or rows == 0:
        raise SlipmodeError(f"{name}: must be square, got {rows} x {columns}")
    if size is not None and rows != size:
        raise SlipmodeError(f"{name}: must be {size} x {size} like mass, got {rows} x {rows}")
    if _largest(matrix - matrix.T) > TOLERANCE * _largest(matrix):
        raise SlipmodeError(f"{name}: must be symmetric (to {TOLERANCE:g} of its largest entry)")
    return matrix


def is_positive_definite(matrix: Matrix) -> bool:
    """Whether a symmetric matrix is positive definite, from one factorisation."""
    if not (matrix.diagonal() > 0).all():
        return False
    if isinstance(matrix, np.ndarray):
        try:
            np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            return False
        return True
    return _has_positive_pivots(matrix)


def is_positive_semidefinite(matrix: Matrix) -> bool:
    """Whether no eigenvalue of a symmetric matrix is negative beyond rounding.

    The matrix is lifted by the rounding allowance, so that a singular one still factorises.
    """
    shift = TOLERANCE * (_largest(matrix) or 1.0)
    size = matrix.shape[0]
    if isinstance(matrix, np.ndarray):
        return is_positive_definite(matrix + shift * np.eye(size))
    return is_positive_definite(as_csc(matrix + shift * scipy.sparse.eye_array(size)))


def as_csc(matrix: Any) -> Sparse:
    """The matrix as float64 compressed sparse columns."""
    columns: Sparse = scipy.sparse.csc_array(matrix, dtype=np.float64)
    return columns


def as_dense(matrix: Any) -> Floats:
    """The matrix as a float64 ndarray."""
    array: Floats = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
    return array


def solve(matrix: Matrix, right: Floats) -> Floats:
    """matrix^-1 right, for a symmetric positive definite matrix.

    Raises
    ------
    SlipmodeError
        If rounding makes it a singular one, whatever the units of its rows.
    """
    try:
        if scipy.sparse.issparse(matrix):
            from scipy.sparse.linalg import splu  # takes a while to import

            return np.asarray(splu(matrix.tocsc()).solve(right))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            unit = np.exp2(-np.round(0.5 * np.log2(matrix.diagonal())))[:, np.newaxis]
            scaled = scipy.linalg.solve(unit * matrix * unit.T, unit * right, assume_a="pos")
    except (RuntimeError, scipy.linalg.LinAlgError, RuntimeWarning, scipy.linalg.LinAlgWarning):
        raise SlipmodeError(
            "mass, stiffness: must be positive definite with bonded contacts, also to rounding: "
            "what is stiffer or heavier than the rest by 1e15 should be modelled as rigid"
        ) from None
    return np.asarray(unit * scaled)


def _as_array(name: str, value: Any) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError as error:
        raise SlipmodeError(f"{name}: rows must all have the same length") from error


def _largest(matrix: Any) -> float:
    """The largest absolute entry."""
    return float(abs(matrix).max())


def _has_positive_pivots(matrix: Sparse) -> bool:
    """Sylvester's criterion on L D L^T: LU with diagonal pivots only, D = diag(U)."""
    from scipy.sparse.linalg import splu

    try:
        factors = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # an exactly singular matrix
        return False
    diagonal_pivots = np.array_equal(factors.perm_r, factors.perm_c)
    return diagonal_pivots and bool((factors.U.diagonal() > 0).all())
