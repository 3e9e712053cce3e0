"""Showing a run in a viewer while it is being recorded."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from numpy.typing import ArrayLike

from slipmode.runner.recording.channels import Channel, Level
from slipmode.runner.recording.record import Header, Sink
from slipmode.runner.view.rerun_sink import RerunSink
from slipmode.runner.view.viewer import Viewer

_log = logging.getLogger("slipmode.view")


class LiveSink(Sink):
    """Sends a recording to a viewer; one that goes away does not end the run.

    Parameters
    ----------
    viewer : Viewer
        Where to show it.
    header, channels
        As for `McapSink`.
    """

    def __init__(self, viewer: Viewer, header: Header, channels: Sequence[Channel]) -> None:
        self._sink: RerunSink | None = None
        with self._leaving():
            self._sink = RerunSink(viewer, header, channels)

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Show a batch of samples; see `Sink.write`."""
        with self._leaving():
            if self._sink is not None:
                self._sink.write(topic, time, values)

    def event(self, time: float, level: Level, message: str) -> None:
        """Show in words what happened at simulation time `time` [s]."""
        with self._leaving():
            if self._sink is not None:
                self._sink.event(time, level, message)

    def close(self) -> None:
        """Show what is drawn at the end. Closing again does nothing."""
        with self._leaving():
            if self._sink is not None:
                self._sink.close()

    @contextmanager
    def _leaving(self) -> Iterator[None]:
        """Go on without the viewer from its first failure on, and say so once."""
        try:
            yield
        except OSError as error:
            self._sink = None
            _log.warning("%s; the run goes on without the viewer", error.strerror)
