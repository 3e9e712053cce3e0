"""Windows of fast motion, told by the gaps in time between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Window = tuple[int, int]  # first and last time [ns]

_GAP = 10  # steps, of which a longer one is no step
_SHOWN_SAMPLES = 2048  # of contact motion at first: some thirty periods
_MOST = 4  # windows that are kept; more would be too many views


def stretch_starts(time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each sample, where its unbroken stretch begins: windows are apart in time."""
    steps = np.diff(time_ns, prepend=time_ns[:1])
    breaks = steps > _GAP * np.median(steps)
    return np.maximum.accumulate(np.where(breaks, np.arange(len(steps)), 0))


class Stretches:
    """The latest windows of a channel, each no longer than is readable at first sight."""

    def __init__(self) -> None:
        self._times: list[NDArray[np.int64]] = []

    def extend(self, time_ns: NDArray[np.int64]) -> None:
        """Take the times of the next samples."""
        if not len(time_ns):
            return
        before = self._times.pop() if self._times else time_ns[:0]
        joined = np.concatenate((before, time_ns))
        cuts = np.unique(stretch_starts(joined))[1:]
        parts = [part[-_SHOWN_SAMPLES:].copy() for part in np.split(joined, cuts)]
        self._times = [*self._times, *parts][-_MOST:]

    def windows(self) -> list[Window]:
        """First and last time of each, in order."""
        return [(int(times[0]), int(times[-1])) for times in self._times]
