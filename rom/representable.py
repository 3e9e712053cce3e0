"""Allowed magnitudes of numbers: products of several of them must be doubles."""

from __future__ import annotations

from math import ceil, floor, log10

import numpy as np
from numpy.typing import ArrayLike

SMALLEST, LARGEST = 1e-30, 1e30  # input in any units; 0 is allowed too
SMALLEST_PRODUCT, LARGEST_PRODUCT = 1e-75, 1e75  # computed values: their squares are doubles
ALLOWED = f"0 or {SMALLEST:g} to {LARGEST:g} in magnitude"


def fits(values: ArrayLike) -> bool:
    """Return whether all values are 0 or of allowed magnitude; NaN and infinity are not."""
    size = np.abs(np.asarray(values, dtype=float))
    return bool(np.all((size == 0.0) | ((size >= SMALLEST) & (size <= LARGEST))))


def round_up(value: float, digits: int = 2) -> float:
    """Return the next larger number of so many significant digits, for messages."""
    unit = 10.0 ** (floor(log10(value)) - digits + 1)
    return float(f"{ceil(value / unit * (1.0 - 1e-12)) * unit:.{digits}g}")


def round_down(value: float, digits: int = 2) -> float:
    """Return the next smaller number of so many significant digits, for messages."""
    unit = 10.0 ** (floor(log10(value)) - digits + 1)
    return float(f"{floor(value / unit * (1.0 + 1e-12)) * unit:.{digits}g}")
