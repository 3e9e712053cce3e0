"""Writing a recording: MCAP and Rerun files behind one small protocol."""

from __future__ import annotations

import errno
import os
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import IO, Self

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from mcap.writer import LIBRARY_IDENTIFIER, Writer
from numpy.typing import ArrayLike, NDArray

from rom.errors import SlipmodeError
from runner import views
from runner.channels import (
    EVENT_MESSAGE_TYPE,
    EVENTS,
    Channel,
    Event,
    Level,
    encode_event,
    event_descriptor,
)

SCENE_FILE = "scene.toml"

_CHUNK_BYTES = 1024 * 1024
_ROWS_PER_SEND = 8192  # what Rerun takes fastest
_RESERVED_BYTES = 8 * 1024 * 1024  # for the drawings and the index, which come last
_FLUSH_TIMEOUT = 60.0  # [s]


@dataclass(frozen=True)
class Header:
    """What a recording says of itself.

    Parameters
    ----------
    title : str
        Title of the scene.
    scene_text : str
        The scene as it was run, in TOML.
    run : mapping of str to str
        Metadata of the run: hashes, versions, wall clock.
    scene_name : str
        Short name of the scene.
    """

    title: str
    scene_text: str
    run: Mapping[str, str] = field(default_factory=dict)
    scene_name: str = ""


class Sink(ABC):
    """Where samples go: one file, or several of them.

    Files are opened as ``McapSink(path, header, channels)``: an existing file is replaced, a
    directory is refused with SlipmodeError, a file that cannot be written with OSError.
    """

    @abstractmethod
    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples.

        Parameters
        ----------
        topic : str
            A channel that the sink was opened with.
        time : array_like, shape (n,)
            Simulation time [s], from 0.
        values : array_like, shape (n, n_fields)
            One row per sample, in the units of the channel.

        Raises
        ------
        SlipmodeError
            If a value is not finite, a time negative, or the shape not that of the channel.
        OSError
            If the file cannot be written; it names the file, and what it holds stays readable.
        """

    @abstractmethod
    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""

    @abstractmethod
    def close(self) -> None:
        """Complete the recording. Closing again, or after a failed write, does nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
            return
        with suppress(OSError):  # the error that ended the run is the one to report
            self.close()


