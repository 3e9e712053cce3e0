"""Reading a recording back from MCAP, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import NamedTuple

import numpy as np
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet
from google.protobuf.message import DecodeError
from mcap import records
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError, UnknownChannelError
from slipmode.rom.short_repr import short_list, short_repr
from slipmode.runner.recording import overview
from slipmode.runner.recording.channels import EVENTS, Channel, Event, Field, decode_event
from slipmode.runner.recording.mcapfile.chunk import Contents, Messages
from slipmode.runner.recording.mcapfile.prefetch import Unpacked, take_all
from slipmode.runner.recording.mcapfile.source import opened
from slipmode.runner.recording.mcapfile.statistics import Statistics
from slipmode.runner.recording.record import SCENE_FILE, Header

_NANOSECONDS = 1e9


class Signals(NamedTuple):
    """What was recorded on one channel; `column` takes one of them.

    Attributes
    ----------
    channel : Channel
        Names, units and description.
    time : ndarray, shape (n,)
        Simulation time [s].
    values : ndarray, shape (n, n_fields)
        One row per sample, in the units of the channel.
    """

    channel: Channel
    time: Floats
    values: Floats

    def __repr__(self) -> str:
        return short_repr(self)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each field, by its name."""
        return {field.name: field.unit for field in self.channel.fields}

    def column(self, name: str) -> Floats:
        """Values of the field of a name, shape (n,)."""
        if name not in self.channel.names:
            raise SlipmodeError(
                f"{self.channel.topic} has no field {name}: {', '.join(self.channel.names)}"
            )
        return self.values[:, self.channel.names.index(name)]


class Channels(dict[str, Signals]):
    """Signals by topic; a topic that is not there raises an error that lists the topics."""

    def __missing__(self, topic: object) -> Signals:
        known = ", ".join(self) or "none"
        raise UnknownChannelError(f"{topic}: no such channel; the recording has {known}")


@dataclass(frozen=True)
class RecordingData:
    """A recording in memory.

    Parameters
    ----------
    header : Header
        Title, scene and metadata of the run.
    channels : dict of str to Signals
        By topic.
    events : list of Event
        In order of writing.
    damage : str
        What is wrong with the file, of which this is then what was whole; "" for a sound one.
    left_out : tuple of str
        Channels that cannot be read: topic, encoding and schema.
    external : bool
        Whether another program wrote it.
    """

    header: Header
    channels: dict[str, Signals]
    events: list[Event]
    damage: str = ""
    left_out: tuple[str, ...] = ()
    external: bool = False

    def __repr__(self) -> str:
        whole = "complete" if self.complete else "incomplete"
        return (
            f"RecordingData({self.header.title!r}: {short_list(self.channels) or 'no channels'}; "
            f"to t = {self.end_time:g} s; {whole})"
        )

    @property
    def complete(self) -> bool:
        """Whether the file is whole, and what it records came to its end."""
        return not self.damage and all(event.level != "error" for event in self.events)

    @property
    def scene_text(self) -> str:
        """The scene as it was run, in TOML."""
        return self.header.scene_text

    @property
    def end_time(self) -> float:
        """Last simulation time of any sample or event [s]; 0 if there is none."""
        ends = [float(signals.time[-1]) for signals in self.channels.values() if signals.time.size]
        return max([*ends, *(event.time for event in self.events)], default=0.0)


def load(path: str | PathLike[str]) -> dict[str, Signals]:
    """The samples of a recording, by channel.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode, or what is left of one.

    Returns
    -------
    dict of str to Signals
        Arrays by topic: ``load("run.mcap")["/modes"].column("A_abs")``, with `time` and `units`.

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not such a recording; and by a look-up of a topic that
        is not in it. The message names the topics that are.
    """
    return read(path).channels


def read(path: str | PathLike[str]) -> RecordingData:
    """Read an MCAP recording, or what is whole of a truncated one.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode.

    Returns
    -------
    RecordingData
        A truncated recording has `complete` false and ends with an event of level "warning"; that
        of a run that was stopped has `complete` false and ends with one of level "error".

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not such a recording.
    """
    gathered = _Gathered()
    with opened(path) as file:
        damage = take_all(file, gathered.take)
        return gathered.recording(damage)


