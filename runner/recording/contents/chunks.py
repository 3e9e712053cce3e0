"""Chunks of MCAP files as arrays of messages, within a limit of memory."""

from __future__ import annotations

import struct
import zlib
from array import array

import lz4.frame
import numpy as np
import zstandard
from mcap import records
from mcap.opcode import Opcode

from slipmode.rom.storage.stored_arrays import MIB
from slipmode.runner.recording.contents.layout import (
    HEADER_BYTES,
    MESSAGE_PREFIX,
    DamagedError,
    Messages,
)
from slipmode.runner.recording.contents.walk import UNREADABLE, Loose, Record, parsed

# Memory for each byte of a chunk: shortest messages have 31 bytes, and their offsets, prefixes and
# index entries, sorted and not, take 3.3 times as much; test_damage.py measures the sum.
CHUNK_COPIES = 5

_MESSAGE_HEAD = struct.Struct("<BQH")  # opcode, length, channel


class TooLargeError(DamagedError):
    """A chunk unpacks to more bytes than a reader may allocate."""

    def __init__(self, size: int, most: int) -> None:
        self.size = size
        limit = f"{most // MIB} MiB that the limit of memory allows (SLIPMODE_MEMORY_MIB)"
        super().__init__(f"a chunk unpacks to {size / MIB:.0f} MiB, more than the {limit}")


def unpack(
    chunk: records.Chunk | Loose, most: int
) -> tuple[bytes, list[Record], dict[int, Messages]]:
    """Return the bytes of a chunk, its schemas and channels, and its messages by channel.

    Raises DamagedError if the chunk is not what was written, TooLargeError if it has more than
    `most` bytes.
    """
    raw = chunk.raw if isinstance(chunk, Loose) else _decompressed(chunk, most)
    described: dict[bytes, Record] = {}  # by their bytes: a chunk may repeat them
    found: dict[int, array[int]] = {}
    start, last = 0, len(raw) - _MESSAGE_HEAD.size
    while start <= last:
        opcode, length, channel = _MESSAGE_HEAD.unpack_from(raw, start)
        size = HEADER_BYTES + length
        if start + size > len(raw):
            break
        if opcode == Opcode.MESSAGE:
            if size < MESSAGE_PREFIX.itemsize:
                break
            starts = found.setdefault(channel, array("q"))
            head = raw[start : start + _MESSAGE_HEAD.size]
            while raw.startswith(head, start):  # neighbours are often of one channel and length
                starts.append(start)
                start += size
            if start > len(raw):
                break
            continue
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            body = raw[start : start + size]
            try:
                described[body] = described.get(body) or parsed(opcode, body[HEADER_BYTES:])
            except UNREADABLE as error:
                raise DamagedError("a record within a chunk cannot be read") from error
        start += size
    if start != len(raw):
        raise DamagedError("the records within a chunk do not fill it")
    placed = {channel: np.frombuffer(starts, np.int64) for channel, starts in found.items()}
    messages = {channel: Messages.at(raw, starts) for channel, starts in placed.items()}
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
