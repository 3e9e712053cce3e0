"""Reading a recording back from MCAP, and showing it in Rerun."""

from __future__ import annotations

import os
import socket
import struct
import tempfile
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError
from mcap import records
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader, breakup_chunk
from numpy.typing import NDArray
from rerun.experimental import ViewerClient
from zstandard import ZstdError

from rom.errors import SlipmodeError
from runner.channels import EVENTS, Channel, Event, Field, decode_event
from runner.planes import TIMELINE
from runner.record import SCENE_FILE, Header
from runner.rerun_sink import RerunSink
from runner.views import VIEWER

# What the reader raises where a file ends, or is damaged, in the middle of a record.
_DAMAGE = (McapError, ZstdError, DecodeError, struct.error, ValueError, OverflowError, MemoryError)

_VIEWER_PACKAGES = (
    "mesa-vulkan-drivers libvulkan1 libgl1-mesa-dri libegl1 libxkbcommon0 fonts-dejavu-core"
)
_SETTLING_TIME = 20.0  # [s] at most, until the picture stands still


@dataclass(frozen=True)
class RecordingData:
    """A recording in memory.

    Parameters
    ----------
    header : Header
        Title, scene and metadata of the run.
    channels : dict of str to (Channel, ndarray of shape (n,), ndarray of shape (n, n_fields))
        Per topic the channel, simulation times [s] and values in the units of the channel.
    events : list of Event
        In order of writing.
    complete : bool
        Whether the file was closed; otherwise this is what was whole of it.
    """

    header: Header
    channels: dict[str, tuple[Channel, NDArray[np.float64], NDArray[np.float64]]]
    events: list[Event]
    complete: bool

    @property
    def scene_text(self) -> str:
        """The scene as it was run, in TOML."""
        return self.header.scene_text


def read(path: str | Path) -> RecordingData:
    """Read an MCAP recording, or what is whole of a truncated one.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode.

    Returns
    -------
    RecordingData
        A truncated recording has `complete` false and ends with an event of level "warning".

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not such a recording.
    """
    path = Path(path)
    contents = _Contents()
    try:
        with path.open("rb") as file:
            _check_magic(file, path)
            contents.collect(file)
    except OSError as error:
        raise SlipmodeError(f"{path}: {error.strerror}") from error
    if "units" not in contents.metadata:
        raise SlipmodeError(f"{path} holds no slipmode recording")
    try:
        return contents.recording()
    except _DAMAGE as error:
        raise SlipmodeError(f"{path}: {error}") from error


def replay(
    path: str | Path, save: str | Path | None = None, screenshot: str | Path | None = None
) -> None:
    """Show an MCAP recording in Rerun, as the run itself would have shown it.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode.
    save : path, optional
        Write an .rrd file, views included, instead of opening the viewer.
    screenshot : path, optional
        Write a PNG of all views at the end of the recording, without a window.

    Raises
    ------
    SlipmodeError
        If `path` cannot be read, or no viewer can be started for the screenshot.
    OSError
        If `save` or `screenshot` cannot be written.
    """
    data = read(path)
    if save is not None or screenshot is None:
        _convert(data, save)
    if screenshot is not None:
        with tempfile.TemporaryDirectory() as folder:
            rrd = Path(folder) / "recording.rrd"
            _convert(data, rrd)
            picture = _photograph(rrd, _end_time(data))
        Path(screenshot).write_bytes(picture)


