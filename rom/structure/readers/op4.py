"""OUTPUT4 files of Nastran: text or binary, dense or sparse, single or double precision.

A matrix is a header (columns, rows, form, type, name) and a record for each column that is not
empty: column, first row, number of words, and numbers. The record of a column beyond the last ends
the matrix. A first row 0 marks a sparse column: strings of numbers, each after a word with length
and row, or after two words if the header has the number of rows with a minus sign (BIGMAT).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.readers.named import mirrored
from slipmode.rom.structure.readers.text import DamagedError, fixed_width

_HEADER = re.compile(r"\s*(\d+)\s+(-?\d+)\s+\d+\s+([1-4])\s*([A-Z]\w*)\s*(.*)", re.IGNORECASE)
_FORMAT = re.compile(r"(\d+)[DEFG](\d+)", re.IGNORECASE)
_DEFAULT_FORMAT = "5E16.9"

#: Length of the first record of a binary file, by the size of its words.
_HEADER_BYTES = {24: 4, 48: 8}

Numbers = NDArray[Any]


def read_op4(path: Path) -> dict[str, Any]:
    """Return the matrices of a file by name."""
    with path.open("rb") as file:
        first = file.read(4).ljust(4)
    heads = {order: int(np.frombuffer(first, f"{order}i4")[0]) for order in "<>"}
    binary = [order for order, head in heads.items() if head in _HEADER_BYTES]
    if binary:
        matrices = _binary(path.read_bytes(), binary[0], _HEADER_BYTES[heads[binary[0]]])
    else:
        matrices = _text(iter(read_text(path).splitlines()))
    found: dict[str, Any] = {}
    for name, matrix in matrices:
        if name in found:
            raise DamagedError(f"has two matrices {name}")
        found[name] = matrix
    if not found:
        raise DamagedError("has no matrix")
    return found


class _Entries:
    """The entries of a matrix in a file with words of so many bytes, column by column."""

    def __init__(self, columns: int, rows: int, kind: int, word: int = 4) -> None:
        self.shape = abs(rows), columns
        self.has_long_strings = rows < 0
        self._is_complex = kind > 2
        self.words = 2 if kind in (2, 4) and word < 8 else 1  # of a number
        self._rows: list[Numbers] = []
        self._columns: list[Numbers] = []
        self._values: list[Numbers] = []

    def add(self, column: int, row: int, found: Numbers) -> None:
        """Add numbers in a column from a row on, both numbered from 1."""
        values = found.astype(np.float64)
        if self._is_complex:
            values = values.view(np.complex128)
        if not 1 <= row <= self.shape[0] - values.size + 1:
            raise DamagedError("has rows beyond the last")
        places = np.flatnonzero(values)
        self._rows.append(places + row - 1)
        self._columns.append(np.full(places.size, column - 1))
        self._values.append(values[places])

    def add_strings(
        self,
        column: int,
        words: int,
        integers: Callable[[int], Any],
        numbers: Callable[[int], Numbers],
    ) -> None:
        """Add the strings of a sparse column; `numbers` returns the next numbers."""
        while words > 0:
            if self.has_long_strings:
                length, row = integers(2)
                words -= length + 1
            else:
                (packed,) = integers(1)
                length, row = divmod(int(packed), 1 << 16)
                words -= length
            if length < 2:
                raise DamagedError("has an empty string")
            self.add(column, int(row), numbers((int(length) - 1) // self.words))

    def matrix(self) -> Any:
        """Return the matrix, mirrored if one triangle is given."""
        rows, columns, values = (
            np.concatenate([np.zeros(0, dtype=np.int64), *parts])
            for parts in (self._rows, self._columns, self._values)
        )
        found = scipy.sparse.csc_array((values, (rows, columns)), shape=self.shape)
        return mirrored(found) if self.shape[0] == self.shape[1] else found


def _text(lines: Iterator[str]) -> Iterator[tuple[str, Any]]:
    def integers(count: int) -> list[int]:
        return [int(word) for word in next(lines).split()[:count]]

    for line in lines:
        if not line.strip():
            continue
        header = _HEADER.match(line)
        if header is None:
            raise DamagedError("a header is damaged")
        entries = _Entries(*(int(word) for word in header.groups()[:3]))
        per_line, width = (
            int(word) for word in (_FORMAT.search(header[5] or _DEFAULT_FORMAT) or header).groups()
        )

        def numbers(count: int, per_line: int = per_line, width: int = width) -> Numbers:
            return fixed_width(list(islice(lines, -(-count // per_line))), per_line, width, count)

        while True:
            column, row, count = integers(3)
            if column > entries.shape[1]:
                numbers(count)
                break
            if row > 0:
                entries.add(column, row, numbers(count))
            else:
                entries.add_strings(column, count, integers, numbers)
        yield header[4], entries.matrix()


def _binary(content: bytes, order: str, size: int) -> Iterator[tuple[str, Any]]:
    """Yield name and matrix of each matrix of a file with words of so many bytes."""
    integer = np.dtype(f"{order}i{size}")
    at = 0

    def record() -> bytes:
        nonlocal at
        (length,) = np.frombuffer(content[at : at + 4], f"{order}i4")
        found = content[at + 4 : at + 4 + length]
        if length < 0 or content[at + 4 + length : at + 8 + length] != content[at : at + 4]:
            raise DamagedError("a record is damaged or incomplete")
        at += 8 + int(length)
        return found

    while at < len(content):
        head = record()
        columns, rows, _, kind = (int(word) for word in np.frombuffer(head[: 4 * size], integer))
        if not 1 <= kind <= 4:
            raise DamagedError("a header is damaged")
        entries = _Entries(columns, rows, kind, size)
        number = np.dtype(f"{order}f{entries.words * size}")
        while True:
            data = record()
            column, row, words = (int(w) for w in np.frombuffer(data[: 3 * size], integer))
            if column > columns:
                break
            data = data[3 * size : (3 + words) * size]
            if row > 0:
                entries.add(column, row, np.frombuffer(data, number))
                continue
            place = 0

            def integers(count: int, data: bytes = data) -> Any:
                nonlocal place
                place += count * size
                return np.frombuffer(data[place - count * size : place], integer)

            def numbers(count: int, data: bytes = data, number: Any = number) -> Numbers:
                nonlocal place
                place += count * number.itemsize
                return np.frombuffer(data[place - count * number.itemsize : place], number)

            entries.add_strings(column, words, integers, numbers)
        yield head[4 * size :].decode("latin-1").replace("\0", " ").strip(), entries.matrix()
