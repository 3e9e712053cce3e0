"""Numbers in text as Fortran writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats

#: An exponent of three digits leaves no room for its letter: 1.5-105.
_BARE_EXPONENT = re.compile(r"(?<=[\d.])([+-]\d)")


class DamagedError(ValueError):
    """A reason why a file cannot be read; `read_matrix_file` names the file."""


def has_fortran_exponents(text: str) -> bool:
    """Return whether exponents in a text may be written as 1.5D+05 or 1.5+05."""
    return re.search(r"[\d.][dD+-][+-]?\d", text) is not None


def with_plain_exponents(text: str) -> str:
    """Return a text of numbers with exponents 1.5E+05 in place of 1.5D+05 or 1.5+05."""
    return _BARE_EXPONENT.sub(r"E\1", text.upper().replace("D", "E"))


def fixed_width(lines: Sequence[str], per_line: int, width: int, count: int) -> Floats:
    """Return the first `count` numbers of lines with `per_line` fields of a fixed width.

    Fields between blanks are read as they are, because scipy's are narrower than it states. Raises
    DamagedError if there are fewer numbers, or a field is no number.
    """
    words = " ".join(lines).split()
    if len(words) == count:
        return numbers(words, count)
    full = per_line * width
    fields = np.frombuffer(
        "".join(line[:full].ljust(full) for line in lines).encode("latin-1"), f"S{width}"
    )
    return numbers(fields[:count], count)


def numbers(fields: Sequence[str] | np.ndarray, count: int) -> Floats:
    """Return fields as numbers, whose exponent may be 1.5E-05, 1.5D-05 or 1.5-05."""
    words = np.asarray(fields, dtype=np.bytes_)
    if words.size != count:
        raise DamagedError(f"has {words.size} numbers instead of {count}")
    words = np.char.replace(np.char.upper(words), b"D", b"E")
    try:
        return words.astype(np.float64)
    except ValueError:
        return np.array([number(word.decode("latin-1")) for word in words])


def number(word: str) -> float:
    """Return a number, whose exponent may be 1.5E-05, 1.5D-05 or 1.5-05."""
    try:
        return float(with_plain_exponents(word))
    except ValueError:
        raise DamagedError(f"{word.strip()[:40]!r} is not a number") from None
