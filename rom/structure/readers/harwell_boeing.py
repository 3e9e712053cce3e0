"""Harwell-Boeing files: RSA and RUA, with any Fortran format, as Ansys and LS-DYNA write them.

I. S. Duff, R. G. Grimes, J. G. Lewis, Users' guide for the Harwell-Boeing sparse matrix collection
(1992): four lines of header, a fifth if there are right-hand sides, then column pointers, row
indices and values. Right-hand sides follow, and are not read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.readers.named import Named, mirrored
from slipmode.rom.structure.readers.text import DamagedError, fixed_width

_FORMAT = re.compile(r"\((?:[^()]|\([^()]*\))*\)")
_SCALE = re.compile(
    r"[+-]?\d+P,?"
)  # of a Fortran format; without effect on numbers with exponents
_FIELD = re.compile(r"(\d*)\(?(\d*)[IDEFG](\d+)")


def read_harwell_boeing(path: Path) -> Named:
    """Return the matrix of a Harwell-Boeing file; one triangle of a symmetric matrix may do."""
    lines = iter(read_text(path).splitlines())
    header = [line.upper() for line in islice(lines, 4)]
    if len(header) < 4 or not re.match(r"\s*[A-Z]{3}\s", header[2]):
        raise DamagedError("the third line must begin with the type, for instance RSA")
    kind, *counts = header[2].split()
    if not re.fullmatch("[RI][SU]A", kind):
        raise SlipmodeError(
            f"{path}: has the type {kind}; must be RSA or RUA: real, symmetric or unsymmetric, "
            "assembled"
        )
    rows, columns, entries = (int(word) for word in counts[:3])
    if rows != columns:
        raise SlipmodeError(f"{path}: must be square, got {rows} x {columns}")
    cards = [int(word) for word in header[1].split()]
    if len(cards) > 4 and cards[4] > 0:
        next(lines)  # the type of the right-hand sides
    formats = _FORMAT.findall(header[3])
    starts = _block(lines, formats[0], columns + 1).astype(np.int64) - 1
    places = _block(lines, formats[1], entries).astype(np.int64) - 1
    values = _block(lines, formats[2], entries)
    if starts[0] != 0 or starts[-1] != entries or np.any(np.diff(starts) < 0):
        raise DamagedError("column pointers must ascend from 1 to the number of entries + 1")
    matrix = scipy.sparse.csc_array((values, places, starts), shape=(rows, columns))
    matrix.check_format(full_check=True)
    return Named(mirrored(matrix))


def _block(lines: Iterator[str], form: str, count: int) -> Floats:
    """Return the next `count` numbers, which a Fortran format such as (1P,3E25.16) wrote."""
    found = _FIELD.search(_SCALE.sub("", form.replace(" ", "")))
    if found is None:
        raise DamagedError(f"{form} must be a format with a width, for instance (8I10)")
    outer, inner, width = found.groups()
    per_line = int(outer or 1) * int(inner or 1)
    block = list(islice(lines, -(-count // per_line)))
    return fixed_width(block, per_line, int(width), count)
