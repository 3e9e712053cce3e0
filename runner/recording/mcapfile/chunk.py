"""What is in a chunk of an MCAP file: the messages of each channel, as arrays."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from io import BytesIO

import lz4.frame
import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from numpy.typing import NDArray
from zstandard import ZstdDecompressor, ZstdError

from slipmode.runner.recording.mcapfile.layout import INDEX_ENTRY, MESSAGE_PREFIX, RECORD_HEADER
from slipmode.runner.recording.mcapfile.scan import DamagedError, Index, StoredChunk


@dataclass(frozen=True)
class Messages:
    """Messages of one channel within a chunk, in the order of the file.

    Attributes
    ----------
    raw : bytes
        The whole chunk, decompressed.
    offsets : ndarray, shape (n,)
        Where their records begin.
    prefix : ndarray of MESSAGE_PREFIX, shape (n,)
        Their lengths and times.
    """

    raw: bytes
    offsets: NDArray[np.int64]
    prefix: NDArray[np.void]

    @property
    def entries(self) -> NDArray[np.void]:
        """Their index entries, shape (n,)."""
        found = np.empty(len(self.offsets), INDEX_ENTRY)
        found["log_time"], found["offset"] = self.prefix["log_time"], self.offsets
        return found

    def data(self) -> NDArray[np.void]:
        """The messages, shape (n,), if all have one length.

        Raises
        ------
        DamagedError
            If their lengths differ.
        """
        if np.ptp(self.prefix["length"]):
            raise DamagedError("messages of one channel differ in length")
        size = int(self.prefix["length"][0]) + RECORD_HEADER.size - MESSAGE_PREFIX.itemsize
        return _items(self.raw, self.offsets + MESSAGE_PREFIX.itemsize, np.dtype(f"V{size}"))

    def each(self) -> list[bytes]:
        """The messages one by one, of whatever lengths."""
        starts = self.offsets + MESSAGE_PREFIX.itemsize
        ends = self.offsets + RECORD_HEADER.size + self.prefix["length"].astype(np.int64)
        pairs = zip(starts.tolist(), ends.tolist(), strict=True)
        return [self.raw[start:end] for start, end in pairs]


@dataclass(frozen=True)
class Contents:
    """What is in a chunk.

    Attributes
    ----------
    messages : dict of int to Messages
        By channel.
    schemas, channels : list
        Those that the chunk brings along.
    """

    messages: dict[int, Messages]
    schemas: list[records.Schema] = field(default_factory=list)
    channels: list[records.Channel] = field(default_factory=list)


def unpack(stored: StoredChunk) -> Contents:
    """Decompress a chunk, check it, and find its messages.

    Its indexes save looking at each message; they are used if they account for every byte.

    Raises
    ------
    DamagedError
        If the chunk is not what was written.
    """
    raw = decompress(stored.chunk)
    return _indexed(raw, stored.indexes) or walk(raw)


def single(message: records.Message) -> Contents:
    """A message that lies outside of chunks, as if it were alone in one."""
    prefix = np.zeros(1, MESSAGE_PREFIX)
    prefix["length"] = MESSAGE_PREFIX.itemsize - RECORD_HEADER.size + len(message.data)
    prefix["log_time"], prefix["publish_time"] = message.log_time, message.publish_time
    raw = prefix.tobytes() + message.data
    return Contents({message.channel_id: Messages(raw, np.zeros(1, np.int64), prefix)})


def decompress(chunk: records.Chunk) -> bytes:
    """The content of a chunk, whose check sum is right.

    Raises
    ------
    DamagedError
        If it is not what was written.
    """
    match chunk.compression:
        case "zstd":
            try:
                raw = ZstdDecompressor().decompress(chunk.data, chunk.uncompressed_size)
            except (ZstdError, MemoryError, OverflowError) as error:
                raise DamagedError("a chunk cannot be decompressed") from error
        case "lz4":
            try:
                raw = lz4.frame.decompress(chunk.data)
            except (RuntimeError, MemoryError) as error:
                raise DamagedError("a chunk cannot be decompressed") from error
        case "":
            raw = chunk.data
        case other:
            raise DamagedError(f"a chunk is compressed as {other!r}, which is not read here")
    if len(raw) != chunk.uncompressed_size:
        raise DamagedError("a chunk has not the size that it claims")
    if chunk.uncompressed_crc not in (0, zlib.crc32(raw)):
        raise DamagedError("the check sum of a chunk does not fit its content")
    return raw


def _indexed(raw: bytes, indexes: Sequence[Index]) -> Contents | None:
    """Messages where indexes say they are, or None if that is not the whole chunk."""
    messages = {}
    covered = 0
    last = len(raw) - MESSAGE_PREFIX.itemsize
    for index in indexes:
        offsets = index.entries["offset"].astype(np.int64)
        if not np.all((offsets >= 0) & (offsets <= last)):
            return None
        prefix = _items(raw, offsets, MESSAGE_PREFIX)
        if np.any((prefix["opcode"] != Opcode.MESSAGE) | (prefix["channel"] != index.channel)):
            return None
        if offsets.size:
            messages[index.channel] = Messages(raw, offsets, prefix)
        covered += int(prefix["length"].sum()) + RECORD_HEADER.size * offsets.size
    return Contents(messages) if covered == len(raw) else None


def walk(raw: bytes) -> Contents:
    """What is in a decompressed chunk, found record by record.

    Raises
    ------
    DamagedError
        If the records do not fill the chunk.
    """
    found: dict[int, list[int]] = {}
    schemas, channels = [], []
    start = 0
    channel_at = RECORD_HEADER.size
    while start + RECORD_HEADER.size <= len(raw):
        opcode, length = RECORD_HEADER.unpack_from(raw, start)
        end = start + RECORD_HEADER.size + length
        if end > len(raw):
            break
        if opcode == Opcode.MESSAGE:
            if end - start < MESSAGE_PREFIX.itemsize:
                break
            number = int.from_bytes(raw[start + channel_at : start + channel_at + 2], "little")
            found.setdefault(number, []).append(start)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            stream = ReadDataStream(BytesIO(raw[start + RECORD_HEADER.size : end]))
            try:
                if opcode == Opcode.SCHEMA:
                    schemas.append(records.Schema.read(stream))
                else:
                    channels.append(records.Channel.read(stream))
            except (McapError, ValueError) as error:
                raise DamagedError("a record within a chunk cannot be read") from error
        start = end
    if start != len(raw):
        raise DamagedError("the records within a chunk do not fill it")
    messages = {}
    for number, starts in found.items():
        offsets = np.array(starts, dtype=np.int64)
        messages[number] = Messages(raw, offsets, _items(raw, offsets, MESSAGE_PREFIX))
    return Contents(messages, schemas, channels)


def _items(raw: bytes, offsets: NDArray[np.int64], layout: np.dtype[np.void]) -> NDArray[np.void]:
    """Copies of the items of a layout that begin at some offsets."""
    count = len(raw) - layout.itemsize + 1
    if count <= 0 or not offsets.size:
        return np.empty(0, layout)
    # Every byte begins an item of this view, so that picking items is one fast copy.
    overlapping = np.ndarray((count,), np.dtype(f"V{layout.itemsize}"), raw, 0, (1,))
    try:
        return overlapping[offsets].view(layout)
    except IndexError as error:
        raise DamagedError("a message reaches beyond its chunk") from error
