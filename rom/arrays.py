"""Array types, and the check of arrays that users give."""

import reprlib
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError

Floats: TypeAlias = NDArray[np.float64]
Complexes: TypeAlias = NDArray[np.complex128]
Flags: TypeAlias = NDArray[np.bool_]


def as_floats(key: str, given: Any) -> Floats:
    """Return a user's numbers as an array of floats; refuse, naming `key`, what is no real number.

    NaN and infinity are allowed.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "cSUmM":  # numpy would drop imaginary parts and parse text
            return np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        pass
    raise SlipmodeError(f"{key}: must be real numbers, got {in_one_line(given)}")


def as_complexes(key: str, given: Any) -> Complexes:
    """Return a user's numbers as an array; refuse, naming `key`, what is no number.

    NaN and infinity are allowed.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "SUmM":
            return np.asarray(array, dtype=complex)
    except (TypeError, ValueError):
        pass
    raise SlipmodeError(f"{key}: must be numbers, got {in_one_line(given)}")


def as_number(key: str, given: Any) -> float:
    """Return a user's real number; refuse, naming `key`, other types. NaN is allowed."""
    scalar = isinstance(given, np.ndarray) and given.ndim == 0 and given.dtype.kind in "iuf"
    if scalar or (type(given) is not bool and isinstance(given, Real)):
        return float(given)
    raise SlipmodeError(f"{key}: must be a real number, got {in_one_line(given)}")


def check_count(key: str, given: Any) -> None:
    """Refuse, naming `key`, what is not an integer >= 1."""
    if isinstance(given, bool) or not isinstance(given, int | np.integer) or given < 1:
        raise SlipmodeError(f"{key}: must be an integer >= 1, got {in_one_line(given)}")


def check_dof(dof: Any, n_dofs: int) -> None:
    """Refuse what is not the index of one of so many DOFs."""
    if not (isinstance(dof, int | np.integer) and 0 <= dof < n_dofs):
        raise SlipmodeError(f"dof: must be 0 to {n_dofs - 1}, got {in_one_line(dof)}")


def in_one_line(given: Any) -> str:
    """Return a short representation of any object, for messages."""
    return " ".join(reprlib.repr(given).split())
