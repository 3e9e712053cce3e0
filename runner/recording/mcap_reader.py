"""Reading of MCAP files from their beginning, as far as they are whole: chunks become arrays.

The readers of the mcap package take messages one by one: 0.2 million a second, against 3 million
here, and say nothing of where a damaged file ends. Records other than messages are parsed by it.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from os import PathLike
from typing import Any, BinaryIO

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray
from zstandard import ZstdError

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.files import as_path
from slipmode.runner.recording.mcap_writer import (
    HEADER_BYTES,
    INDEX_ENTRY,
    MESSAGE_PREFIX,
    record_bytes,
)

WALL_CLOCK = 10**18  # [ns], in 2001: later times count from 1970, earlier ones from a run's start

_MESSAGE_HEAD = struct.Struct("<BQH")  # opcode, length, channel
_UNREADABLE = (McapError, struct.error, ValueError, OverflowError, MemoryError)


class DamagedError(Exception):
    """Why a part of a file cannot be read."""


@dataclass(frozen=True)
class MessageIndex:
    """Where the messages of a channel are in the chunk before it: INDEX_ENTRY items."""

    channel: int
    entries: NDArray[np.void]


Record = records.McapRecord | MessageIndex | None  # None: of a kind that is unknown here


@dataclass(frozen=True)
class Messages:
    """Messages of one channel within a chunk, in the order of the file."""

    raw: bytes  # The decompressed chunk
    offsets: NDArray[np.int64]  # (n,): Where the records of the messages begin
    prefix: NDArray[np.void]  # (n,): Their MESSAGE_PREFIX, with lengths and times

    @classmethod
    def at(cls, raw: bytes, starts: list[int]) -> Messages:
        """Return the messages whose records begin at `starts`."""
        offsets = np.array(starts, dtype=np.int64)
        return cls(raw, offsets, _items(raw, offsets, MESSAGE_PREFIX))

    @property
    def entries(self) -> NDArray[np.void]:
        """Their INDEX_ENTRY items, shape (n,)."""
        found = np.empty(len(self.offsets), INDEX_ENTRY)
        found["log_time"], found["offset"] = self.prefix["log_time"], self.offsets
        return found

    def disordered(self, before: int) -> bool:
        """Return whether log times run backwards, also from an earlier one [ns]."""
        time_ns = self.prefix["log_time"]
        return int(time_ns[0]) < before or bool(np.any(time_ns[1:] < time_ns[:-1]))

    def data(self) -> NDArray[np.void]:
        """Return the messages, shape (n,); raise DamagedError if their lengths differ."""
        if np.ptp(self.prefix["length"]):
            raise DamagedError("messages of one channel differ in length")
        size = int(self.prefix["length"][0]) + HEADER_BYTES - MESSAGE_PREFIX.itemsize
        return _items(self.raw, self.offsets + MESSAGE_PREFIX.itemsize, np.dtype(f"V{size}"))

    def each(self) -> Iterator[tuple[int, bytes]]:
        """Yield the log time [ns] and the bytes of each message."""
        ends = self.offsets + HEADER_BYTES + self.prefix["length"].astype(np.int64)
        starts = self.offsets + MESSAGE_PREFIX.itemsize
        times = self.prefix["log_time"].tolist()
        for time_ns, start, end in zip(times, starts.tolist(), ends.tolist(), strict=True):
            yield time_ns, self.raw[start:end]


@dataclass
class Inventory:
    """The records of a file so far; schemas, channels and all about channels by their numbers."""

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
    damage: str = ""  # Why the file was not read to its end

    def read(self, file: BinaryIO, take: Callable[[int, Messages], None]) -> None:
        """Read a file to its end or its first damage; `take` gets channel numbers and messages."""
        try:
            for _, _, record in scan(file):
                for channel, messages in self.add(record).items():
                    take(channel, messages)
        except DamagedError as error:
            self.damage = str(error)

    def add(self, record: Record) -> dict[int, Messages]:
        """Add a record; return its messages by channel.

        Raises DamagedError if a chunk cannot be read, or a channel is not described.
        """
        match record:
            case records.Schema():
                self.schemas[record.id] = record
            case records.Channel():
                self.channels[record.id] = record
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Attachment():
                self.attachments[record.name] = record.data
            case records.Message() as message:
                return self._count({message.channel_id: Messages.at(record_bytes(message), [0])})
            case records.Chunk():
                found, messages = unpack(record)
                self.chunks += 1
                for each in found:
                    self.add(each)
                return self._count(messages)
        return {}

    def schema_of(self, number: int) -> records.Schema:
        """Return the schema of a channel; an empty one if the file has none."""
        none = records.Schema(id=0, data=b"", encoding="", name="")
        return self.schemas.get(self.channels[number].schema_id, none)

    def _count(self, found: dict[int, Messages]) -> dict[int, Messages]:
        for channel in found.keys() - self.channels.keys():
            raise DamagedError(f"messages on channel {channel}, which the file does not describe")
        for channel, messages in found.items():
            log_time, publish_time = (messages.prefix[f"{of}_time"] for of in ("log", "publish"))
            first, last = int(log_time.min()), int(log_time.max())
            self.first[channel] = min(first, self.first.get(channel, first))
            self.last[channel] = max(last, self.last.get(channel, last))
            self.counts[channel] += log_time.size
            if np.any((publish_time >= WALL_CLOCK) & (log_time < WALL_CLOCK)):
                self.published_later.add(channel)
        return found

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


def scan(file: BinaryIO) -> Iterator[tuple[int, int, Record]]:
    """Yield first byte, end and content of each record from the file's position to its footer.

    Raises DamagedError if the file ends before its footer, or a record cannot be read.
    """
    start = file.tell()
    size = file.seek(0, os.SEEK_END)
    file.seek(start)
    record = None
    while not isinstance(record, records.Footer):
        header = file.read(HEADER_BYTES)
        if len(header) < HEADER_BYTES:
            raise DamagedError(f"the file ends at byte {size}, before its footer")
        opcode, length = header[0], int.from_bytes(header[1:], "little")
        end = start + HEADER_BYTES + length
        if end > size:
            raise DamagedError(f"the file ends at byte {size}, within the record at {start}")
        try:
            record = _parsed(opcode, file.read(length))
        except _UNREADABLE as error:
            raise DamagedError(f"the record at byte {start} cannot be read") from error
        yield start, end, record
        start = end
    if file.read() != MCAP0_MAGIC:
        raise DamagedError(f"the file does not end as MCAP files do, after byte {start}")


def _parsed(opcode: int, body: bytes) -> Record:
    stream = ReadDataStream(BytesIO(body))
    if opcode == Opcode.MESSAGE_INDEX:  # the mcap package would read it entry by entry
        channel, length = struct.unpack_from("<HI", body)
        return MessageIndex(channel, np.frombuffer(body, INDEX_ENTRY, length // 16, 6))
    if opcode == Opcode.MESSAGE:
        return records.Message.read(stream, len(body))  # type: ignore[no-any-return]
    if opcode not in list(Opcode):
        return None
    name = Opcode(opcode).name.title().replace("_", "")  # CHUNK_INDEX is read by ChunkIndex
    kind: Any = getattr(records, name)
    return kind.read(stream)  # type: ignore[no-any-return]


def unpack(chunk: records.Chunk) -> tuple[list[Record], dict[int, Messages]]:
    """Return the schemas and channels of a chunk, and its messages by channel.

    Raises DamagedError if the chunk is not what was written.
    """
    raw = _decompressed(chunk)
    described: list[Record] = []
    found: dict[int, list[int]] = {}
    start, last = 0, len(raw) - _MESSAGE_HEAD.size
    while start <= last:
        opcode, length, channel = _MESSAGE_HEAD.unpack_from(raw, start)
        size = HEADER_BYTES + length
        if start + size > len(raw):
            break
        if opcode == Opcode.MESSAGE:
            if size < MESSAGE_PREFIX.itemsize:
                break
            starts = found.setdefault(channel, [])
            head = raw[start : start + _MESSAGE_HEAD.size]
            while raw.startswith(head, start):  # neighbours are often of one channel and length
                starts.append(start)
                start += size
            if start > len(raw):
                break
            continue
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            try:
                described.append(_parsed(opcode, raw[start + HEADER_BYTES : start + size]))
            except _UNREADABLE as error:
                raise DamagedError("a record within a chunk cannot be read") from error
        start += size
    if start != len(raw):
        raise DamagedError("the records within a chunk do not fill it")
    return described, {channel: Messages.at(raw, starts) for channel, starts in found.items()}


def _decompressed(chunk: records.Chunk) -> bytes:
    kind = chunk.compression
    if kind not in ("zstd", "lz4", ""):
        raise DamagedError(f"a chunk is compressed as {kind!r}, which is not read here")
    try:
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        raw = stream.read(size)
    except CRCValidationError as error:
        raise DamagedError("the check sum of a chunk does not fit its content") from error
    except (ZstdError, RuntimeError, MemoryError, OverflowError) as error:
        raise DamagedError("a chunk cannot be decompressed") from error
    if size != chunk.uncompressed_size:
        raise DamagedError("a chunk has not the size that it claims")
    return raw


def _items(raw: bytes, offsets: NDArray[np.int64], layout: np.dtype[np.void]) -> NDArray[np.void]:
    """Return copies of the items of a layout that begin at `offsets`."""
    # Every byte begins an item of this view, so that picking items is one fast copy.
    count = max(len(raw) - layout.itemsize + 1, 0)
    overlapping = np.ndarray((count,), np.dtype(f"V{layout.itemsize}"), raw, 0, (1,))
    return overlapping[offsets].view(layout)


def read_summary(file: BinaryIO) -> list[records.McapRecord]:
    """Return the records of a file's summary; none if it is missing or damaged."""
    size = file.seek(0, os.SEEK_END)
    tail = len(record_bytes(records.Footer(0, 0, 0)) + MCAP0_MAGIC)
    if size < len(MCAP0_MAGIC) + tail:
        return []
    file.seek(size - tail)
    try:
        ((_, _, footer),) = scan(file)
        if not isinstance(footer, records.Footer) or not footer.summary_start:
            return []
        file.seek(footer.summary_start)
        checked = file.read(size - len(MCAP0_MAGIC) - 4 - footer.summary_start)
        if footer.summary_crc not in (0, zlib.crc32(checked)):
            return []
        file.seek(footer.summary_start)
        return [each for _, _, each in scan(file) if isinstance(each, records.McapRecord)]
    except (DamagedError, ValueError, OverflowError):
        return []


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
