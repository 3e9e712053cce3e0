"""The walk over the records of an MCAP file, whole or damaged: chunks become arrays of messages.

The readers of the mcap package take messages one by one: 0.2 million a second, against 3 million
here (`make bench-recordings`), and end at the first damage. Records other than messages are
parsed by it.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import BytesIO
from os import PathLike
from typing import Any, BinaryIO

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.short_repr import short_repr
from slipmode.rom.storage.files import as_path
from slipmode.rom.storage.stored_arrays import MIB
from slipmode.runner.recording.contents.layout import (
    HEADER_BYTES,
    INDEX_ENTRY,
    MESSAGE_PREFIX,
    DamagedError,
    MessageIndex,
    record_bytes,
)

_LOOSE_BYTES = MIB  # of messages outside chunks that are read at once
_LARGEST = 1 << 40  # bytes of a record; a length beyond is damage
_LINKS = 3  # records in a row that are believed after damage
_SEARCH_BYTES = 16  # what the search after damage may parse, in sizes of the file
_CHUNK_HEAD = struct.Struct("<BQQQQ")  # opcode, length, first and last time, unpacked size
UNREADABLE = (McapError, struct.error, ValueError, OverflowError, MemoryError)


class _CutError(DamagedError):
    """The file ends within a record."""


@dataclass(frozen=True)
class Loose:
    """Messages outside chunks, one record after the other."""

    raw: bytes

    __repr__ = short_repr


Record = records.McapRecord | MessageIndex | Loose | None  # None: of a kind that is unknown here


@dataclass(frozen=True)
class Found:
    """A record, and the bytes of the file in which it is."""

    start: int
    end: int
    record: Record


@dataclass(frozen=True)
class Damage:
    """A part of a file that cannot be read."""

    start: int
    end: int
    reason: str
    first_ns: int = 0  # What the head of a chunk says about its messages
    last_ns: int = 0
    size: int = 0  # Bytes before compression


def scan(file: BinaryIO) -> Iterator[Found | Damage]:
    """Yield the records of a file from its position to its footer, and the damage between them.

    After damage, the walk continues where several records in a row can be read.
    """
    position, size = file.tell(), file.seek(0, os.SEEK_END)
    patience = [_SEARCH_BYTES * size]
    while position < size:
        try:
            found = _trusted(file, _record_at(file, position, size), size)
        except DamagedError as error:
            end = _resume(file, position, size, patience)
            yield Damage(position, end, str(error), *_claims(file, position))
            if end == size:
                return
            position = end
            continue
        yield found
        position = found.end
        if isinstance(found.record, records.Footer):
            file.seek(position)
            if file.read(len(MCAP0_MAGIC) + 1) != MCAP0_MAGIC:
                reason = f"the file does not end as MCAP files do, after byte {position}"
                yield Damage(position, size, reason)
            return
    yield Damage(size, size, f"the file ends at byte {size}, before its footer")


def _record_at(file: BinaryIO, start: int, size: int) -> Found:
    """Return the record, or the messages outside chunks, that begin at a byte of a file."""
    file.seek(start)
    header = file.read(HEADER_BYTES)
    end = start + HEADER_BYTES + int.from_bytes(header[1:], "little")
    if len(header) < HEADER_BYTES or (size < end < size + _LARGEST and 0 < header[0] < 16):
        raise _CutError(f"the file ends at byte {size}, within the record at {start}")
    try:
        if end > size or not header[0]:
            raise ValueError
        if header[0] == Opcode.MESSAGE:
            file.seek(start)
            raw = file.read(max(_LOOSE_BYTES, end - start))
            if not (end := _loose_ends(raw)[-1]):
                raise ValueError
            return Found(start, start + end, Loose(raw[:end]))
        return Found(start, end, parsed(header[0], file.read(end - start - HEADER_BYTES)))
    except UNREADABLE as error:
        raise DamagedError(f"the record at byte {start} cannot be read") from error


def _loose_ends(raw: bytes) -> tuple[int, int]:
    """Return where the last two whole messages of a row of messages end; 0 without them."""
    before = end = 0
    while raw[end : end + 1] == bytes([Opcode.MESSAGE]):
        length = int.from_bytes(raw[end + 1 : end + HEADER_BYTES], "little")
        following = end + HEADER_BYTES + length
        if following < end + MESSAGE_PREFIX.itemsize or following > len(raw):
            break
        before, end = end, following
    return before, end


def _trusted(file: BinaryIO, found: Found, size: int) -> Found:
    """Return what was found, without the last of messages outside chunks if nothing follows it.

    Nothing but its length confirms such a message. Raises DamagedError if it was the only one.
    """
    if not isinstance(found.record, Loose):
        return found
    file.seek(found.end)
    if file.read(1) == bytes([Opcode.MESSAGE]) or _chained(file, found.end, size, [0], least=0):
        return found
    before = _loose_ends(found.record.raw)[0]
    if not before:
        raise DamagedError(f"the record at byte {found.start} cannot be read")
    return Found(found.start, found.start + before, Loose(found.record.raw[:before]))


def parsed(opcode: int, body: bytes) -> Record:
    """Return a record; raise one of UNREADABLE if its parts do not fit its length."""
    if opcode == Opcode.MESSAGE_INDEX:  # the mcap package would read it entry by entry
        channel, length = struct.unpack_from("<HI", body)
        if length % 16 or length > len(body) - 6:
            raise ValueError
        return MessageIndex(channel, np.frombuffer(body, INDEX_ENTRY, length // 16, 6))
    if opcode not in list(Opcode):
        return None
    name = Opcode(opcode).name.title().replace("_", "")  # CHUNK_INDEX is read by ChunkIndex
    kind: Any = getattr(records, name)
    record: records.McapRecord = kind.read(ReadDataStream(BytesIO(body)))
    again = record_bytes(record)[HEADER_BYTES:]
    if isinstance(record, records.Attachment) and body[-4:] == bytes(4):  # without a check sum
        again = again[:-4] + bytes(4)
    if not body.startswith(again):  # later versions may append fields
        raise ValueError
    return record


def _resume(file: BinaryIO, start: int, size: int, patience: list[int]) -> int:
    """Return where the next records are after a record that cannot be read; else the size."""
    file.seek(start)
    header = file.read(HEADER_BYTES)
    end = start + HEADER_BYTES + int.from_bytes(header[1:], "little")
    if end <= size and _chained(file, end, size, patience):
        return end
    for block in range(start + 1, size - HEADER_BYTES, MIB):
        file.seek(block)
        raw = file.read(MIB + HEADER_BYTES - 1)
        count = len(raw) - HEADER_BYTES + 1
        opcodes = np.frombuffer(raw, np.uint8, count)
        lengths = np.ndarray((count,), "<u8", raw, 1, (1,))  # at every byte
        room = (size - block - HEADER_BYTES - np.arange(count)).astype(np.uint64)
        here = (opcodes > 0) & (opcodes < 16) & (lengths > 0) & (lengths <= room)
        for place in (block + np.flatnonzero(here)).tolist():
            if patience[0] > 0 and _chained(file, place, size, patience):
                return place
    return size


def _chained(file: BinaryIO, start: int, size: int, patience: list[int], least: int = 1) -> bool:
    """Return whether records follow each other from a byte of a file on.

    If the file ends within one of them, at least `least` must come before it.
    """
    links, place = 0, start
    for _ in range(2 * _LINKS):
        if links == _LINKS or place == size:
            return True
        try:
            found = _record_at(file, place, size)
        except DamagedError as error:
            return isinstance(error, _CutError) and links >= least
        if isinstance(found.record, records.Footer):
            return True
        links += found.record is not None
        place = found.end
        patience[0] -= place - start
    return False


def _claims(file: BinaryIO, start: int) -> tuple[int, int, int]:
    """Return times [ns] and unpacked size that a chunk at a byte of a file has by its head."""
    file.seek(start)
    head = file.read(_CHUNK_HEAD.size)
    if len(head) < _CHUNK_HEAD.size or head[0] != Opcode.CHUNK:
        return 0, 0, 0
    first, last, size = _CHUNK_HEAD.unpack(head)[2:]
    return first, last, size


def read_summary(file: BinaryIO) -> tuple[list[Record], bool]:
    """Return the records of a file's summary, and whether a check sum guards them.

    There are none if the file has no summary, or does not end with a footer. Raises DamagedError
    if the summary cannot be read.
    """
    size = file.seek(0, os.SEEK_END)
    place = size - len(record_bytes(records.Footer(0, 0, 0)) + MCAP0_MAGIC)
    try:
        footer = _record_at(file, max(place, 0), size).record
    except DamagedError:
        return [], False
    if not isinstance(footer, records.Footer):
        return [], False
    start = footer.summary_start or place
    if not len(MCAP0_MAGIC) <= start <= place:
        raise DamagedError(f"the footer places the summary at byte {start}, where none can be")
    file.seek(start)
    checked = file.read(size - len(MCAP0_MAGIC) - 4 - start)
    if footer.summary_crc not in (0, zlib.crc32(checked)):
        raise DamagedError("the check sum of the summary does not fit it")
    found = []
    while start < place:
        each = _record_at(file, start, size)
        found.append(each.record)
        start = each.end
    return found, bool(footer.summary_crc)


@contextmanager
def opened(path: str | PathLike[str]) -> Iterator[BinaryIO]:
    """Open an MCAP file for reading, after its magic; refusals within name the file.

    Raises SlipmodeError if it cannot be opened, or does not begin like MCAP.
    """
    with ExitStack() as stack:
        try:
            file = stack.enter_context(as_path("path", path).open("rb"))
        except OSError as error:
            raise SlipmodeError(f"{path}: {error.strerror}") from error
        with naming(path):
            magic = file.read(len(MCAP0_MAGIC))
            if magic != MCAP0_MAGIC:
                raise SlipmodeError("not an MCAP file" if magic else "an empty file")
            yield file
