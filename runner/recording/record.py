"""Writing of recordings: sinks, the MCAP file, and what a recording says of its run."""

from __future__ import annotations

import hashlib
import platform
import subprocess
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Self

import numpy as np
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap import records
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import Level, SlipmodeError
from slipmode.rom.storage.files import create_file
from slipmode.runner.messages import one_line
from slipmode.runner.recording.channels import (
    EVENTS,
    NANOSECONDS,
    Channel,
    Event,
    encode_event,
    event_descriptor,
)
from slipmode.runner.recording.mcap_file.writer import McapWriter
from slipmode.runner.recording.overview import SCHEMA, Overview

SCENE_FILE = "scene.toml"


@dataclass(frozen=True)
class Header:
    """Description of a recording within itself."""

    title: str
    scene_text: str  # The scene as it was run, in TOML
    # Metadata of the run: hashes, versions, wall clock
    run: Mapping[str, str] = field(default_factory=dict)
    scene_name: str = ""


def describe_run(scene_text: str, model: Model | None) -> dict[str, str]:
    """Return the metadata of a run, with a model or integrated in full.

    Nothing else in a recording depends on the wall clock.
    """
    run = {"scene_hash": hashlib.sha256(scene_text.encode()).hexdigest()}
    if model is not None:
        run["model_hash"] = model.hash
        run["formulation"] = model.reduced.formulation
        run["table_tolerance"] = f"{model.accuracy.tolerance:g}"
    run |= {package: version(package) for package in ("slipmode", "numpy", "rerun-sdk", "mcap")}
    run["python"] = platform.python_version()
    run["git_revision"] = _revision()
    run["started"] = datetime.now(UTC).isoformat(timespec="seconds")
    return run


