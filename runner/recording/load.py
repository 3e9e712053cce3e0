"""Reading of recordings as arrays, whole or in part."""

from __future__ import annotations

import math
import warnings
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from os import PathLike
from typing import NamedTuple, Self

import numpy as np
from google.protobuf.message import DecodeError

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError, UnknownChannelError
from slipmode.rom.short_repr import short_list, short_repr
from slipmode.runner.recording.channels import (
    EVENTS,
    NANOSECONDS,
    Channel,
    Event,
    decode_event,
)
from slipmode.runner.recording.inventory import opened
from slipmode.runner.recording.mcap_file.reader import Messages
from slipmode.runner.recording.mcap_file.records import DamagedError
from slipmode.runner.recording.overview import Overview
from slipmode.runner.recording.record import Header

_EVENT_BYTES = 512  # of memory for an event, besides its text


class DamagedRecordingWarning(UserWarning):
    """Warn that a part of a recording is missing."""


class Signals(NamedTuple):
    """Hold the samples of one channel.

    Attributes
    ----------
    channel : Channel
        Topic, description, and names and units of the fields.
    time : (n,) ndarray
        Simulation times [s].
    values : (n, fields) ndarray
        One row for each sample, in the units of the fields.
    """

    channel: Channel
    time: Floats
    values: Floats

    def __repr__(self) -> str:
        return short_repr(self)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each field, by its name."""
        return self.channel.units

    def column(self, name: str) -> Floats:
        """Return the samples of one field.

        Parameters
        ----------
        name : str
            Name of the field.

        Returns
        -------
        (n,) ndarray
            Samples, in the unit of the field.

        Raises
        ------
        SlipmodeError
            If the channel has no such field.
        """
        if name not in self.channel.names:
            raise SlipmodeError(
                f"{self.channel.topic} has no field {name}: {', '.join(self.channel.names)}"
            )
        return self.values[:, self.channel.names.index(name)]


class Channels(dict[str, Signals]):
    """Signals by topic; an unknown topic raises an error that lists the topics."""

    def __missing__(self, topic: object) -> Signals:
        known = ", ".join(self) or "none"
        raise UnknownChannelError(f"{topic}: no such channel; the recording has {known}")


@dataclass(frozen=True)
class RecordingData:
    """A recording in memory."""

    header: Header
    channels: dict[str, Signals]  # By topic
    events: list[Event]  # In order of writing
    damage: str = ""  # Why the file is not whole
    left_out: tuple[str, ...] = ()  # Channels that cannot be read: topic, encoding and schema
    external: bool = False  # Whether another program wrote it

    def __repr__(self) -> str:
        whole = "complete" if self.complete else "incomplete"
        return (
            f"RecordingData({self.header.title!r}: {short_list(self.channels) or 'no channels'}; "
            f"to t = {self.end_time:g} s; {whole})"
        )

    def with_its_end(self) -> Self:
        """Return this recording; if it is damaged, its last event says so."""
        if self.damage:
            self.events.append(Event(self.end_time, "warning", self.missing()))
        return self

    def missing(self, done: str = "read") -> str:
        """Return what a reader of a damaged recording must know; empty if it is whole."""
        if not self.damage:
            return ""
        how_far = f"{done} up to t = {self.end_time:g} s; slipmode recover may find more"
        return f"cut short or damaged: {self.damage}; {how_far}"

    @property
    def complete(self) -> bool:
        """Whether the file is whole, and the run came to its end."""
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


@dataclass(frozen=True)
class Selection:
    """A part of a recording; SlipmodeError if the times are not in order."""

    topics: Sequence[str] = ()  # Channels; all of them if empty
    start: float = -math.inf  # First and last simulation time [s]
    end: float = math.inf

    def __post_init__(self) -> None:
        if not self.start <= self.end:
            raise SlipmodeError(
                f"start = {self.start:g} s: must not be after end = {self.end:g} s"
            )

    def of(self, data: RecordingData) -> RecordingData:
        """Return the selected part.

        Refuses unknown channels, times without samples, and damage that left no samples.
        """
        channels = {topic: data.channels[topic] for topic in self.topics or data.channels}
        header = data.header
        if data.damage and not any(signals.time.size for signals in channels.values()):
            raise SlipmodeError(f"no samples are left; {data.missing()}")
        if self.start > -math.inf or self.end < math.inf:
            for topic, (channel, time, values) in channels.items():
                kept = (self.start <= time) & (time <= self.end)
                channels[topic] = Signals(channel, time[kept], values[kept])
            header = replace(header, title=f"{header.title}, t = {self.start:g} to {self.end:g} s")
            if not any(signals.time.size for signals in channels.values()):
                raise SlipmodeError(
                    f"there are no samples from {self.start:g} to {self.end:g} s; the recording "
                    f"ends at {data.end_time:g} s"
                )
        events = [event for event in data.events if self.start <= event.time <= self.end]
        return replace(data, header=header, channels=channels, events=events)


def load(path: str | PathLike[str]) -> dict[str, Signals]:
    """Return the samples of an MCAP recording by topic.

    Parameters
    ----------
    path : path
        MCAP file written by slipmode. A damaged file is read up to the damage.

    Returns
    -------
    dict of str to Signals
        Samples by topic. An unknown topic raises a SlipmodeError that lists all topics.

    Raises
    ------
    SlipmodeError
        If the file is not an MCAP recording of slipmode, or needs more memory than the larger of
        ten times its size and 256 MiB. The environment variable SLIPMODE_MEMORY_MIB sets another
        limit.

    Warns
    -----
    DamagedRecordingWarning
        If the file is damaged. The message says what is missing.

    Examples
    --------
    The amplitude of mode A over time::

        modes = runner.load("logs/sweep.mcap")["/modes"]
        time, amplitude = modes.time, modes.column("A_abs")
    """
    data = read(path)
    warn_of_damage(path, data)
    return data.channels


def warn_of_damage(path: str | PathLike[str], data: RecordingData) -> None:
    """Warn if a recording that was read from `path` is damaged."""
    if data.damage:
        warnings.warn(f"{path}: {data.missing()}", DamagedRecordingWarning, stacklevel=3)


def read(path: str | PathLike[str]) -> RecordingData:
    """Return an MCAP recording with its header, samples and events.

    Parameters
    ----------
    path : path
        MCAP file written by slipmode. A damaged file is read up to the damage.

    Returns
    -------
    RecordingData
        Its `complete` is False if the file is damaged (the last event has the level "warning"), or
        if the run stopped early (the last event has the level "error").

    Raises
    ------
    SlipmodeError
        If the file is not an MCAP recording of slipmode.
    """
    events = list[Event]()
    times, rows = defaultdict[int, bytearray](bytearray), defaultdict[int, bytearray](bytearray)
    refusals: dict[int, SlipmodeError] = {}

    @cache
    def layout(number: int) -> Channel | None:
        try:
            return inventory.sample_channel(number)
        except SlipmodeError as error:
            refusals[number] = error
            inventory.faults.append(str(error))
            return None

    def take(number: int, messages: Messages) -> None:
        if inventory.channels[number].topic == EVENTS:
            inventory.keep(_EVENT_BYTES * messages.offsets.size + len(messages.raw))
            for time_ns, data in messages.each():
                try:
                    events.append(decode_event(data, time_ns))
                except (DecodeError, KeyError) as error:
                    raise SlipmodeError(f"{EVENTS}: must have events only") from error
        elif (channel := layout(number)) is not None:
            try:
                values = channel.decode(messages.data())
            except DamagedError as error:
                inventory.faults.append(f"{channel.topic}: {error}")
                return
            inventory.keep(values.nbytes + 8 * len(values))
            times[number] += messages.prefix["log_time"].tobytes()
            rows[number] += values.tobytes()

    with opened(path) as inventory:
        for number, messages in inventory.messages():
            take(number, messages)
        if not inventory.ours:
            raise SlipmodeError("not a recording of slipmode")
        channels, left_out = Channels(), []
        for number, record in inventory.channels.items():
            if record.topic in (EVENTS, Overview.topic):
                continue
            if (channel := layout(number)) is None:
                left_out += [inventory.kind_of(number)] if number not in refusals else []
                continue
            time = np.frombuffer(times[number], np.uint64) / NANOSECONDS
            values = np.frombuffer(rows[number]).reshape(len(time), len(channel.fields))
            channels[record.topic] = Signals(channel, time, values)
        if refusals and not channels:
            raise next(iter(refusals.values()))
        found = inventory.header(), channels, events, inventory.damage, tuple(left_out)
        return RecordingData(*found).with_its_end()