@dataclass
class _Contents:
    """Records of an MCAP file, gathered in the order in which they are met."""

    schemas: dict[int, records.Schema] = field(default_factory=dict)
    channels: dict[int, records.Channel] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    scene_text: str = ""
    stamps: dict[int, list[int]] = field(default_factory=dict)
    messages: dict[int, list[bytes]] = field(default_factory=dict)
    complete: bool = False

    def collect(self, file: BinaryIO) -> None:
        """Take every whole record up to the end of the file, or to the first damage."""
        reader = StreamReader(file, emit_chunks=True)
        try:
            for record in reader.records:
                self._take(record)
            self.complete = True
        except _DAMAGE:
            self.complete = False

    def _take(self, record: records.McapRecord) -> None:
        match record:
            case records.Chunk():
                for inner in breakup_chunk(record, validate_crc=True):
                    self._take(inner)
            case records.Message():
                self.stamps.setdefault(record.channel_id, []).append(record.log_time)
                self.messages.setdefault(record.channel_id, []).append(record.data)
            case records.Schema():
                self.schemas[record.id] = record
            case records.Channel():
                self.channels[record.id] = record
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Attachment() if record.name == SCENE_FILE:
                self.scene_text = record.data.decode()

    def recording(self) -> RecordingData:
        """The recording that the records describe."""
        channels = {}
        events: list[Event] = []
        for number, record in self.channels.items():
            stamps = self.stamps.get(number, [])
            messages = self.messages.get(number, [])
            if record.topic == EVENTS:
                events = [decode_event(*pair) for pair in zip(messages, stamps, strict=True)]
                continue
            channel = _channel(record, self.schemas[record.schema_id])
            time = np.array(stamps, dtype=np.int64) / 1e9
            channels[record.topic] = (channel, time, channel.decode(messages))
        scene = self.metadata.get("scene", {})
        header = Header(
            title=scene.get("title", ""),
            scene_text=self.scene_text,
            run=self.metadata.get("run", {}),
            scene_name=scene.get("name", ""),
        )
        data = RecordingData(header, channels, events, self.complete)
        if not self.complete:
            events.append(_truncation(data))
        return data


def _truncation(data: RecordingData) -> Event:
    end = _end_time(data)
    text = f"the recording was cut short: it was read up to its last whole part, t = {end:g} s"
    return Event(end, "warning", text)


def _end_time(data: RecordingData) -> float:
    """Last simulation time of any sample or event [s]; 0 if there is none."""
    ends = [float(time[-1]) for _, time, _ in data.channels.values() if time.size]
    return max([*ends, *(event.time for event in data.events)], default=0.0)


def _check_magic(file: BinaryIO, path: Path) -> None:
    magic = file.read(8)
    file.seek(0)
    if magic != b"\x89MCAP0\r\n":
        raise SlipmodeError(f"{path} is not an MCAP file")


def _channel(record: records.Channel, schema: records.Schema) -> Channel:
    message = FileDescriptorSet.FromString(schema.data).file[-1].message_type[0]
    fields = tuple(Field(field.name, record.metadata[field.name]) for field in message.field)
    return Channel(record.topic, fields, record.metadata.get("description", ""))


def _convert(data: RecordingData, path: str | Path | None) -> None:
    """Write a recording to an .rrd file, or to a new viewer where there is no path."""
    channels = [channel for channel, _, _ in data.channels.values()]
    with RerunSink(path, data.header, channels) as sink:
        for topic, (_, time, values) in data.channels.items():
            sink.write(topic, time, values)
        for event in data.events:
            sink.event(event.time, event.level, event.message)


def _photograph(rrd: Path, time: float) -> bytes:
    """PNG of a recording at simulation time `time`, by a viewer without a window."""
    try:
        with _quiet_viewer() as viewer:
            viewer.open(str(rrd))
            viewer.set_time(TIMELINE, duration=time, play_state="paused")
            return _settled(viewer)
    except (RuntimeError, ConnectionError) as error:
        raise SlipmodeError(
            "no viewer could be started for the screenshot: it needs a graphics driver, "
            f"on Debian: apt-get install {_VIEWER_PACKAGES}"
        ) from error


def _settled(viewer: ViewerClient) -> bytes:
    """Picture that two shots in a row agree on: views take a few frames to fill."""
    deadline = clock.monotonic() + _SETTLING_TIME
    picture = viewer.take_screenshot()
    while clock.monotonic() < deadline:
        clock.sleep(0.3)
        previous, picture = picture, viewer.take_screenshot()
        if picture == previous:
            break
    return picture


@contextmanager
def _quiet_viewer() -> Iterator[ViewerClient]:
    """A viewer without a window, which ends with the context and logs errors only."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    log_filter = os.environ.get("RUST_LOG")
    os.environ["RUST_LOG"] = "off"
    try:
        viewer = ViewerClient.spawn(headless=True, port=port, executable_path=VIEWER)
    finally:
        if log_filter is None:
            del os.environ["RUST_LOG"]
        else:
            os.environ["RUST_LOG"] = log_filter
    with viewer:
        yield viewer
