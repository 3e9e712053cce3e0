"""Recordings of other programs: whatever numbers their MCAP files hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path

import numpy as np
from mcap import records

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.channels import OTHER, Channel, Event, Field
from slipmode.runner.recording.external.messages import Decoder, Numbers, UnreadableError, decoder
from slipmode.runner.recording.load import RecordingData, Signals, kind_of, truncation
from slipmode.runner.recording.mcapfile.chunk import Contents, Messages
from slipmode.runner.recording.mcapfile.prefetch import take_all
from slipmode.runner.recording.mcapfile.scan import DamagedError, scan
from slipmode.runner.recording.mcapfile.source import opened
from slipmode.runner.recording.mcapfile.statistics import WALL_CLOCK, Statistics
from slipmode.runner.recording.record import Header

_NANOSECONDS = 1e9


def is_external(path: str | PathLike[str]) -> bool:
    """Whether an MCAP file says nothing of being a recording of ours.

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not MCAP.
    """
    with opened(path) as file:
        try:
            return not any(
                isinstance(piece.record, records.Metadata) and piece.record.name == "units"
                for piece in scan(file)
            )
        except DamagedError:
            return True


def read_external(path: str | PathLike[str]) -> RecordingData:
    """Numbers in the JSON and protobuf messages of an MCAP file.

    Members of messages are called ``pose.x``, those of short lists ``gains[0]``; a number that a
    message does not have is NaN. Times count from the first message where the file has wall
    time, else they are its log times.

    Raises
    ------
    SlipmodeError
        If there is no such file, it is not MCAP, its clocks are mixed, or it holds no numbers.
    """
    with opened(path) as file:
        gathered = _Gathered()
        damage = take_all(file, gathered.take)
        return gathered.recording(Path(path).name, damage)


def as_curves(channels: Mapping[str, Signals]) -> dict[str, Signals]:
    """Each number as a channel of its own, ``/other/imu/pose.x``, at the times that have it."""
    curves = {}
    for topic, (channel, time, values) in channels.items():
        for one, column in zip(channel.fields, values.T, strict=True):
            there = np.isfinite(column)
            name = f"{OTHER}/{topic.strip('/')}/{one.name.replace('/', '|')}"
            curve = Channel(name, (one,), channel.description)
            curves[name] = Signals(curve, time[there], column[there, np.newaxis])
    return curves


@dataclass
class _Table:
    """Messages of a channel, as rows of numbers by their names."""

    decode: Decoder
    times: list[int] = field(default_factory=list)
    rows: list[Numbers] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)

    def extend(self, messages: Messages) -> None:
        """Take the messages that can be read; count the others by their fault."""
        stamps = messages.prefix["log_time"].tolist()
        for data, stamp in zip(messages.each(), stamps, strict=True):
            try:
                self.rows.append(self.decode(data))
                self.times.append(stamp)
            except UnreadableError as fault:
                self.refused[str(fault)] += 1

    def values(self) -> tuple[list[str], Floats]:
        """Names in the order of their appearance, and values of shape (n, names)."""
        names = list(dict.fromkeys(name for row in self.rows for name in row))
        column = {name: k for k, name in enumerate(names)}
        values = np.full((len(self.rows), len(names)), np.nan)
        for number, row in enumerate(self.rows):
            for name, value in row.items():
                values[number, column[name]] = value
        return names, values


class _Gathered:
    """Records of a file, as they are met."""

    def __init__(self) -> None:
        self._statistics = Statistics()
        self._tables: dict[int, _Table] = {}

    def take(self, record: object) -> None:
        if not isinstance(record, Contents):
            self._statistics.take(record)
            return
        self._statistics.take_contents(record)
        for number, messages in record.messages.items():
            if number not in self._tables:
                channel = self._statistics.channels[number]
                schema = self._statistics.schemas.get(channel.schema_id)
                self._tables[number] = _Table(decoder(channel, schema))
            self._tables[number].extend(messages)

    def recording(self, title: str, damage: str) -> RecordingData:
        for complaint in self._statistics.mixed_clocks():
            raise SlipmodeError(complaint)
        begin = min(self._statistics.first.values(), default=0)
        origin = begin if begin >= WALL_CLOCK else 0
        channels: dict[str, Signals] = {}
        left_out = []
        for number, table in self._tables.items():
            record = self._statistics.channels[number]
            kind = kind_of(record, self._statistics.schemas.get(record.schema_id))
            left_out += [f"{count} of {kind}: {fault}" for fault, count in table.refused.items()]
            if signals := _signals(table, record, origin):
                again = f" ({number})" if record.topic in channels else ""
                channels[record.topic + again] = signals
            elif table.rows:
                left_out.append(f"{len(table.rows)} of {kind}: no numbers")
        if not channels:
            seen = [*left_out, damage] if damage else left_out or ["no messages at all"]
            raise SlipmodeError(f"no numbers to show: {'; '.join(seen)}")
        words = "not a recording of slipmode"
        if origin:
            words += f"; t = 0 is {datetime.fromtimestamp(origin / _NANOSECONDS, UTC).isoformat()}"
        data = RecordingData(
            Header(title, ""), channels, [], damage, tuple(left_out), external=True
        )
        data.events.append(Event(0.0, "info", words))
        data.events.extend(Event(0.0, "warning", f"not shown: {each}") for each in left_out)
        if damage:
            data.events.append(truncation(data.end_time))
        return data


def _signals(table: _Table, record: records.Channel, origin: int) -> Signals | None:
    """Samples of a channel, None if it has no numbers; times count from `origin` [ns]."""
    names, values = table.values()
    if not names:
        return None
    fields = tuple(Field(name, record.metadata.get(name, "")) for name in names)
    time = (np.array(table.times, np.int64) - origin) / _NANOSECONDS
    return Signals(Channel(record.topic, fields, record.topic), time, values)
