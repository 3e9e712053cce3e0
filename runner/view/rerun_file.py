"""An .rrd file that Rerun writes from a little later on: importing Rerun takes a while."""

from __future__ import annotations

import time as wall
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from slipmode.runner.recording.channels import Channel, Level
from slipmode.runner.recording.record import Header, Sink, create_file

LATE_SECONDS = 0.1  # of wall time; by then an MCAP file beside has its first samples on disk


class RerunFile(Sink):
    """A `RerunSink` that is opened once a run is under way, at the latest when it is closed.

    What is written before is kept in memory until then. A file that cannot be written is
    refused at once.

    Parameters
    ----------
    path : path
    header : Header
        What the recording says of itself.
    channels : sequence of Channel
        What will be written.
    """

    def __init__(self, path: str | Path, header: Header, channels: Sequence[Channel]) -> None:
        self._arguments = (Path(path), header, channels)
        self._file = create_file(Path(path))
        self._open_at = wall.monotonic() + LATE_SECONDS
        self._kept: list[Callable[[Sink], None]] = []
        self._sink: Sink | None = None

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples; see `Sink.write`."""
        if self._keeps():
            batch = topic, np.array(time), np.array(values)
            self._kept.append(lambda sink: sink.write(*batch))
        else:
            self._opened().write(topic, time, values)

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""
        if self._keeps():
            self._kept.append(lambda sink: sink.event(time, level, message))
        else:
            self._opened().event(time, level, message)

    def close(self) -> None:
        """Complete the file. Closing again, or after a failed write, does nothing."""
        self._opened().close()

    def _keeps(self) -> bool:
        return self._sink is None and wall.monotonic() < self._open_at

    def _opened(self) -> Sink:
        if self._sink is None:
            from slipmode.runner.view.rerun_sink import RerunSink

            self._sink = RerunSink(*self._arguments, file=self._file)
            kept, self._kept = self._kept, []
            for pass_on in kept:
                pass_on(self._sink)
        return self._sink
