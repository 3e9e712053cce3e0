"""What an MCAP file holds, and what is missing from it: one rule for all who read recordings."""

from __future__ import annotations

import os
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, BinaryIO

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.rom.storage.stored_arrays import MIB, memory_limit
from slipmode.runner.recording.contents.chunks import (
    CHUNK_COPIES,
    TooLargeError,
    unpack,
)
from slipmode.runner.recording.contents.layout import DamagedError, Messages, record_bytes
from slipmode.runner.recording.contents.walk import (
    Damage,
    Found,
    Loose,
    Record,
    read_summary,
    scan,
)

WALL_CLOCK = 10**18  # [ns], in 2001: later times count from 1970, earlier ones from a run's start
UNITS = "units"  # metadata that recordings of slipmode have
# Memory for each byte of a schema or channel: in the file, parsed, and in a new summary by
# `recover`; the slow test of test_reader_memory.py measures the sum.
_DESCRIPTION_COPIES = 8
_FAULTS_SHOWN = 3  # in one line


@dataclass(frozen=True)
class Part:
    """A record of a file with its messages; `whole` if none of its content is left out."""

    found: Found
    raw: bytes = b""  # The chunk before compression
    messages: dict[int, Messages] = field(default_factory=dict)  # By channel
    whole: bool = True

    __repr__ = short_repr