def _revision() -> str:
    """Return the git revision of the checkout that slipmode runs from; "" for an installation."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "rev-parse", "HEAD"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False, timeout=5)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip()


class Sink(ABC):
    """A place where samples go.

    Files are opened as ``McapSink(path, header, channels)``: an existing file is replaced. A
    directory, or a file that another run is writing, is refused with SlipmodeError, a file that
    cannot be written with OSError.
    """

    @abstractmethod
    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append samples to a channel that the sink was opened with.

        Simulation times (n,) [s], from 0; values (n, n_fields), in the units of the channel.
        Raises SlipmodeError if a value is not finite, a time is negative, or the shape is wrong;
        OSError, which names the file, if it cannot be written. What was written stays readable.
        """

    @abstractmethod
    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""

    @abstractmethod
    def close(self) -> None:
        """Complete the recording. Closing again, or after a failed write, does nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if error is None:
            self.close()
            return
        with suppress(OSError):  # the error that ended the run is the one to report
            self.close()


class McapSink(Sink):
    """Writes an MCAP file: protobuf samples, units, run metadata and the scene.

    Samples are in the file, where `slipmode recover` finds them after a kill, as soon as they
    fill a chunk (`CHUNK_BYTES`), or with the first sample written `FLUSH_SECONDS` after the
    previous flush.
    """

    def __init__(self, path: str | Path, header: Header, channels: Sequence[Channel]) -> None:
        self._path = Path(path)
        self._channels = {channel.topic: channel for channel in channels}
        self._ids: dict[str, int] = {}
        self._file = create_file(self._path)
        with self._giving_up():
            self._writer = McapWriter(self._file)
            self._describe(header)
            for channel in channels:
                about = channel.units | {"description": channel.description}
                self._register(channel.topic, channel.message_type, channel.descriptor(), about)
            self._register(EVENTS, "foxglove.Log", event_descriptor(), {})
            if "/modes" in self._channels:
                self._overview = Overview(self._channels["/modes"])
                kind = "sensor_msgs/msg/JointState"  # of ROS 2; viewers plot it without a layout
                self._register(Overview.topic, kind, SCHEMA, {})
            self._writer.flush()

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples; see `Sink.write`."""
        channel, time_ns, rows = checked_batch(self._channels, topic, time, values)
        with self._giving_up():
            for start in range(0, len(rows), 1024):  # few enough to stay in a core's own memory
                part = slice(start, start + 1024)
                messages = channel.encode(rows[part])
                self._writer.add_messages(self._ids[topic], time_ns[part], messages)
            if topic == "/modes":
                shown = self._overview.encode(time_ns, rows)
                self._writer.add_messages(self._ids[Overview.topic], *shown)

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in words what happened at simulation time `time` [s]."""
        time_ns = nanoseconds(EVENTS, np.array([time]))
        data = encode_event(Event(time, level, message), int(time_ns[0]))
        with self._giving_up():
            self._writer.add_messages(self._ids[EVENTS], time_ns, np.array([data], np.void))

    def close(self) -> None:
        """Write the unfinished chunk, the index and the footer."""
        if self._file.closed:
            return
        with self._giving_up():
            self._writer.finish()
            self._file.close()

    def _describe(self, header: Header) -> None:
        fields = [(topic, field) for topic, c in self._channels.items() for field in c.fields]
        units = {f"{topic}.{field.name}": field.unit for topic, field in fields}
        scene = {"title": header.title, "name": header.scene_name}
        for name, data in {"run": dict(header.run), "scene": scene, "units": units}.items():
            self._writer.add(records.Metadata(name, data))
        text = header.scene_text.encode()
        self._writer.add(records.Attachment(0, 0, SCENE_FILE, "application/toml", text))

    def _register(
        self, topic: str, message_type: str, schema: FileDescriptorSet | str, about: dict[str, str]
    ) -> None:
        """Give a topic a channel and a schema, protobuf or ROS 2, both of the next number."""
        number = self._ids[topic] = len(self._ids) + 1
        if isinstance(schema, str):
            encoding, schema_encoding, data = "cdr", "ros2msg", schema.encode()
        else:
            encoding, schema_encoding, data = "protobuf", "protobuf", schema.SerializeToString()
        self._writer.add(records.Schema(number, data, schema_encoding, message_type))
        self._writer.add(records.Channel(number, topic, encoding, about, number))

    @contextmanager
    def _giving_up(self) -> Iterator[None]:
        """Close the file at the first failure, and name it in the error."""
        try:
            yield
        except OSError as error:
            with suppress(OSError):
                self._file.close()
            raise OSError(error.errno, error.strerror, str(self._path)) from error


class Recorder(Sink):
    """Writes one recording to several sinks, and closes them all.

    Left by an exception, the recording ends with an event that names it.
    """

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = tuple(sinks)
        self._now = 0.0  # latest simulation time that was written [s]

    def write(self, topic: str, time: ArrayLike, values: ArrayLike) -> None:
        """Append a batch of samples to every sink; see `Sink.write`."""
        self._now = max([self._now, *np.asarray(time, dtype=float)[-1:]])
        for sink in self._sinks:
            sink.write(topic, time, values)

    def event(self, time: float, level: Level, message: str) -> None:
        """Record in every sink what happened at simulation time `time` [s]."""
        self._now = max(self._now, time)
        for sink in self._sinks:
            sink.event(time, level, message)

    def close(self) -> None:
        """Close every sink, one after the other, also when one of them fails."""
        with ExitStack() as stack:
            for sink in reversed(self._sinks):  # the stack calls back from the last one on
                stack.callback(sink.close)

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if error is not None:
            for sink in self._sinks:
                with suppress(Exception):  # the error that ended the run is the one to report
                    sink.event(self._now, "error", one_line(error))
        super().__exit__(kind, error, traceback)


def checked_batch(
    channels: Mapping[str, Channel], topic: str, time: ArrayLike, values: ArrayLike
) -> tuple[Channel, NDArray[np.int64], Floats]:
    """Return the channel, times [ns] and values of a batch.

    Refuse topics that are not in `channels`, values that are not finite, and other shapes.
    """
    if topic not in channels:
        raise SlipmodeError(f"{topic}: is not recorded; channels are {', '.join(channels)}")
    channel = channels[topic]
    seconds, rows = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    expected = (seconds.size, len(channel.fields))
    if seconds.ndim != 1 or rows.shape != expected:
        raise SlipmodeError(f"{topic}: values must have shape {expected}, got {rows.shape}")
    finite = np.isfinite(rows)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        name, value = channel.names[column], rows[row, column]
        raise SlipmodeError(
            f"{topic}: {name} must be finite, got {value} at t = {seconds[row]:g} s"
        )
    return channel, nanoseconds(topic, seconds), rows


def nanoseconds(topic: str, seconds: Floats) -> NDArray[np.int64]:
    """Return simulation times [s] in nanoseconds, rounded to the nearest."""
    if not np.all((seconds >= 0.0) & (seconds < 2**63 / NANOSECONDS)):
        raise SlipmodeError(f"{topic}: times must be finite and not negative")
    return np.rint(seconds * NANOSECONDS).astype(np.int64)
