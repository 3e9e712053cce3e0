"""Sending of recordings to Rerun: an .rrd file with its views embedded, or a viewer."""

from __future__ import annotations

import errno
import logging
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import Level
from slipmode.rom.storage.files import create_file
from slipmode.runner.recording.channels import Channel, Event
from slipmode.runner.recording.record import Header, Sink, checked_batch
from slipmode.runner.view import views
from slipmode.runner.view.labels import shown_channels
from slipmode.runner.view.phase_portraits import Paths
from slipmode.runner.view.samples import Envelope
from slipmode.runner.view.viewer import FLUSH_SECONDS, Viewer, application

_log = logging.getLogger("slipmode.view")


class RerunSink(Sink):
    """Writes an .rrd file with its views embedded, or shows the recording in a viewer.

    Views are in the units of `shown_channels`. Of a series longer than `DENSE_SAMPLES` the later
    part is shown by its extremes, so that views stay fluent. A `live` recording ends with a
    warning if the viewer goes away, any other with OSError.
    """

    def __init__(
        self,
        target: str | Path | Viewer,
        header: Header,
        channels: Sequence[Channel],
        playing: views.Playing | None = None,
        *,
        live: bool = False,
    ) -> None:
        self._target = target if isinstance(target, Viewer) else Path(target)
        self._playing = playing
        self._live = live
        self._recorded = {channel.topic: channel for channel in channels}
        self._shown = shown_channels(channels, header)
        shown = [each.channel for each in self._shown]
        self._paths = Paths(shown)
        self._envelopes = {each.topic: Envelope() for each in shown}
        # a viewer keeps the layout of this recording alone by the name of its application
        described = header.title, header.scene_text, dict(header.run), [*self._recorded], playing
        self._stream = rr.RecordingStream(application(*described))
        self._filled: set[str] = set()  # topics that have samples: no view stays empty
        self._events: list[Event] = []
        self._closed = False
        self._unflushed = 0
        # Rerun reports no errno of its own; the file stays open for its lock
        self._file = create_file(self._target) if isinstance(self._target, Path) else None
        blueprint = views.blueprint(shown, playing=playing)
        with self._ending():
            if isinstance(self._target, Path):
                self._stream.save(self._target, default_blueprint=blueprint)
            else:
                self._stream.connect_grpc(self._target.url, default_blueprint=blueprint)
        self._stream.send_recording_name(header.title)
        views.describe(self._stream, shown, header.scene_text)

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples; see `Sink.write`."""
        if self._closed:
            return
        source, time_ns, recorded = checked_batch(self._recorded, topic, time, values)
        self._make_room(2 * (recorded.nbytes + self._unflushed))
        for channel, _, columns, factors in (e for e in self._shown if e.source == source):
            rows = recorded[:, columns] * factors
            self._paths.extend(channel.topic, time_ns, rows)
            if len(rows):
                self._filled.add(channel.topic)
            self._send(channel, *self._envelopes[channel.topic].extend(time_ns, rows))

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""
        if self._closed:
            return
        self._events.append(Event(time, level, message))
        views.send_event(self._stream, self._events)

    def close(self) -> None:
        """Draw portraits and surfaces, whose extent is known only now, and complete the file."""
        if self._closed:
            return
        shown = {each.channel.topic: each.channel for each in self._shown}
        for topic, envelope in self._envelopes.items():
            if rest := envelope.rest():
                self._send(shown[topic], *rest)
        final = self._paths.draw(self._stream)
        filled = [channel for topic, channel in shown.items() if topic in self._filled]
        views.explain(self._stream, filled, final)
        self._stream.send_blueprint(views.blueprint(filled, final, self._playing))
        self._flush()
        self._end()

    def _send(self, channel: Channel, time_ns: NDArray[np.int64], rows: Floats) -> None:
        for start in range(0, len(rows), 8192):  # what Rerun takes fastest
            part = slice(start, start + 8192)
            views.send_series(self._stream, channel, time_ns[part], rows[part])
        self._unflushed += rows.nbytes
        if self._unflushed > 2**24:  # bytes, what may wait in memory for the writing thread
            self._flush()

    def _make_room(self, size: int) -> None:
        """Stop before the disk is full: Rerun's writing thread would fail without a word."""
        if isinstance(self._target, Path):
            free = shutil.disk_usage(self._target.absolute().parent).free
            if free < size + 2**23:  # for the drawings and the index, which come last
                self._end()
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._target))

    def _end(self) -> None:
        self._closed = True
        self._stream.disconnect()
        if self._file is not None:
            self._file.close()

    def _flush(self) -> None:
        self._unflushed = 0
        with self._ending():
            self._stream.flush(timeout_sec=FLUSH_SECONDS)

    @contextmanager
    def _ending(self) -> Iterator[None]:
        """End at the first failure of Rerun; raise OSError with the target's name, or warn."""
        try:
            yield
        except RuntimeError as error:
            self._end()
            reason = str(error).splitlines()[0]
            if self._live:
                _log.warning("Rerun cannot write: %s; the run goes on without the viewer", reason)
                return
            where = "the viewer" if isinstance(self._target, Viewer) else str(self._target)
            raise OSError(errno.EIO, f"Rerun cannot write: {reason}", where) from error
