"""Recordings of other programs: the numbers in the JSON and protobuf messages of MCAP files."""

from __future__ import annotations

import json
import math
import sys
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError, Message
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.channels import NANOSECONDS, OTHER, Channel, Event, Field
from slipmode.runner.recording.inventory import WALL_CLOCK, Inventory, is_ours, opened
from slipmode.runner.recording.load import Channels, RecordingData, Signals
from slipmode.runner.recording.mcap_file.walk import Part
from slipmode.runner.recording.record import Header

# A longer message is no table of numbers; parsed, it takes 30 times as much
_PARSED_BYTES = 1 << 22
_COPIES = 4  # of each number: columns, table, and curves with their times


class _Table:
    """The numbers of a channel: a column for each name, up to its last number."""

    def __init__(self, kind: str, parse: Callable[[bytes], Any] | None, refusal: str) -> None:
        self.kind = kind  # of the channel, for the reader
        self._parse = parse  # None if no message can be read
        self._refusal = refusal
        self._refused = 0
        self._time = array("Q")  # [ns]
        self._columns: dict[str, array[float]] = {}

    def add(self, time_ns: int, data: bytes) -> int:
        """Add the numbers of a message; return how many bytes they take."""
        try:
            if self._parse is None or len(data) > _PARSED_BYTES:
                raise ValueError
            row = dict(_numbers("", self._parse(data)))
        except (DecodeError, ValueError, RecursionError):
            self._refused += 1
            return 0
        rows, size = len(self._time), 8
        self._time.append(time_ns)
        for name, number in row.items():
            column = self._columns.setdefault(name, array("d"))
            size += 8 * (rows + 1 - len(column))
            column.extend([math.nan] * (rows - len(column)))
            column.append(number)
        return _COPIES * size

    @property
    def nbytes(self) -> int:
        """Bytes of its numbers as one array."""
        return 8 * len(self._time) * len(self._columns)

    def left_out(self) -> Iterator[str]:
        """Yield what is not shown, and why."""
        if self._refused:
            yield f"{self._refused} of {self.kind}: {self._refusal}"
        if self._time and not self._columns:
            yield f"{len(self._time)} of {self.kind}: no numbers"

    def signals(self, record: records.Channel, origin: int) -> Signals:
        """Return the numbers at times from `origin` [ns] on; NaN where a message has none."""
        time = (np.array(self._time) - np.uint64(origin)) / NANOSECONDS
        values = np.full((len(time), len(self._columns)), math.nan)
        for number, column in enumerate(self._columns.values()):
            values[: len(column), number] = column
        fields = tuple(Field(name, record.metadata.get(name, "")) for name in self._columns)
        return Signals(Channel(record.topic, fields, record.topic), time, values)


def is_external(path: str | PathLike[str]) -> bool:
    """Return whether an MCAP file is not marked as a recording of slipmode."""
    with opened(path) as inventory:
        parts = inventory.walk.records()
        return not any(isinstance(each, Part) and is_ours(each.record) for each in parts)


def read_external(path: str | PathLike[str]) -> RecordingData:
    """Return the numbers in the JSON and protobuf messages of an MCAP file.

    Members of messages are called ``pose.x``, items of short lists ``gains[0]``; a number that a
    message does not have is NaN. Times count from the first message if the file has wall times,
    else they are its log times. Raises SlipmodeError if there is no such file, it is not MCAP, its
    clocks are mixed, or it has no numbers.
    """
    tables: dict[int, _Table] = {}
    with opened(path) as inventory:
        for number, messages in inventory.messages():
            if number not in tables:
                tables[number] = _table(inventory, number)
            for message in messages.each():
                inventory.keep(tables[number].add(*message))
        begin = inventory.span[0]
        origin = begin if begin >= WALL_CLOCK else 0
        channels = Channels()
        for number, table in tables.items():
            inventory.keep(table.nbytes)
            signals = table.signals(inventory.channels[number], origin)
            if signals.channel.fields:
                topic = signals.channel.topic
                channels[f"{topic} ({number})" if topic in channels else topic] = signals
        left_out = [words for table in tables.values() for words in table.left_out()]
        if not channels:
            seen = "; ".join(filter(None, [*left_out, inventory.damage])) or "no messages at all"
            raise SlipmodeError(f"has no numbers to show ({seen})")
    words = "not a recording of slipmode"
    if origin:
        words += f"; t = 0 is {datetime.fromtimestamp(origin / NANOSECONDS, UTC).isoformat()}"
    events = [Event(0.0, "info", words)]
    events += [Event(0.0, "warning", f"not shown: {each}") for each in left_out]
    found = Header(Path(path).name, ""), channels, events, inventory.damage, tuple(left_out), True
    return RecordingData(*found).with_its_end()


def as_curves(channels: Mapping[str, Signals]) -> dict[str, Signals]:
    """Return a channel for each number, ``/other/imu/pose.x``, at the times that have it."""
    curves = {}
    for topic, (channel, time, values) in channels.items():
        for one, column in zip(channel.fields, values.T, strict=True):
            there = np.isfinite(column)
            name = f"{OTHER}/{topic.strip('/')}/{one.name.replace('/', '|')}"
            curve = Channel(name, (one,), channel.description)
            curves[name] = Signals(curve, time[there], column[there, np.newaxis])
    return curves


def _table(inventory: Inventory, number: int) -> _Table:
    """Return a table for the messages of a channel."""
    kind = inventory.kind_of(number)
    match inventory.channels[number].message_encoding:
        case "json":
            return _Table(kind, json.loads, "not JSON")
        case "protobuf":
            try:
                parse = _message_class(inventory.schema_of(number)).FromString
            except (DecodeError, KeyError, TypeError, ValueError):
                return _Table(kind, None, "their schema cannot be read")
            return _Table(kind, parse, "not of their schema")
    return _Table(kind, None, "neither JSON nor protobuf")


def _message_class(schema: records.Schema) -> type[Message]:
    """Return the Python class of the messages of a schema; its files may come in any order."""
    waiting = {file.name: file for file in FileDescriptorSet.FromString(schema.data).file}
    pool = descriptor_pool.DescriptorPool()

    def add(name: str) -> None:
        if file := waiting.pop(name, None):
            for needed in file.dependency:
                add(needed)
            pool.Add(file)

    for name in list(waiting):
        add(name)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Yield the numbers within a JSON value or a protobuf message, with their names."""
    clocks = ("google.protobuf.Timestamp", "google.protobuf.Duration")
    if isinstance(value, int | float):
        if abs(value) <= sys.float_info.max:
            yield name or "value", float(value)
    elif isinstance(value, Message):
        fields = value.DESCRIPTOR.fields if value.DESCRIPTOR.full_name not in clocks else ()
        present = (f.name for f in fields if not f.has_presence or value.HasField(f.name))
        yield from _members(name, ((each, getattr(value, each)) for each in present))
    elif isinstance(value, dict):
        yield from _members(name, value.items())
    elif isinstance(value, Sequence) and not isinstance(value, str | bytes):
        for number, item in enumerate(value if len(value) <= 16 else ()):  # else a picture
            yield from _numbers(f"{name}[{number}]", item)


def _members(name: str, items: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, float]]:
    for key, member in items:
        yield from _numbers(f"{name}.{key}" if name else key, member)