class McapSink(Sink):
    """Writes an MCAP file: protobuf samples, units, run metadata and the scene.

    A chunk of samples is in the file as soon as it is full, whatever happens later.

    Parameters
    ----------
    path : path
        File to write.
    header : Header
        What the recording says of itself.
    channels : sequence of Channel
        What will be written.
    """

    def __init__(self, path: str | Path, header: Header, channels: Sequence[Channel]) -> None:
        self._path = Path(path)
        self._channels = {channel.topic: channel for channel in channels}
        self._file = _create(self._path)
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES)
        with self._complaining():
            self._writer.start(library=f"slipmode; {LIBRARY_IDENTIFIER}")
            self._describe(header)
            self._ids = {channel.topic: self._register(channel) for channel in channels}
            self._ids[EVENTS] = self._register_events()
            self._file.flush()

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples; see `Sink.write`."""
        channel = _channel(self._channels, topic)
        time_ns, rows = _checked(channel, time, values)
        with self._complaining():
            for stamp, message in zip(time_ns.tolist(), channel.encode(rows), strict=True):
                self._writer.add_message(self._ids[topic], stamp, message, stamp)
            self._file.flush()

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""
        stamp = int(_nanoseconds(EVENTS, np.array([time]))[0])
        data = encode_event(Event(time, level, message), stamp)
        with self._complaining():
            self._writer.add_message(self._ids[EVENTS], stamp, data, stamp)
            self._file.flush()

    def close(self) -> None:
        """Write what is buffered, the index and the footer."""
        if self._file.closed:
            return
        with self._complaining():
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()

    def _describe(self, header: Header) -> None:
        units = {
            f"{topic}.{field.name}": field.unit
            for topic, channel in self._channels.items()
            for field in channel.fields
        }
        self._writer.add_metadata("run", dict(header.run))
        self._writer.add_metadata("scene", {"title": header.title, "name": header.scene_name})
        self._writer.add_metadata("units", units)
        self._writer.add_attachment(
            create_time=0,
            log_time=0,
            name=SCENE_FILE,
            media_type="application/toml",
            data=header.scene_text.encode(),
        )

    def _register(self, channel: Channel) -> int:
        schema = channel.descriptor().SerializeToString()
        schema_id = self._writer.register_schema(channel.message_type, "protobuf", schema)
        metadata = {field.name: field.unit for field in channel.fields}
        metadata["description"] = channel.description
        return self._writer.register_channel(channel.topic, "protobuf", schema_id, metadata)

    def _register_events(self) -> int:
        schema = event_descriptor().SerializeToString()
        schema_id = self._writer.register_schema(EVENT_MESSAGE_TYPE, "protobuf", schema)
        return self._writer.register_channel(EVENTS, "protobuf", schema_id)

    @contextmanager
    def _complaining(self) -> Iterator[None]:
        """Give up the file at the first failure, and say which file it was."""
        try:
            yield
        except OSError as error:
            with suppress(OSError):
                self._file.close()
            raise OSError(error.errno, error.strerror, str(self._path)) from error


class RerunSink(Sink):
    """Writes an .rrd file with its views embedded, or shows the recording in a new viewer.

    Parameters
    ----------
    path : path or None
        File to write; None opens the viewer instead.
    header, channels
        As for `McapSink`.
    """

    def __init__(
        self, path: str | Path | None, header: Header, channels: Sequence[Channel]
    ) -> None:
        self._path = None if path is None else Path(path)
        self._channels = {channel.topic: channel for channel in channels}
        self._paths = views.Paths(channels)
        self._stream = rr.RecordingStream("slipmode")
        self._closed = False
        self._open(views.blueprint(channels, views.Extent()))
        self._stream.send_recording_name(header.title)
        views.describe(self._stream, channels, header.scene_text)

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples; see `Sink.write`."""
        channel = _channel(self._channels, topic)
        time_ns, rows = _checked(channel, time, values)
        self._make_room(2 * rows.nbytes)
        for start in range(0, len(rows), _ROWS_PER_SEND):
            part = slice(start, start + _ROWS_PER_SEND)
            views.send_series(self._stream, channel, time_ns[part], rows[part])
        self._paths.extend(topic, time_ns, rows)
        self._flush()

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""
        time_ns = _nanoseconds(EVENTS, np.array([time]))
        views.send_event(self._stream, time_ns, level, message)

    def close(self) -> None:
        """Draw paths and loops, whose extent is known only now, and complete the file."""
        if self._closed:
            return
        extent = self._paths.draw(self._stream)
        blueprint = views.blueprint(list(self._channels.values()), extent)
        self._stream.send_blueprint(blueprint)
        self._flush()
        self._closed = True
        self._stream.disconnect()

    def _open(self, blueprint: rrb.Blueprint) -> None:
        if self._path is not None:
            _create(self._path).close()  # Rerun reports no errno of its own
        with self._complaining():
            if self._path is not None:
                self._stream.save(self._path, default_blueprint=blueprint)
            else:
                rr.spawn(
                    executable_path=views.VIEWER,
                    default_blueprint=blueprint,
                    recording=self._stream,
                )

    def _make_room(self, size: int) -> None:
        """Stop before the disk is full: Rerun's writing thread would die of it and not say so."""
        if self._path is not None:
            free = shutil.disk_usage(self._path.absolute().parent).free
            if free < size + _RESERVED_BYTES:
                self._closed = True
                self._stream.disconnect()
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._path))

    def _flush(self) -> None:
        with self._complaining():
            self._stream.flush(timeout_sec=_FLUSH_TIMEOUT)

    @contextmanager
    def _complaining(self) -> Iterator[None]:
        try:
            yield
        except RuntimeError as error:
            self._closed = True
            reason = str(error).splitlines()[0]
            where = str(self._path or "the viewer")
            raise OSError(errno.EIO, f"Rerun cannot write: {reason}", where) from error


class Recorder(Sink):
    """Writes the same recording to several sinks.

    Parameters
    ----------
    sinks : sequence of Sink
        Each gets every sample and every event; closing the recorder closes them all.
    """

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = tuple(sinks)

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples to every sink; see `Sink.write`."""
        for sink in self._sinks:
            sink.write(topic, time, values)

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in every sink what happened at simulation time `time` [s]."""
        for sink in self._sinks:
            sink.event(time, level, message)

    def close(self) -> None:
        """Close every sink, also when one of them fails."""
        with ExitStack() as stack:
            for sink in self._sinks:
                stack.callback(sink.close)


def _create(path: Path) -> IO[bytes]:
    if path.is_dir():
        raise SlipmodeError(f"{path} is a directory: give the name of a file to record to")
    return path.open("wb")


def _channel(channels: Mapping[str, Channel], topic: str) -> Channel:
    if topic not in channels:
        raise SlipmodeError(f"{topic} is not recorded: channels are {', '.join(channels)}")
    return channels[topic]


def _checked(
    channel: Channel, time: ArrayLike, values: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Times in nanoseconds and values of a batch, or the reason why it is refused."""
    seconds, rows = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    expected = (seconds.size, len(channel.fields))
    if seconds.ndim != 1 or rows.shape != expected:
        raise SlipmodeError(f"{channel.topic}: values have shape {rows.shape}, not {expected}")
    finite = np.isfinite(rows)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        name, value = channel.names[column], rows[row, column]
        raise SlipmodeError(f"{channel.topic}: {name} is {value} at t = {seconds[row]:g} s")
    return _nanoseconds(channel.topic, seconds), rows


def _nanoseconds(topic: str, seconds: NDArray[np.float64]) -> NDArray[np.int64]:
    if not np.all((seconds >= 0.0) & (seconds < 2**63 / 1e9)):
        raise SlipmodeError(f"{topic}: times must be finite and not negative")
    return np.rint(seconds * 1e9).astype(np.int64)
