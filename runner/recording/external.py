"""Recordings of other programs: the numbers in the JSON and protobuf messages of MCAP files."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from slipmode.runner.recording.load import Channels, RecordingData, Signals, kind_of
from slipmode.runner.recording.mcap_reader import (
    WALL_CLOCK,
    DamagedError,
    Inventory,
    Messages,
    opened,
    scan,
)
from slipmode.runner.recording.record import Header

_LONGEST_LIST = 16  # of numbers that are shown as curves; longer lists are pictures and the like

Numbers = dict[str, float]
Decoder = Callable[[bytes], Numbers]


class _UnreadableError(Exception):
    """Why a message cannot be read."""


def is_external(path: str | PathLike[str]) -> bool:
    """Return whether an MCAP file is not marked as a recording of slipmode."""
    with opened(path) as file:
        try:
            return not any(
                isinstance(record, records.Metadata) and record.name == "units"
                for _, _, record in scan(file)
            )
        except DamagedError:
            return True


def read_external(path: str | PathLike[str]) -> RecordingData:
    """Return the numbers in the JSON and protobuf messages of an MCAP file.

    Members of messages are called ``pose.x``, items of short lists ``gains[0]``; a number that a
    message does not have is NaN. Times count from the first message if the file has wall times,
    else they are its log times. Raises SlipmodeError if there is no such file, it is not MCAP, its
    clocks are mixed, or it has no numbers.
    """
    inventory = Inventory()
    decoders: dict[int, Decoder] = {}
    times: dict[int, list[int]] = defaultdict(list)
    rows: dict[int, list[Numbers]] = defaultdict(list)
    refused: Counter[tuple[int, str]] = Counter()

    def take(number: int, messages: Messages) -> None:
        if number not in decoders:
            decoders[number] = _decoder(inventory, number)
        for time_ns, data in messages.each():
            try:
                rows[number].append(decoders[number](data))
                times[number].append(time_ns)
            except _UnreadableError as fault:
                refused[number, str(fault)] += 1

    with opened(path) as file:
        inventory.read(file, take)
        if complaint := inventory.mixed_clocks():
            raise SlipmodeError(complaint)
        begin = min(inventory.first.values(), default=0)
        origin = begin if begin >= WALL_CLOCK else 0
        channels = Channels()
        left_out = []
        for number in decoders:
            record, kind = inventory.channels[number], kind_of(inventory, number)
            faults = [(fault, count) for (k, fault), count in refused.items() if k == number]
            left_out += [f"{count} of {kind}: {fault}" for fault, count in faults]
            names = list(dict.fromkeys(name for row in rows[number] for name in row))
            if names:
                again = f" ({number})" if record.topic in channels else ""
                fields = tuple(Field(name, record.metadata.get(name, "")) for name in names)
                time = (np.array(times[number], np.int64) - origin) / NANOSECONDS
                values = [[row.get(name, math.nan) for name in names] for row in rows[number]]
                channel = Channel(record.topic, fields, record.topic)
                channels[record.topic + again] = Signals(channel, time, np.array(values))
            elif rows[number]:
                left_out.append(f"{len(rows[number])} of {kind}: no numbers")
        if not channels:
            damage = [inventory.damage] if inventory.damage else []
            seen = [*left_out, *damage] or ["no messages at all"]
            raise SlipmodeError(f"no numbers to show: {'; '.join(seen)}")
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


def _decoder(inventory: Inventory, number: int) -> Decoder:
    """Return what finds the numbers in a message of a channel, or raises _UnreadableError."""
    channel = inventory.channels[number]
    match channel.message_encoding:
        case "json":
            return _decode_json
        case "protobuf":
            return _protobuf_decoder(inventory.schemas.get(channel.schema_id))
    return _refuse("neither JSON nor protobuf")


def _refuse(reason: str) -> Decoder:
    def decode(data: bytes) -> Numbers:
        raise _UnreadableError(reason)

    return decode


def _decode_json(data: bytes) -> Numbers:
    try:
        return dict(_numbers("", json.loads(data)))
    except (ValueError, RecursionError) as error:
        raise _UnreadableError("not JSON") from error


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Yield the numbers within a JSON value, with their names."""
    if isinstance(value, int | float):
        if abs(value) <= sys.float_info.max:
            yield name or "value", float(value)
    elif isinstance(value, dict):
        for key, member in value.items():
            yield from _numbers(f"{name}.{key}" if name else key, member)
    elif isinstance(value, list) and len(value) <= _LONGEST_LIST:
        for number, member in enumerate(value):
            yield from _numbers(f"{name}[{number}]", member)


def _protobuf_decoder(schema: records.Schema | None) -> Decoder:
    try:
        message_class = _message_class(schema)
    except (DecodeError, KeyError, TypeError, ValueError):
        return _refuse("their schema cannot be read")

    def decode(data: bytes) -> Numbers:
        try:
            return dict(_members("", message_class.FromString(data), 8))
        except DecodeError as error:
            raise _UnreadableError("not of their schema") from error

    return decode


def _message_class(schema: records.Schema | None) -> type[Message]:
    """Return the Python class of the messages of a schema; its files may come in any order."""
    if schema is None:
        raise ValueError
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


def _members(name: str, message: Message, depth: int) -> Iterator[tuple[str, float]]:
    """Yield the numbers within a protobuf message, and its messages up to a depth, by names."""
    clocks = ("google.protobuf.Timestamp", "google.protobuf.Duration")
    if depth == 0 or message.DESCRIPTOR.full_name in clocks:
        return
    for member in message.DESCRIPTOR.fields:
        if member.has_presence and not message.HasField(member.name):
            continue
        value = getattr(message, member.name)
        items = [(f"{name}{member.name}", value)]
        if isinstance(value, Mapping):
            items = []
        elif isinstance(value, Sequence) and not isinstance(value, str | bytes):
            listed = value if len(value) <= _LONGEST_LIST else []
            items = [(f"{items[0][0]}[{number}]", item) for number, item in enumerate(listed)]
        for label, item in items:
            if isinstance(item, Message):
                yield from _members(f"{label}.", item, depth - 1)
            elif not isinstance(item, str | bytes) and abs(item) < math.inf:
                yield label, float(item)
