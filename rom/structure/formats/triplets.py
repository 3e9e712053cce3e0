"""Matrices as rows of text: where an entry is, and its value."""

from __future__ import annotations

from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.labels import Labels


@dataclass(frozen=True, eq=False)
class Named:
    """A matrix and, where the file has them, the labels of its rows."""

    matrix: Any
    labels: Labels | None = None


def read_numbers(path: Path, columns: tuple[int, ...], what: str) -> NDArray[np.float64]:
    """The rows of a file (rows, columns); lines that begin with * are comments.

    Raises
    ------
    SlipmodeError
        If the rows are no numbers, or of other lengths than one of `columns`.
    """
    try:
        text = path.read_text(encoding="ascii").replace(",", " ").replace("D", "E")
        numbers = np.loadtxt(StringIO(text), comments="*", ndmin=2)
    except (ValueError, OSError) as error:
        reason = " ".join(str(error).split())
        raise SlipmodeError(f"{path}: is damaged or no {what}: {reason}") from error
    if numbers.size == 0 or numbers.shape[1] not in columns:
        allowed = " or ".join(map(str, columns))
        raise SlipmodeError(f"{path}: is no {what}: its rows must have {allowed} numbers")
    return numbers


def by_index(rows: NDArray[Any], columns: NDArray[Any], values: Any, size: int = 0) -> Any:
    """The symmetric matrix of entries at rows and columns (from 1); one triangle may do."""
    size = max(size, int(max(rows.max(), columns.max())))
    where = (rows.astype(np.int64) - 1, columns.astype(np.int64) - 1)
    return mirrored(scipy.sparse.coo_array((values, where), shape=(size, size)))


def by_label(numbers: NDArray[np.float64]) -> Named:
    """The symmetric matrix of rows (node, direction, node, direction, value)."""
    keys = numbers[:, :4].astype(np.int64)
    pairs, index = np.unique(
        np.concatenate((keys[:, :2], keys[:, 2:])), axis=0, return_inverse=True
    )
    rows, columns = np.split(index.ravel() + 1, 2)
    return Named(
        by_index(rows, columns, numbers[:, 4], len(pairs)), Labels(pairs[:, 0], pairs[:, 1])
    )


def mirrored(matrix: Any) -> Any:
    """The whole symmetric matrix, of which one half may be all that is there."""
    off = scipy.sparse.csc_array(scipy.sparse.triu(matrix, 1) + scipy.sparse.tril(matrix, -1))
    pattern = scipy.sparse.csc_array((np.ones(off.nnz), off.indices, off.indptr), shape=off.shape)
    if pattern.multiply(pattern.T).nnz:  # entries and their mirror images
        return scipy.sparse.csc_array(matrix)
    return scipy.sparse.csc_array(matrix + off.T)
