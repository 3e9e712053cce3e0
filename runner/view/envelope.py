"""Long series for viewers: the first samples one and all, extremes of ever more of them later."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats

DENSE_SAMPLES = 2**18  # that a viewer moves through fluently, with several series of them in view


class Envelope:
    """Thins a series as it grows, so that n samples leave some `dense` log2(n / dense) / 2 rows.

    The first `dense` samples pass. From then on two rows, the least and the greatest values,
    stand for each 4 samples; for each 8 once the series is twice as long; and so on: what a
    plot of the whole series shows stays the same. The rows do not depend on how the samples
    are divided into batches.

    Parameters
    ----------
    dense : int
        Samples that pass; a multiple of 4.
    """

    def __init__(self, dense: int = DENSE_SAMPLES) -> None:
        self._dense = dense
        self._seen = 0
        self._waiting: list[tuple[NDArray[np.int64], Floats]] = []

    @property
    def thinned(self) -> bool:
        """Whether any sample has been left out."""
        return self._seen > self._dense

    def extend(self, time_ns: NDArray[np.int64], rows: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Take the next samples; return the rows that are complete.

        Parameters
        ----------
        time_ns : ndarray, shape (n,)
        rows : ndarray, shape (n, n_fields)

        Returns
        -------
        tuple of ndarray, shapes (m,) and (m, n_fields)
            Times [ns] and values.
        """
        done = []
        while len(rows):
            doublings = int(self._seen // self._dense).bit_length()
            stretch_end = self._dense << doublings
            part = slice(0, stretch_end - self._seen)
            done.append(self._reduce(time_ns[part], rows[part], 2 << doublings))
            self._seen += len(rows[part])
            time_ns, rows = time_ns[part.stop :], rows[part.stop :]
        return _joined(done) if done else (time_ns, rows)

    def rest(self) -> tuple[NDArray[np.int64], Floats] | None:
        """The last samples, which were too few for rows of extremes; None without any."""
        return _joined(self._waiting) if self._waiting else None

    def _reduce(
        self, time_ns: NDArray[np.int64], rows: Floats, width: int
    ) -> tuple[NDArray[np.int64], Floats]:
        """Extremes of each `width` samples, beginning with those that wait for company."""
        if self._seen < self._dense:
            return time_ns, rows
        time_ns, rows = _joined([*self._waiting, (time_ns, rows)])
        whole = len(rows) - len(rows) % width
        self._waiting = [(time_ns[whole:], rows[whole:])]
        groups = rows[:whole].reshape(-1, width, rows.shape[1])
        extremes = np.stack((groups.min(axis=1), groups.max(axis=1)), axis=1)
        return time_ns[: whole : width // 2], extremes.reshape(-1, rows.shape[1])


def _joined(
    parts: list[tuple[NDArray[np.int64], Floats]],
) -> tuple[NDArray[np.int64], Floats]:
    times, rows = zip(*parts, strict=True)
    return np.concatenate(times), np.concatenate(rows)
