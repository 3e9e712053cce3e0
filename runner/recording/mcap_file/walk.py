"""The walk over the records of an MCAP file, whole or damaged."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import BinaryIO

import numpy as np
from mcap import records
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from slipmode.rom.short_repr import short_repr
from slipmode.rom.storage.stored_arrays import MIB
from slipmode.runner.recording.mcap_file.reader import Messages
from slipmode.runner.recording.mcap_file.records import (
    MESSAGE_PREFIX,
    RECORD_HEAD,
    DamagedError,
    Loose,
    Record,
    parsed,
)

_LOOSE_BYTES = MIB  # of messages outside chunks that are read at once
_LARGEST = 1 << 40  # bytes of a record; a length beyond is damage
_LINKS = 3  # records in a row that are believed after damage
_UNREADABLE_BYTES = 16  # what records that cannot be read may have in all, in sizes of the file
_CHUNK_HEAD = struct.Struct("<BQQQQ")  # opcode, length, first and last time, unpacked size
_FOOTER_BYTES = 29


@dataclass(frozen=True)
class Part:
    """A record of a file, the bytes in which it is, and the messages of a chunk."""

    start: int
    end: int
    record: Record
    raw: bytes = b""  # The chunk before compression
    messages: dict[int, Messages] = field(default_factory=dict)  # By channel
    whole: bool = True  # Whether none of its content is left out

    __repr__ = short_repr


@dataclass(frozen=True)
class Damage:
    """A part of a file that cannot be read."""

    start: int
    end: int
    reason: str
    first_ns: int = 0  # What the head of a chunk says about its messages
    last_ns: int = 0
    size: int = 0  # Bytes before compression


class Walk:
    """Reads the records of a file."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = file.seek(0, os.SEEK_END)
        self._patience = _UNREADABLE_BYTES * self.size

    def records(self) -> Iterator[Part | Damage]:
        """Yield the records up to the footer, and the damage between them.

        After damage, the walk continues where several records seem to follow each other.
        """
        place, damage = len(MCAP0_MAGIC), None
        while place < self.size:
            try:
                part = self._record(place)
            except DamagedError as error:
                claims = self._claims(place)
                if damage and any(claims):  # another chunk
                    yield replace(damage, end=place)
                    damage = None
                damage = damage or Damage(place, self.size, str(error), *claims)
                place = self._resume(place) if self._patience > 0 else self.size
                continue
            if damage:
                yield replace(damage, end=place)
                damage = None
            yield part
            place = part.end
            if isinstance(part.record, records.Footer):
                if self._bytes(place, len(MCAP0_MAGIC) + 1) != MCAP0_MAGIC:
                    reason = f"the file does not end as MCAP files do, after byte {place}"
                    yield Damage(place, self.size, reason)
                return
        reason = f"the file ends at byte {self.size}, before its footer"
        yield damage or Damage(self.size, self.size, reason)

    def summary(self) -> tuple[list[Record], bool]:
        """Return the records of the summary, and whether a check sum guards them.

        There are none if the file has no summary, or does not end with a footer. Raises
        DamagedError if the summary cannot be read.
        """
        place = self.size - _FOOTER_BYTES - len(MCAP0_MAGIC)
        try:
            footer = self._record(max(place, 0)).record
        except DamagedError:
            return [], False
        if not isinstance(footer, records.Footer):
            return [], False
        start, found = footer.summary_start or place, []
        if not len(MCAP0_MAGIC) <= start <= place:
            raise DamagedError(f"the footer places the summary at byte {start}, where none can be")
        checked = self._bytes(start, place + _FOOTER_BYTES - 4 - start)
        if footer.summary_crc not in (0, zlib.crc32(checked)):
            raise DamagedError("the check sum of the summary does not fit it")
        while start < place:
            part = self._record(start)
            found.append(part.record)
            start = part.end
        return found, bool(footer.summary_crc)

    def check_sum(self, end: int) -> int:
        """Return the check sum of the file up to byte `end`."""
        crc = 0
        for start in range(0, end, MIB):
            crc = zlib.crc32(self._bytes(start, min(MIB, end - start)), crc)
        return crc

    def _bytes(self, start: int, size: int) -> bytes:
        self._file.seek(start)
        return self._file.read(size)

    def _head(self, start: int) -> tuple[int, int]:
        """Return opcode and end of the record at a byte; an end beyond the file if it is cut.

        The end is 0 if no record can be there.
        """
        head = self._bytes(start, RECORD_HEAD.size)
        if len(head) < RECORD_HEAD.size:
            return 0, self.size + 1
        opcode, length = RECORD_HEAD.unpack(head)
        end = start + RECORD_HEAD.size + length
        cut = opcode <= max(Opcode) and end < self.size + _LARGEST
        return opcode, end if opcode and length and (end <= self.size or cut) else 0

    def _record(self, start: int) -> Part:
        """Return the record, or the messages outside chunks, that begin at a byte."""
        opcode, end = self._head(start)
        if end > self.size:
            raise DamagedError(f"the file ends at byte {self.size}, within the record at {start}")
        body, reason = start + RECORD_HEAD.size, f"the record at byte {start} cannot be read"
        if not end:
            raise DamagedError(reason)
        try:
            if opcode == Opcode.MESSAGE:
                return self._messages(start, end)
            return Part(start, end, parsed(opcode, self._bytes(body, end - body)))
        except DamagedError as error:
            self._patience -= end - start
            raise DamagedError(reason) from error

    def _messages(self, start: int, end: int) -> Part:
        """Return messages outside chunks, from the first one, which is from `start` to `end`."""
        raw = self._bytes(start, max(_LOOSE_BYTES, end - start))
        ends = [0]
        while raw[ends[-1] : ends[-1] + 1] == bytes([Opcode.MESSAGE]):
            length = int.from_bytes(raw[ends[-1] + 1 : ends[-1] + RECORD_HEAD.size], "little")
            end = ends[-1] + RECORD_HEAD.size + length
            if end < ends[-1] + MESSAGE_PREFIX.itemsize or end > len(raw):
                break
            ends.append(end)
        end = start + ends[-1]  # of the last one, which nothing but its length confirms
        if self._bytes(end, 1) != bytes([Opcode.MESSAGE]) and not self._chained(end, least=0):
            ends.pop()
        if len(ends) < 2:
            raise DamagedError
        return Part(start, start + ends[-1], Loose(raw[: ends[-1]]))

    def _resume(self, start: int) -> int:
        """Return where the next records are after a record that cannot be read; else the size."""
        end = self._head(start)[1]
        if 0 < end <= self.size and self._chained(end):
            return end
        for block in range(start + 1, self.size - RECORD_HEAD.size, MIB):
            raw = self._bytes(block, MIB + RECORD_HEAD.size - 1)
            count = len(raw) - RECORD_HEAD.size + 1
            opcodes = np.frombuffer(raw, np.uint8, count)
            lengths = np.ndarray((count,), "<u8", raw, 1, (1,))  # at every byte
            here = (opcodes > 0) & (opcodes <= max(Opcode)) & (lengths < self.size)
            for place in (block + np.flatnonzero(here)).tolist():
                if self._chained(place):
                    return place
        return self.size

    def _chained(self, place: int, least: int = 1) -> bool:
        """Return whether several records seem to follow each other from a byte on.

        If the file ends within one of them, at least `least` must come before it.
        """
        for link in range(_LINKS):
            if place == self.size:
                return True
            opcode, end = self._head(place)
            if not 0 < end <= self.size:
                return end > 0 and link >= least
            if opcode == Opcode.FOOTER:
                return True
            place = end
        return True

    def _claims(self, start: int) -> tuple[int, int, int]:
        """Return times [ns] and unpacked size that a chunk at a byte has by its head."""
        head = self._bytes(start, _CHUNK_HEAD.size)
        if len(head) < _CHUNK_HEAD.size or head[0] != Opcode.CHUNK:
            return 0, 0, 0
        first, last, size = _CHUNK_HEAD.unpack(head)[2:]
        return first, last, size
