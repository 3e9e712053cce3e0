"""What an MCAP file holds, and what is missing from it: one rule for all who read recordings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from typing import BinaryIO

import numpy as np
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet
from google.protobuf.message import DecodeError
from mcap import records
from mcap.writer import MCAP0_MAGIC

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.storage.files import as_path
from slipmode.rom.storage.stored_arrays import MIB, memory_limit
from slipmode.runner.recording.channels import EVENTS, Channel, Field
from slipmode.runner.recording.mcap_file.reader import (
    CHUNK_COPIES,
    Messages,
    TooLargeError,
    unpack,
)
from slipmode.runner.recording.mcap_file.records import DamagedError, Loose, Record, record_bytes
from slipmode.runner.recording.mcap_file.walk import Damage, Part, Walk
from slipmode.runner.recording.record import SCENE_FILE, Header

WALL_CLOCK = 10**18  # [ns], in 2001: later times count from 1970, earlier ones from a run's start
UNITS = "units"  # metadata that recordings of slipmode have
# Memory for each byte of a schema or channel: in the file, parsed, and in a new summary by
# `recover`; the slow test of test_reader_memory.py measures the sum.
_DESCRIPTION_COPIES = 8
_FAULTS_SHOWN = 3  # in one line

Description = records.Schema | records.Channel


class Inventory:
    """The contents of a file; `read` fills it. All about channels is by their numbers."""

    def __init__(self, file: BinaryIO) -> None:
        self.walk = Walk(file)
        self.schemas: dict[int, records.Schema] = {}
        self.channels: dict[int, records.Channel] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, bytes] = {}
        self.counts: Counter[int] = Counter()  # Messages
        # Earliest and latest log time of the channels that have messages [ns]
        self.first: dict[int, int] = {}
        self.last: dict[int, int] = {}
        self.chunks = 0
        self.ours = False  # Whether slipmode wrote it
        self.faults: list[str] = []  # Why the file is not whole
        self.lost: list[Damage] = []
        self.expected: int | None = None  # Messages by the statistics of the file
        self._limit = memory_limit(self.walk.size)  # Bytes that its readers may allocate
        self._kept = 0  # Bytes of them that are in use
        self._gap = False  # Whether messages may be missing before others
        self._known_chunks: set[tuple[int, int, int]] = set()  # Check sums and times
        # Channels whose log times count from the run's start and whose publish times from 1970
        self._published_later: set[int] = set()

    @property
    def damage(self) -> str:
        """Why the file is not whole, in one line; empty if it is."""
        more = len(self.faults) - _FAULTS_SHOWN
        shown = self.faults[:_FAULTS_SHOWN] + ([f"and {more} more faults"] if more > 0 else [])
        return "; ".join(shown)

    @property
    def span(self) -> tuple[int, int]:
        """First and last log time of all messages [ns]; 0 if there are none."""
        return min(self.first.values(), default=0), max(self.last.values(), default=0)

    def read(self, *, beyond_damage: bool = False) -> Iterator[Part]:
        """Yield the whole parts of the file; note what is not whole.

        Messages on channels that the file does not describe are left out. By default the messages
        have no gap: reading ends at the first damage in or after a chunk.
        """
        self._read_summary()
        for part in self.walk.records():
            if self._gap and not beyond_damage:
                break
            if isinstance(part, Damage):
                self._lose(part, part.reason)
            elif isinstance(part.record, records.Chunk):
                yield self._unpacked(part, part.record)
            else:
                self._add(part.record)
                yield part
                match part.record:
                    case records.DataEnd(data_section_crc=crc) if crc and not self.lost:
                        if crc != self.walk.check_sum(part.start):
                            self.faults.append("the check sum of the data section does not fit it")
        counted = self.counts.total()
        if self.expected not in (None, counted):
            self.faults.append(f"{counted} messages of the {self.expected} in its statistics")

    def messages(self) -> Iterator[tuple[int, Messages]]:
        """Yield channels with messages up to the damage; refuse mixed clocks in the end."""
        for part in self.read():
            yield from part.messages.items()
        if complaint := self.mixed_clocks():
            raise SlipmodeError(complaint)

    def keep(self, size: int) -> None:
        """Account for `size` bytes that a reader keeps in memory; refuse too many."""
        self._kept += size
        if self._kept > self._limit:
            raise SlipmodeError(
                f"needs more than {self._limit // MIB} MiB of memory, the larger of ten times its "
                "size and 256 MiB; the environment variable SLIPMODE_MEMORY_MIB sets another limit"
            )

    def schema_of(self, number: int) -> records.Schema:
        """Return the schema of a channel; an empty one if the file has none."""
        none = records.Schema(id=0, data=b"", encoding="", name="")
        return self.schemas.get(self.channels[number].schema_id, none)

    def kind_of(self, number: int) -> str:
        """Return the topic of a channel, with its encoding and the name of its schema."""
        record = self.channels[number]
        words = [record.message_encoding or "no encoding", self.schema_of(number).name]
        return f"{record.topic} ({' '.join(filter(None, words))})"

    def header(self) -> Header:
        """Return what the file says of its run; empty if another program wrote it."""
        scene, run = (self.metadata.get(name, {}) for name in ("scene", "run"))
        text = self.attachments.get(SCENE_FILE, b"").decode(errors="replace")
        return Header(scene.get("title", ""), text, run, scene.get("name", ""))

    def sample_channel(self, number: int) -> Channel | None:
        """Return the fields of a channel with their units; None if it has no samples of slipmode.

        Raises SlipmodeError if its schema is not a schema of samples.
        """
        record = self.channels[number]
        if record.message_encoding != "protobuf" or record.topic == EVENTS:
            return None
        try:
            proto = FileDescriptorSet.FromString(self.schema_of(number).data)
            message = proto.file[-1].message_type[0]
            units = record.metadata
            fields = tuple(Field(member.name, units[member.name]) for member in message.field)
        except (DecodeError, IndexError, KeyError) as error:
            raise SlipmodeError(
                f"{record.topic}: is not a channel of samples with units"
            ) from error
        if any(member.type != FieldDescriptorProto.TYPE_DOUBLE for member in message.field):
            raise SlipmodeError(f"{record.topic}: must have numbers only")
        return Channel(record.topic, fields, record.metadata.get("description", ""))

    def described(self) -> list[Description]:
        """Return the schemas, and the channels whose schemas are known or need not be."""
        return [*self.schemas.values(), *filter(self._has_schema, self.channels.values())]

    def mixed_clocks(self) -> str:
        """Return a complaint if some times count from 1970 and others from the run's start."""
        for channel in self._published_later:
            clocks = "publish times from 1970, log times from the run's start"
            return f"mixed clocks: {self.channels[channel].topic} has {clocks}"
        wall = [channel for channel, last in self.last.items() if last >= WALL_CLOCK]
        simulated = [channel for channel, first in self.first.items() if first < WALL_CLOCK]
        if not (wall and simulated):
            return ""
        late, early = (self.channels[numbers[0]].topic for numbers in (wall, simulated))
        return f"mixed clocks: {late} has times from 1970, {early} from the run's start"

    def _read_summary(self) -> None:
        """Add the schemas and channels of the summary, if a check sum confirms them."""
        try:
            summary, certain = self.walk.summary()
        except DamagedError as error:
            self.faults.append(str(error))
            return
        for record in summary:
            self.ours = self.ours or is_ours(record)
            if isinstance(record, records.Statistics):
                self.expected = record.message_count
            elif certain and isinstance(record, Description):
                self._add(record)

    def _lose(self, damage: Damage, reason: str) -> None:
        self.faults.append(reason)
        self.lost.append(damage)
        self._gap = self._gap or bool(self.counts or damage.size)

    def _add(self, record: Record) -> bool:
        """Add a record other than a chunk; return whether it agrees with those before."""
        self.ours = self.ours or is_ours(record)
        match record:
            case records.Schema(id=number):
                return self._agrees(record, self.schemas.setdefault(number, record))
            case records.Channel(id=number):
                return self._agrees(record, self.channels.setdefault(number, record))
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Attachment():
                self.attachments[record.name] = record.data
        return True

    def _agrees(self, record: Description, kept: Description) -> bool:
        """Return whether a description is the one that is kept; account for a new one."""
        if kept is record:
            self.keep(_DESCRIPTION_COPIES * len(record_bytes(record)))
        if kept != record:
            kind = type(record).__name__.lower()
            self.faults.append(f"{kind} {record.id} is described in two ways")
        return kept == record

    def _has_schema(self, channel: records.Channel | None) -> bool:
        return channel is not None and (
            channel.schema_id == 0 or channel.schema_id in self.schemas
        )

    def _unpacked(self, part: Part, chunk: records.Chunk) -> Part:
        """Return a chunk with its messages, without those that cannot be read."""
        where = f"chunk at byte {part.start}"
        times = chunk.message_start_time, chunk.message_end_time
        try:
            raw, described, messages = unpack(chunk, (self._limit - self._kept) // CHUNK_COPIES)
        except DamagedError as error:
            if isinstance(error, TooLargeError) and CHUNK_COPIES * error.size <= self._limit:
                self.keep(self._limit)  # it would fit, were nothing kept
            lost = Damage(part.start, part.end, "", *times, chunk.uncompressed_size)
            self._lose(lost, f"{where}: {error}")
            return replace(part, whole=False)
        if not isinstance(chunk, Loose):
            same = chunk.uncompressed_crc, *times
            if chunk.uncompressed_crc and same in self._known_chunks:
                self.faults.append(f"{where}: repeats an earlier one")
                return replace(part, whole=False)
            self._known_chunks.add(same)
            self.chunks += 1
        whole = sum(map(self._add, described)) == len(described)
        for channel in [
            number for number in messages if not self._has_schema(self.channels.get(number))
        ]:
            count = len(messages.pop(channel).offsets)
            words = f"{count} messages on channel {channel}, which the file does not describe"
            self.faults.append(f"{where}: {words}")
            self.lost.append(Damage(part.start, part.start, ""))
            whole = False
        self._count(messages)
        return replace(part, raw=raw, messages=messages, whole=whole)

    def _count(self, found: Mapping[int, Messages]) -> None:
        for channel, messages in found.items():
            log_time, publish_time = (messages.prefix[f"{of}_time"] for of in ("log", "publish"))
            first, last = int(log_time.min()), int(log_time.max())
            self.first[channel] = min(first, self.first.get(channel, first))
            self.last[channel] = max(last, self.last.get(channel, last))
            self.counts[channel] += log_time.size
            if np.any((publish_time >= WALL_CLOCK) & (log_time < WALL_CLOCK)):
                self._published_later.add(channel)


def is_ours(record: Record) -> bool:
    """Return whether a record marks its file as a recording of slipmode."""
    match record:
        case records.Header(library=library):
            return library.startswith("slipmode;")
        case records.Metadata(name=name) | records.MetadataIndex(name=name):
            return name == UNITS
    return False


@contextmanager
def opened(path: str | PathLike[str]) -> Iterator[Inventory]:
    """Open an MCAP file for reading; refusals within name the file.

    Raises SlipmodeError if it cannot be opened, or does not begin like MCAP.
    """
    try:
        file = as_path("path", path).open("rb")
    except OSError as error:
        raise SlipmodeError(f"{path}: {error.strerror}") from error
    with file, naming(path):
        magic = file.read(len(MCAP0_MAGIC))
        if magic != MCAP0_MAGIC:
            raise SlipmodeError("not an MCAP file" if magic else "an empty file")
        yield Inventory(file)
