"""DMIG cards of Nastran, in punch or bulk data files: small, large and free fields."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.readers.named import Named, mirrored
from slipmode.rom.structure.readers.text import DamagedError, number

_log = logging.getLogger(__name__)

_SQUARE = (1, 6)  # forms of square and symmetric matrices
_COMPLEX = (3, 4)  # types of complex numbers in single and double precision
_CONTINUED = ("*", "+", ",", " ")


def read_dmig(path: Path) -> dict[str, Any]:
    """Return the square matrices of a file by name; load vectors are left out, with a note.

    The words of a card are in groups of four. The header is NAME, 0, form, type. The cards of a
    column are NAME, node, direction, blank; then node, direction, real and imaginary part of each
    entry. Scalar points have direction 0.
    """
    form: dict[str, int] = {}
    kind: dict[str, int] = {}
    entries: dict[str, dict[tuple[tuple[int, int], tuple[int, int]], complex]] = {}
    for head, *groups in _cards(read_text(path)):
        name, node, direction, last = head
        if node == "0":
            form[name], kind[name] = int(direction), int(last)
            entries[name] = {}
            continue
        if name not in entries:
            raise DamagedError(f"a column of {name} is before its header")
        column = (int(node), int(direction or 0))
        for row_node, row_direction, real, imaginary in groups:
            if row_node:
                value = number(real) + 1j * number(imaginary or "0")
                entries[name][(int(row_node), int(row_direction or 0)), column] = value
    if not entries:
        raise SlipmodeError(f"{path}: has no DMIG cards; write the matrices as DMIG")
    vectors = [name for name in entries if form[name] not in _SQUARE]
    if vectors:
        _log.warning("%s: %s: no square matrix, left out", path, ", ".join(vectors))
    return {
        name: _labelled(found, kind[name] in _COMPLEX)
        for name, found in entries.items()
        if name not in vectors
    }


def _labelled(
    entries: dict[tuple[tuple[int, int], tuple[int, int]], complex], is_complex: bool
) -> Named:
    """Return a matrix whose DOFs are those of its entries, in the order of node and direction."""
    if not entries:
        raise DamagedError("a matrix has no entries")
    pairs = sorted({end for ends in entries for end in ends})
    place = {pair: k for k, pair in enumerate(pairs)}
    rows, columns = np.array([[place[end] for end in ends] for ends in entries]).T
    values = np.array(list(entries.values()))
    size = len(pairs)
    matrix = scipy.sparse.coo_array(
        (values if is_complex else values.real, (rows, columns)), shape=(size, size)
    )
    return Named(mirrored(matrix), Labels(*np.array(pairs, dtype=np.int64).T))


def _cards(text: str) -> Iterator[list[list[str]]]:
    """Yield the words of each DMIG card, in groups of four."""
    card: list[list[str]] = []
    for full in text.splitlines():
        line = full.partition("$")[0].rstrip()
        if not line:
            continue
        if re.match(r"DMIG\b|DMIG\*", line.upper()):
            if card:
                yield card
            card = _groups(line)
        elif card and line.startswith(_CONTINUED):
            card += _groups(line)
        else:
            if card:
                yield card
            card = []
    if card:
        yield card


def _groups(line: str) -> list[list[str]]:
    """Return the words of a line after its first field, in groups of four."""
    if "," in line:
        words = [word.strip() for word in line.split(",")][1:9]
    else:
        width = 16 if "*" in line[:8] else 8
        words = [line[k : k + width].strip() for k in range(8, 72, width)]
    words += [""] * (-len(words) % 4)
    return [words[k : k + 4] for k in range(0, len(words), 4)]
