"""Matrices of a structure, dense or sparse: checks of the user's input, and conversions."""

from typing import Any, TypeAlias

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import LARGEST

Sparse: TypeAlias = "scipy.sparse.csc_array[np.float64]"
Matrix: TypeAlias = "Floats | Sparse"
MatrixLike: TypeAlias = "ArrayLike | scipy.sparse.sparray | scipy.sparse.spmatrix"

#: Asymmetry of a matrix, and negative eigenvalues, that are rounding errors of assembly, relative
#: to its largest entry.
TOLERANCE = 1e-10

_CIRCULATORY = (
    ", circulatory forces, which are not modelled; leave this part out, or give its effect on the "
    "modes as aerodynamics of rom.reduce"
)
# What a skew-symmetric part of a matrix stands for
_SKEW = {
    "stiffness": _CIRCULATORY,
    "spin_stiffness": _CIRCULATORY,
    "damping": ", gyroscopic forces; give them to rom.RotatingStructure",
}

BLOCK = 16  # columns of a product at a time: all at once would double the memory of `right`


def as_matrix(name: str, value: MatrixLike) -> Matrix:
    """Copy a real, finite matrix as float64, dense or CSC; refuse another value, naming `name`."""
    try:
        given: Any = value if scipy.sparse.issparse(value) else np.asarray(value)
    except ValueError as error:
        raise SlipmodeError(f"{name}: rows must all have the same length") from error
    if given.ndim != 2:
        raise SlipmodeError(f"{name}: must be a matrix (2 dimensions), got {given.ndim}")
    if given.dtype.kind not in "iuf":
        raise SlipmodeError(f"{name}: must hold real numbers, got dtype {given.dtype}")
    matrix: Matrix
    if isinstance(given, np.ndarray):
        entries = matrix = np.array(given, dtype=np.float64)
    else:
        matrix = as_csc(given.copy() if given.format == "csc" else given)
        matrix.sum_duplicates()
        entries = matrix.data
    if not np.isfinite(entries).all():
        raise SlipmodeError(f"{name}: must be finite, found NaN or infinity")
    if np.abs(entries).max(initial=0.0) > LARGEST:
        raise SlipmodeError(f"{name}: must be at most {LARGEST:g} in magnitude; use other units")
    return matrix


def real_and_imaginary(value: MatrixLike) -> tuple[Any, Any]:
    """Return the parts of a matrix; the imaginary one is None if it is 0 or the matrix is real."""
    try:
        given: Any = value if scipy.sparse.issparse(value) else np.asarray(value)
    except ValueError:  # refused where the value is checked
        return value, None
    if given.dtype.kind != "c":
        return value, None
    return given.real, given.imag if abs(given.imag).max() > 0.0 else None


def as_symmetric(name: str, value: MatrixLike, size: int | None = None) -> Matrix:
    """Copy a symmetric matrix of shape (size, size); any size if it is None."""
    matrix = as_matrix(name, value)
    rows, columns = matrix.shape
    if rows != columns or rows == 0:
        raise SlipmodeError(f"{name}: must be square, got {rows} x {columns}")
    if size is not None and rows != size:
        raise SlipmodeError(f"{name}: must be {size} x {size} like mass, got {rows} x {rows}")
    skew, largest = 0.5 * largest_entry(matrix - matrix.T), largest_entry(matrix)
    if 2.0 * skew > TOLERANCE * largest:
        raise SlipmodeError(
            f"{name}: must be symmetric (to {TOLERANCE:g} of its largest entry); its "
            f"skew-symmetric part is {skew / largest:.2g} of it{_SKEW.get(name, '')}"
        )
    return matrix


def as_skew(name: str, value: MatrixLike, size: int) -> Matrix:
    """Copy a skew-symmetric matrix of shape (size, size)."""
    matrix = as_matrix(name, value)
    if matrix.shape != (size, size):
        raise SlipmodeError(f"{name}: must be {size} x {size} like mass, got {matrix.shape}")
    if largest_entry(matrix + matrix.T) > TOLERANCE * largest_entry(matrix):
        raise SlipmodeError(
            f"{name}: must be skew-symmetric (to {TOLERANCE:g} of its largest entry); a symmetric "
            "part is damping"
        )
    return matrix


def as_csc(matrix: Any) -> Sparse:
    """Return the matrix as float64 compressed sparse columns."""
    columns: Sparse = scipy.sparse.csc_array(matrix, dtype=np.float64)
    return columns


def as_dense(matrix: Any) -> Floats:
    """Return the matrix as an ndarray."""
    array: Floats = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
    return array


def projection(left: Floats, matrix: Matrix, right: Floats) -> Floats:
    """Return left^T matrix right (k, m), for left (n, k) and right (n, m)."""
    if isinstance(matrix, np.ndarray):
        return np.asarray(left.T @ (matrix @ right))
    projected = np.empty((left.shape[1], right.shape[1]))
    for start in range(0, right.shape[1], BLOCK):
        block = slice(start, start + BLOCK)
        projected[:, block] = left.T @ as_dense(matrix @ right[:, block])
    return projected


def largest_entry(matrix: Any) -> float:
    """Return the largest absolute entry."""
    entries = matrix if isinstance(matrix, np.ndarray) else matrix.data
    return float(max(entries.max(initial=0.0), -entries.min(initial=0.0)))
