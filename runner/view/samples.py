"""Samples that views keep: extremes of long series, parts of paths, windows of fast motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats

# A viewer moves fluently through several series of 2^18 samples. Of two contacts with 10^6 samples
# each, whole series take twice as long to show and twice the space of extremes.
DENSE_SAMPLES = 2**18

Window = tuple[int, int]  # first and last time [ns]
Span = tuple[float, float]  # least and largest value

_KEPT_SAMPLES = 8192  # of a channel: longer paths are slow without a GPU


class Envelope:
    """Thins a series as it grows: n samples leave some `dense` log2(n / dense) / 2 rows.

    The first `dense` samples, a multiple of 4, pass. From then on two rows, the least and the
    greatest values, stand for each 4 samples; for each 8 once the series is twice as long; and so
    on. Rerun thins what it draws by the same extremes, but stores and loads every sample. The rows
    do not depend on how the samples are divided into batches.
    """

    def __init__(self, dense: int = DENSE_SAMPLES) -> None:
        self._dense = dense
        self._seen = 0
        self._waiting: tuple[NDArray[np.int64], Floats] | None = None

    def extend(self, time_ns: NDArray[np.int64], rows: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Add samples, times (n,) [ns] and values (n, n_fields); return the rows to show."""
        done = [(time_ns[:0], rows[:0])]
        while len(rows):
            doublings = int(self._seen // self._dense).bit_length()
            part = slice(0, (self._dense << doublings) - self._seen)
            done.append(self._reduce(time_ns[part], rows[part], 2 << doublings))
            self._seen += len(rows[part])
            time_ns, rows = time_ns[part.stop :], rows[part.stop :]
        times, values = zip(*done, strict=True)
        return np.concatenate(times), np.concatenate(values)

    def rest(self) -> tuple[NDArray[np.int64], Floats] | None:
        """Return the last samples, too few for a pair of extremes; None without any."""
        return self._waiting

    def _reduce(
        self, time_ns: NDArray[np.int64], rows: Floats, width: int
    ) -> tuple[NDArray[np.int64], Floats]:
        """Return the extremes of each `width` samples; keep the remaining samples."""
        if self._seen < self._dense:
            return time_ns, rows
        if self._waiting is not None:
            time_ns = np.concatenate((self._waiting[0], time_ns))
            rows = np.concatenate((self._waiting[1], rows))
        whole = len(rows) - len(rows) % width
        self._waiting = (time_ns[whole:], rows[whole:])
        groups = rows[:whole].reshape(-1, width, rows.shape[1])
        extremes = np.stack((groups.min(axis=1), groups.max(axis=1)), axis=1)
        return time_ns[: whole : width // 2], extremes.reshape(-1, rows.shape[1])


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

    def over(self, parts: Iterable[tuple[str, Sequence[int]]]) -> Span:
        """Return the least and largest value in columns of several channels; 0 without samples."""
        found = [(self._found[topic], columns) for topic, columns in parts if topic in self._found]
        low = min((float(low[list(columns)].min()) for (low, _), columns in found), default=0.0)
        high = max((float(high[list(columns)].max()) for (_, high), columns in found), default=0.0)
        return low, high


class Latest:
    """The latest rows of time [ns] and values, and the latest windows."""

    def __init__(self) -> None:
        self._seen = 0
        self._windows: list[NDArray[np.int64]] = []  # the times that are shown of each
        self._rows = np.empty((0, 0))

    def extend(self, rows: Floats) -> None:
        """Add rows."""
        if not len(rows):
            return
        self._seen += len(rows)
        kept = [self._rows, rows] if len(self._rows) else [rows]
        self._rows = np.concatenate(kept)[-_KEPT_SAMPLES:].copy()
        before = self._windows.pop() if self._windows else np.empty(0, np.int64)
        times = np.concatenate((before, rows[:, 0].astype(np.int64)))
        parts = np.split(times, np.unique(window_starts(times))[1:])
        # a plot shows the end of a window at first: some thirty periods
        self._windows += [part[-2048:].copy() for part in parts]
        self._windows = self._windows[-4:]  # with plots of their own

    def rows(self) -> Floats:
        """Return the rows that are kept."""
        return self._rows

    def windows(self) -> list[Window]:
        """Return the first and last time that are shown of each window; none of a long series."""
        shown = self._windows if self._seen <= DENSE_SAMPLES else []
        return [(int(times[0]), int(times[-1])) for times in shown]


class Thinned:
    """Rows of time and values, every second of which goes when they become too many."""

    def __init__(self) -> None:
        self._seen = 0
        self._stride = 1
        self._blocks: list[Floats] = []

    def extend(self, rows: Floats) -> None:
        """Add rows."""
        self._blocks.append(rows[-self._seen % self._stride :: self._stride])
        self._seen += len(rows)
        while sum(map(len, self._blocks)) > _KEPT_SAMPLES:
            self._blocks = [self.rows()[::2].copy()]
            self._stride *= 2

    def rows(self) -> Floats:
        """Return the rows that are kept."""
        return np.concatenate(self._blocks) if self._blocks else np.empty((0, 0))


def window_starts(time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return for each sample the number of the first sample of its window."""
    steps = np.diff(time_ns, prepend=time_ns[:1])
    breaks = steps > 10 * np.median(steps)  # a longer pause separates windows
    return np.maximum.accumulate(np.where(breaks, np.arange(len(steps)), 0))
