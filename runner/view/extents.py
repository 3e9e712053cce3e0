"""Which values and times the plots of a recording show, so that their scales can be read."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats

Span = tuple[float, float]

# A plot is about 110 pixels high. Rerun labels the multiples of a power of ten that are at least
# 25 pixels apart.
_LABELLED = 4.4
_MARGIN = 1.05  # of a scale, relative to the largest value


class Extents:
    """The least and largest values of every channel, and the first and last time [ns]."""

    def __init__(self) -> None:
        self.times: tuple[int, int] | None = None
        self._found: dict[str, tuple[Floats, Floats]] = {}

    def extend(self, topic: str, time_ns: NDArray[np.int64], rows: Floats) -> None:
        """Take note of samples of a channel, times (n,) and values (n, n_fields)."""
        if not len(rows):
            return
        first, last = self.times or (int(time_ns[0]), int(time_ns[-1]))
        self.times = min(first, int(time_ns[0])), max(last, int(time_ns[-1]))
        low, high = self._found.get(topic, (rows[0], rows[0]))
        self._found[topic] = np.fmin(low, rows.min(axis=0)), np.fmax(high, rows.max(axis=0))

    def of(self, topic: str, columns: Sequence[int]) -> Span:
        """Return the least and largest value in columns of a channel; zeros without samples."""
        if topic not in self._found:
            return 0.0, 0.0
        low, high = (ends[list(columns)] for ends in self._found[topic])
        return float(np.min(low)), float(np.max(high))

    def over(self, parts: Iterable[tuple[str, Sequence[int]]]) -> Span:
        """Return the least and largest value in columns of several channels."""
        low, high = zip(*(self.of(topic, columns) for topic, columns in parts), strict=True)
        return min(low), max(high)


def readable_scale(low: float, high: float) -> Span | None:
    """Return the ends of a scale with at least two labels for values from `low` to `high`.

    None for values that are all of one sign and far from zero: a viewer fits these better.
    """
    if not np.isfinite((low, high)).all() or low == high == 0.0:
        return None
    if low > 0.5 * high or high < 0.5 * low:
        return None
    low, high = _MARGIN * min(low, 0.0), _MARGIN * max(high, 0.0)
    unit = 10.0 ** floor(log10(max(high, -low)))
    if high - low > _LABELLED * unit:  # zero would have the only label: as far as the next power
        largest = _MARGIN * 10.0 * unit
        low = -largest if -low > 0.6 * largest else low
        high = largest if low == 0.0 or high > 0.6 * largest else high
    return low, high


def with_room(start: int, end: int) -> tuple[int, int]:
    """Return the times [ns] of a plot whose legend stands to the right of its curves."""
    return start, end + (end - start) // 2
