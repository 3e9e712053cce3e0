"""Numbers in the messages of other programs, JSON and protobuf, with their names."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError, Message
from mcap import records

_LONGEST_LIST = 16  # of numbers that are shown as curves; longer ones are pictures and the like
_DEEPEST = 8  # messages within messages
_CLOCKS = ("google.protobuf.Timestamp", "google.protobuf.Duration")

Numbers = dict[str, float]
Decoder = Callable[[bytes], Numbers]


class UnreadableError(Exception):
    """Why a message cannot be read."""


def decoder(channel: records.Channel, schema: records.Schema | None) -> Decoder:
    """What finds the numbers in a message of a channel, or raises UnreadableError."""
    match channel.message_encoding:
        case "json":
            return _decode_json
        case "protobuf":
            return _protobuf_decoder(schema)
    return _refuse("neither JSON nor protobuf")


def _refuse(reason: str) -> Decoder:
    def decode(data: bytes) -> Numbers:
        raise UnreadableError(reason)

    return decode


def _decode_json(data: bytes) -> Numbers:
    try:
        return dict(_numbers("", json.loads(data)))
    except (ValueError, RecursionError) as error:
        raise UnreadableError("not JSON") from error


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Numbers within a value of JSON, with their names."""
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
            return dict(_members("", message_class.FromString(data), _DEEPEST))
        except DecodeError as error:
            raise UnreadableError("not of their schema") from error

    return decode


def _message_class(schema: records.Schema | None) -> type[Message]:
    """Python class of the messages of a schema; its files may come in any order."""
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
    """Numbers within a protobuf message, with their names."""
    if depth == 0 or message.DESCRIPTOR.full_name in _CLOCKS:
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
