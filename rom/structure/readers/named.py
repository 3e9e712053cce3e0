"""A matrix and the labels of its rows; symmetric matrices of which files have one triangle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.structure.labels import Labels


@dataclass(frozen=True, eq=False)
class Named:
    """A matrix and, where the file has them, the labels of its rows."""

    matrix: Any
    labels: Labels | None = None


def mirrored(matrix: Any) -> Any:
    """Return the whole symmetric matrix (CSC) if one triangle is given, else the matrix."""
    off = scipy.sparse.csc_array(scipy.sparse.triu(matrix, 1) + scipy.sparse.tril(matrix, -1))
    pattern = scipy.sparse.csc_array((np.ones(off.nnz), off.indices, off.indptr), shape=off.shape)
    both_triangles = pattern.multiply(pattern.T).nnz > 0
    return scipy.sparse.csc_array(matrix if both_triangles else matrix + off.T)


def symmetric(places: NDArray[Any], values: NDArray[Any], size: int = 0) -> Any:
    """Return the symmetric matrix of entries at (row, column), from 1; one triangle may do."""
    rows, columns = places.astype(np.int64).T - 1
    size = max(size, int(max(rows.max(), columns.max())) + 1)
    return mirrored(scipy.sparse.coo_array((values, (rows, columns)), shape=(size, size)))