@dataclass
class Inventory:
    """The contents of a file, filled by `read`; all about channels by their numbers."""

    schemas: dict[int, records.Schema] = field(default_factory=dict)
    channels: dict[int, records.Channel] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)  # Messages
    # Earliest and latest log time of the channels that have messages [ns]
    first: dict[int, int] = field(default_factory=dict)
    last: dict[int, int] = field(default_factory=dict)
    chunks: int = 0
    # Channels whose log times count from the run's start and whose publish times from 1970
    published_later: set[int] = field(default_factory=set)
    ours: bool = False  # Whether slipmode wrote it
    faults: list[str] = field(default_factory=list)  # Why the file is not whole
    lost: list[Damage] = field(default_factory=list)
    gap: bool = False  # Whether messages may be missing before others
    expected: int | None = None  # Messages by the statistics of the file
    limit: int = 0  # Bytes that the readers of the file may allocate
    kept: int = 0  # Bytes of them that are in use
    # Schemas and channels in a summary with the right check sum
    _certain: dict[tuple[type, int], Record] = field(default_factory=dict)
    _known_chunks: set[tuple[int, int, int]] = field(default_factory=set)  # Check sums and times

    __repr__ = short_repr

    @property
    def damage(self) -> str:
        """Why the file is not whole, in one line; empty if it is."""
        more = len(self.faults) - _FAULTS_SHOWN
        shown = self.faults[:_FAULTS_SHOWN] + ([f"and {more} more faults"] if more > 0 else [])
        return "; ".join(shown)

    def read(self, file: BinaryIO, *, beyond_damage: bool = False) -> Iterator[Part]:
        """Yield the whole parts of a file, from its position to its end; note what is not whole.

        Messages on channels that the file does not describe are left out. By default the messages
        have no gap: reading ends at the first damage in or after a chunk.
        """
        start = file.tell()
        self.limit = memory_limit(file.seek(0, os.SEEK_END))
        summary = self._read_summary(file)
        file.seek(start)
        for found in scan(file):
            if self.gap and not beyond_damage:
                break
            if isinstance(found, Damage):
                self.faults.append(found.reason)
                self._lose(found)
                continue
            self.ours = self.ours or is_ours(found.record)
            if isinstance(found.record, records.Chunk | Loose):
                yield from self._unpacked(found, found.record)
                continue
            self._add(found.record)
            yield Part(found)
            match found.record:
                case records.DataEnd(data_section_crc=crc) if crc and not self.lost:
                    if crc != _check_sum(file, found.start):
                        self.faults.append("the check sum of the data section does not fit it")
        for record in summary:  # also records that damage took from the data section
            self._add(record)
        counted = self.counts.total()
        if self.expected not in (None, counted):
            self.faults.append(f"{counted} messages of the {self.expected} in its statistics")

    def keep(self, size: int) -> None:
        """Account for `size` bytes that a reader keeps in memory; refuse too many."""
        self.kept += size
        if self.kept > self.limit:
            raise SlipmodeError(
                f"needs more than {self.limit // MIB} MiB of memory, the larger of ten times its "
                "size and 256 MiB; the environment variable SLIPMODE_MEMORY_MIB sets another limit"
            )

    def schema_of(self, number: int) -> records.Schema:
        """Return the schema of a channel; an empty one if the file has none."""
        none = records.Schema(id=0, data=b"", encoding="", name="")
        return self.schemas.get(self.channels[number].schema_id, none)

    def described(self) -> list[records.Schema | records.Channel]:
        """Return the schemas, and the channels whose schemas are known or need not be."""
        channels = self.channels.values()
        return [*self.schemas.values(), *(c for c in channels if self._has_schema(c))]

    def _has_schema(self, channel: records.Channel) -> bool:
        return channel.schema_id == 0 or channel.schema_id in self.schemas

    def mixed_clocks(self) -> str:
        """Return a complaint if some times count from 1970 and others from the run's start."""
        for channel in self.published_later:
            clocks = "publish times from 1970, log times from the run's start"
            return f"mixed clocks: {self.channels[channel].topic} has {clocks}"
        wall = [channel for channel, last in self.last.items() if last >= WALL_CLOCK]
        simulated = [channel for channel, first in self.first.items() if first < WALL_CLOCK]
        if not (wall and simulated):
            return ""
        late, early = (self.channels[numbers[0]].topic for numbers in (wall, simulated))
        return f"mixed clocks: {late} has times from 1970, {early} from the run's start"

    def _read_summary(self, file: BinaryIO) -> list[Record]:
        """Return the schemas and channels of a summary that its check sum confirms."""
        try:
            summary, certain = read_summary(file)
        except DamagedError as error:
            self.faults.append(str(error))
            return []
        for record in summary:
            self.ours = self.ours or is_ours(record)
            if isinstance(record, records.Statistics):
                self.expected = record.message_count
        known = [r for r in summary if isinstance(r, records.Schema | records.Channel)]
        self._certain = {(type(r), r.id): r for r in known if certain}
        return list(self._certain.values())

    def _lose(self, damage: Damage) -> None:
        self.lost.append(damage)
        self.gap = self.gap or bool(self.counts or damage.size)

    def _add(self, record: Record) -> bool:
        """Add a record other than a chunk; return whether it agrees with those before."""
        match record:
            case records.Schema():
                return self._describe(self.schemas, record)
            case records.Channel():
                return self._describe(self.channels, record)
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Attachment():
                self.attachments[record.name] = record.data
        return True

    def _describe(self, known: dict[int, Any], record: records.Schema | records.Channel) -> bool:
        if record.id not in known:
            self.keep(_DESCRIPTION_COPIES * len(record_bytes(record)))
        kept = known.setdefault(record.id, self._certain.get((type(record), record.id), record))
        if kept != record:
            kind = type(record).__name__.lower()
            self.faults.append(f"{kind} {record.id} is described in two ways")
        return kept == record

    def _unpacked(self, found: Found, chunk: records.Chunk | Loose) -> Iterator[Part]:
        where = f"chunk at byte {found.start}"
        try:
            raw, described, messages = unpack(chunk, (self.limit - self.kept) // CHUNK_COPIES)
        except DamagedError as error:
            if isinstance(error, TooLargeError) and CHUNK_COPIES * error.size <= self.limit:
                self.keep(self.limit)  # it would fit, were nothing kept
            self.faults.append(f"{where}: {error}")
            if isinstance(chunk, records.Chunk):
                times = chunk.message_start_time, chunk.message_end_time
                lost = Damage(found.start, found.end, "", *times, chunk.uncompressed_size)
                self._lose(lost)
            yield Part(found, whole=False)
            return
        if isinstance(chunk, records.Chunk):
            same = chunk.uncompressed_crc, chunk.message_start_time, chunk.message_end_time
            if chunk.uncompressed_crc and same in self._known_chunks:
                self.faults.append(f"{where}: repeats an earlier one")
                yield Part(found, whole=False)
                return
            self._known_chunks.add(same)
            self.chunks += 1
        whole = sum(map(self._add, described)) == len(described)
        for channel in [number for number in messages if not self._is_described(number)]:
            count = len(messages.pop(channel).offsets)
            words = f"{count} messages on channel {channel}, which the file does not describe"
            self.faults.append(f"{where}: {words}")
            self.lost.append(Damage(found.start, found.start, ""))
            whole = False
        self._count(messages)
        yield Part(found, raw, messages, whole)

    def _is_described(self, number: int) -> bool:
        """Return whether a channel and its schema are known, if only from the summary."""
        self._add(self._certain.get((records.Channel, number)))
        channel = self.channels.get(number)
        if channel is not None:
            self._add(self._certain.get((records.Schema, channel.schema_id)))
        return channel is not None and self._has_schema(channel)

    def _count(self, found: dict[int, Messages]) -> None:
        for channel, messages in found.items():
            log_time, publish_time = (messages.prefix[f"{of}_time"] for of in ("log", "publish"))
            first, last = int(log_time.min()), int(log_time.max())
            self.first[channel] = min(first, self.first.get(channel, first))
            self.last[channel] = max(last, self.last.get(channel, last))
            self.counts[channel] += log_time.size
            if np.any((publish_time >= WALL_CLOCK) & (log_time < WALL_CLOCK)):
                self.published_later.add(channel)


def is_ours(record: Record) -> bool:
    """Return whether a record marks its file as a recording of slipmode."""
    match record:
        case records.Header(library=library):
            return library.startswith("slipmode;")
        case records.Metadata(name=name) | records.MetadataIndex(name=name):
            return name == UNITS
    return False


def _check_sum(file: BinaryIO, end: int) -> int:
    """Return the check sum of a file up to byte `end`."""
    crc = 0
    file.seek(0)
    for start in range(0, end, MIB):
        crc = zlib.crc32(file.read(min(MIB, end - start)), crc)
    return crc
