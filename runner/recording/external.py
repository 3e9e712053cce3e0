"""Recordings of other programs: the numbers in the JSON and protobuf messages of MCAP files."""

from __future__ import annotations

import json
import math
import sys
from array import array
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError, Message
from mcap import records

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.channels import NANOSECONDS, OTHER, Channel, Event, Field
from slipmode.runner.recording.inventory import WALL_CLOCK, Inventory, is_ours, opened
from slipmode.runner.recording.load import Channels, RecordingData, Signals
from slipmode.runner.recording.mcap_reader import Messages
from slipmode.runner.recording.record import Header
from slipmode.runner.recording.walk import Part

_PARSED_BYTES = (
    1 << 22
)  # a longer message is no table of numbers; parsed, it takes 30 times as much
_COPIES = 4  # of each number: columns, table, and curves with their times


class _Decoder(NamedTuple):
    """The parser of a channel's messages, and the reason to leave out those that it refuses."""

    parse: Callable[[bytes], Any]
    refusal: str


class _Table:
    """The numbers of a channel: a column for each name, up to its last number."""

    def __init__(self) -> None:
        self.time = array("Q")  # [ns]
        self.columns: dict[str, array[float]] = {}

    def add(self, time_ns: int, row: Mapping[str, float]) -> int:
        """Add the numbers of a message; return how many bytes they take."""
        rows, size = len(self.time), 8
        self.time.append(time_ns)
        for name, number in row.items():
            column = self.columns.setdefault(name, array("d"))
            size += 8 * (rows + 1 - len(column))
            column.extend([math.nan] * (rows - len(column)))
            column.append(number)
        return _COPIES * size

    def column(self, name: str) -> Floats:
        """Return a column; NaN where a message does not have it."""
        found = np.full(len(self.time), math.nan)
        found[: len(self.columns[name])] = self.columns[name]
        return found


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
    decoders, refused = dict[int, _Decoder](), Counter[int]()
    tables: dict[int, _Table] = defaultdict(_Table)

    def take(number: int, messages: Messages) -> None:
        if number not in decoders:
            decoders[number] = _decoder(inventory, number)
        for time_ns, data in messages.each():
            try:
                if len(data) > _PARSED_BYTES:
                    raise ValueError
                row = dict(_numbers("", decoders[number].parse(data)))
            except (DecodeError, ValueError, RecursionError):
                refused[number] += 1
                continue
            inventory.keep(tables[number].add(time_ns, row))

    with opened(path) as inventory:
        for number, messages in inventory.messages():
            take(number, messages)
        begin = inventory.span[0]
        origin = begin if begin >= WALL_CLOCK else 0
        channels = Channels()
        left_out = []
        for number, decoder in decoders.items():
            record, kind = inventory.channels[number], inventory.kind_of(number)
            if refused[number]:
                left_out.append(f"{refused[number]} of {kind}: {decoder.refusal}")
            table = tables[number]
            if names := list(table.columns):
                again = f" ({number})" if record.topic in channels else ""
                fields = tuple(Field(name, record.metadata.get(name, "")) for name in names)
                time = (np.array(table.time) - np.uint64(origin)) / NANOSECONDS
                inventory.keep(8 * len(names) * time.size)
                values = np.column_stack([table.column(name) for name in names])
                channel = Channel(record.topic, fields, record.topic)
                channels[record.topic + again] = Signals(channel, time, values)
            elif table.time:
                left_out.append(f"{len(table.time)} of {kind}: no numbers")
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


def _decoder(inventory: Inventory, number: int) -> _Decoder:
    """Return the decoder of the messages of a channel."""
    channel = inventory.channels[number]
    match channel.message_encoding:
        case "json":
            return _Decoder(json.loads, "not JSON")
        case "protobuf":
            try:
                message_class = _message_class(inventory.schema_of(number))
            except (DecodeError, KeyError, TypeError, ValueError):
                return _Decoder(_refuse, "their schema cannot be read")
            return _Decoder(message_class.FromString, "not of their schema")
    return _Decoder(_refuse, "neither JSON nor protobuf")


def _refuse(data: bytes) -> Any:
    """Stand for the parser of messages that cannot be read."""
    raise ValueError


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
