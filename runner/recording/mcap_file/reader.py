"""Reading of chunks of MCAP files as arrays of messages, within a limit of memory.

This reader is our own because the readers of the mcap package take messages one by one, and end
at the first damage. With messages of 12 doubles it is 20 to 22 times as fast as they are with
protobuf (`make bench-recordings`). Records other than messages are parsed by the mcap package.
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Iterator
from dataclasses import dataclass

import lz4.frame
import numpy as np
import zstandard
from mcap import records
from mcap.opcode import Opcode
from numpy.typing import NDArray

from slipmode.rom.short_repr import short_repr
from slipmode.rom.storage.stored_arrays import MIB
from slipmode.runner.recording.mcap_file.records import (
    INDEX_ENTRY,
    MESSAGE_PREFIX,
    RECORD_HEAD,
    DamagedError,
    Record,
    parsed,
)

# Memory for each byte of a chunk: shortest messages have 31 bytes, and their offsets, prefixes and
# index entries, sorted and not, take 3.3 times as much; test_reader_memory.py measures the sum.
CHUNK_COPIES = 5
_CHANNEL_BYTES = 2  # of the channel's number, which follows the head of a message


class TooLargeError(DamagedError):
    """A chunk unpacks to more bytes than a reader may allocate."""

    def __init__(self, size: int, most: int) -> None:
        self.size = size
        limit = f"{most // MIB} MiB that the limit of memory allows (SLIPMODE_MEMORY_MIB)"
        super().__init__(f"a chunk unpacks to {size / MIB:.0f} MiB, more than the {limit}")


@dataclass(frozen=True)
class Messages:
    """Messages of one channel within a chunk, in the order of the file."""

    raw: bytes  # The decompressed chunk
    offsets: NDArray[np.int64]  # (n,): Where the records of the messages begin
    prefix: NDArray[np.void]  # (n,): Their MESSAGE_PREFIX, with lengths and times

    __repr__ = short_repr

    @property
    def entries(self) -> NDArray[np.void]:
        """Their INDEX_ENTRY items, shape (n,)."""
        found = np.empty(len(self.offsets), INDEX_ENTRY)
        found["log_time"], found["offset"] = self.prefix["log_time"], self.offsets
        return found

    @property
    def ends(self) -> NDArray[np.int64]:
        """Where the records of the messages end, shape (n,)."""
        ends: NDArray[np.int64] = self.offsets + RECORD_HEAD.size
        return ends + self.prefix["length"].astype(np.int64)

    def data(self) -> NDArray[np.void]:
        """Return the messages, shape (n,); raise DamagedError if their lengths differ."""
        if np.ptp(self.prefix["length"]):
            raise DamagedError("messages of one channel differ in length")
        size = int(self.prefix["length"][0]) + RECORD_HEAD.size - MESSAGE_PREFIX.itemsize
        return _items(self.raw, self.offsets + MESSAGE_PREFIX.itemsize, np.dtype(f"V{size}"))

    def each(self) -> Iterator[tuple[int, bytes]]:
        """Yield the log time [ns] and the bytes of each message."""
        starts = self.offsets + MESSAGE_PREFIX.itemsize
        for time_ns, start, end in zip(self.prefix["log_time"], starts, self.ends, strict=True):
            yield int(time_ns), self.raw[start:end]


def unpack(chunk: records.Chunk, most: int) -> tuple[bytes, list[Record], dict[int, Messages]]:
    """Return the bytes of a chunk, its schemas and channels, and its messages by channel.

    Raises DamagedError if the chunk is not what was written, TooLargeError if it has more than
    `most` bytes.
    """
    raw = _decompressed(chunk, most)
    described: dict[bytes, Record] = {}  # by their bytes: a chunk may repeat them
    found: dict[int, array[int]] = {}
    start = 0
    while start + RECORD_HEAD.size + _CHANNEL_BYTES <= len(raw):
        opcode, length = RECORD_HEAD.unpack_from(raw, start)
        size = RECORD_HEAD.size + length
        if start + size > len(raw):
            break
        if opcode == Opcode.MESSAGE:
            if size < MESSAGE_PREFIX.itemsize:
                break
            head = raw[start : start + RECORD_HEAD.size + _CHANNEL_BYTES]
            channel = int.from_bytes(head[RECORD_HEAD.size :], "little")
            starts = found.setdefault(channel, array("q"))
            while raw.startswith(head, start):  # neighbours are often of one channel and length
                starts.append(start)
                start += size
            if start > len(raw):
                break
            continue
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            body = raw[start : start + size]
            described[body] = described.get(body) or parsed(opcode, body[RECORD_HEAD.size :])
        start += size
    if start != len(raw):
        raise DamagedError("the records within a chunk do not fill it")
    messages = {}
    for channel, starts in found.items():
        offsets = np.frombuffer(starts, np.int64)
        messages[channel] = Messages(raw, offsets, _items(raw, offsets, MESSAGE_PREFIX))
    return raw, list(described.values()), messages


def _decompressed(chunk: records.Chunk, most: int) -> bytes:
    """Return the content of a chunk, of at most `most` bytes, and right by its check sum."""
    kind, data, claimed = chunk.compression, chunk.data, chunk.uncompressed_size
    try:
        if kind == "":
            size = len(data)
        elif kind == "zstd":
            size = zstandard.frame_content_size(data)
        elif kind == "lz4":
            size = lz4.frame.get_frame_info(data)["content_size"] or -1
        else:
            raise DamagedError(f"a chunk is compressed as {kind!r}, which is not read here")
        size = claimed if size < 0 else size  # not all compressors state it
        if size > most:
            raise TooLargeError(size, most)
        if kind == "zstd" and data:
            data = zstandard.decompress(data, max(size, 1))
        elif kind == "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(data, size + 1)
    except (zstandard.ZstdError, RuntimeError, MemoryError, OverflowError) as error:
        raise DamagedError("a chunk cannot be decompressed") from error
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise DamagedError("the check sum of a chunk does not fit its content")
    if len(data) != size:
        raise DamagedError("a chunk has not the size that it claims")
    return data


def _items(raw: bytes, offsets: NDArray[np.int64], layout: np.dtype[np.void]) -> NDArray[np.void]:
    """Return copies of the items of a layout that begin at `offsets`."""
    # Every byte begins an item of this view, so that picking items is one fast copy.
    count = max(len(raw) - layout.itemsize + 1, 0)
    overlapping = np.ndarray((count,), np.dtype(f"V{layout.itemsize}"), raw, 0, (1,))
    return overlapping[offsets].view(layout)