@dataclass
class _Gathered:
    """Records of a file, as they are met."""

    statistics: Statistics = field(default_factory=Statistics)
    layouts: dict[int, Channel] = field(default_factory=dict)
    times: dict[int, list[NDArray[np.uint64]]] = field(default_factory=dict)
    values: dict[int, list[Floats]] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)

    def take(self, record: Unpacked) -> None:
        """Keep what a record says, if it belongs to a recording."""
        if isinstance(record, Contents):
            self.statistics.take_contents(record)
            for number, messages in record.messages.items():
                self._take_messages(number, messages)
        else:
            self.statistics.take(record)

    def _take_messages(self, number: int, messages: Messages) -> None:
        record = self.statistics.channels[number]
        stamps = messages.prefix["log_time"]
        if record.topic == EVENTS:
            for data, stamp in zip(messages.each(), stamps.tolist(), strict=True):
                try:
                    self.events.append(decode_event(data, stamp))
                except (DecodeError, IndexError) as error:
                    raise SlipmodeError(f"{EVENTS} holds something else than events") from error
        elif (channel := self._layout(record)) is not None:
            self.times.setdefault(number, []).append(stamps)
            self.values.setdefault(number, []).append(channel.decode(messages.data()))

    def _layout(self, record: records.Channel) -> Channel | None:
        """Fields of a channel, None for one that holds no samples of ours."""
        if record.id not in self.layouts:
            found = sample_channel(record, self.statistics.schemas.get(record.schema_id))
            if found is None:
                return None
            self.layouts[record.id] = found
        return self.layouts[record.id]

    def recording(self, damage: str) -> RecordingData:
        """The recording that the records describe."""
        if "units" not in self.statistics.metadata:
            raise SlipmodeError("no slipmode recording")
        for complaint in self.statistics.mixed_clocks():
            raise SlipmodeError(complaint)
        channels, left_out = Channels(), []
        for number, record in self.statistics.channels.items():
            if record.topic in (EVENTS, overview.TOPIC):
                continue
            channel = self._layout(record)
            if channel is None:
                left_out.append(kind_of(record, self.statistics.schemas.get(record.schema_id)))
                continue
            none = np.empty((0, len(channel.fields)))
            time = np.concatenate([none[:, 0], *self.times.get(number, [])])
            values = np.concatenate([none, *self.values.get(number, [])])
            channels[record.topic] = Signals(channel, time / _NANOSECONDS, values)
        scene = self.statistics.metadata.get("scene", {})
        header = Header(
            title=scene.get("title", ""),
            scene_text=self.statistics.attachments.get(SCENE_FILE, b"").decode(errors="replace"),
            run=self.statistics.metadata.get("run", {}),
            scene_name=scene.get("name", ""),
        )
        data = RecordingData(header, channels, self.events, damage, tuple(left_out))
        if damage:
            data.events.append(truncation(data.end_time))
        return data


def sample_channel(record: records.Channel, schema: records.Schema | None) -> Channel | None:
    """Fields of a channel with their units; None for one that holds no samples of ours.

    Raises
    ------
    SlipmodeError
        If its schema is not one of samples.
    """
    if record.message_encoding != "protobuf" or record.topic == EVENTS:
        return None
    try:
        proto = FileDescriptorSet.FromString(b"" if schema is None else schema.data)
        message = proto.file[-1].message_type[0]
        units = record.metadata
        fields = tuple(Field(member.name, units[member.name]) for member in message.field)
    except (DecodeError, IndexError, KeyError) as error:
        raise SlipmodeError(f"{record.topic} has not the schema of samples with units") from error
    if any(member.type != FieldDescriptorProto.TYPE_DOUBLE for member in message.field):
        raise SlipmodeError(f"{record.topic} has a schema of other than numbers")
    return Channel(record.topic, fields, record.metadata.get("description", ""))


def kind_of(record: records.Channel, schema: records.Schema | None) -> str:
    """Topic of a channel, with its encoding and the name of its schema."""
    schema_name = "" if schema is None else f" {schema.name}"
    return f"{record.topic} ({record.message_encoding or 'no encoding'}{schema_name})"


def truncation(end: float) -> Event:
    """The event that says up to which time [s] a damaged recording was read."""
    text = f"the recording was cut short: it was read up to its last whole part, t = {end:g} s"
    return Event(end, "warning", text)
