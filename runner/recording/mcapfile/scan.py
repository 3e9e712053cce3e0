"""The records of an MCAP file in their order, without its summary: as far as the file goes."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from typing import BinaryIO

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

from slipmode.runner.recording.mcapfile.layout import INDEX_ENTRY, INDEX_HEADER, RECORD_HEADER

_READERS: Mapping[int, Callable[[ReadDataStream], records.McapRecord]] = {
    Opcode.HEADER: records.Header.read,
    Opcode.FOOTER: records.Footer.read,
    Opcode.SCHEMA: records.Schema.read,
    Opcode.CHANNEL: records.Channel.read,
    Opcode.CHUNK: records.Chunk.read,
    Opcode.CHUNK_INDEX: records.ChunkIndex.read,
    Opcode.ATTACHMENT: records.Attachment.read,
    Opcode.ATTACHMENT_INDEX: records.AttachmentIndex.read,
    Opcode.STATISTICS: records.Statistics.read,
    Opcode.METADATA: records.Metadata.read,
    Opcode.METADATA_INDEX: records.MetadataIndex.read,
    Opcode.SUMMARY_OFFSET: records.SummaryOffset.read,
    Opcode.DATA_END: records.DataEnd.read,
}
_UNREADABLE = (McapError, struct.error, ValueError, OverflowError, MemoryError)


class DamagedError(Exception):
    """Why a part of a file cannot be read."""


@dataclass(frozen=True)
class Index:
    """Where the messages of one channel are in the chunk before it.

    Attributes
    ----------
    channel : int
    entries : ndarray of INDEX_ENTRY, shape (n,)
    """

    channel: int
    entries: NDArray[np.void]


@dataclass(frozen=True)
class StoredChunk:
    """A chunk as it lies in the file.

    Attributes
    ----------
    chunk : Chunk
        Its content compressed.
    indexes : list of Index
        What follows it.
    cut : bool
        Whether the file is damaged behind it, so that indexes may be missing.
    """

    chunk: records.Chunk
    indexes: list[Index]
    cut: bool = False

    @property
    def count(self) -> int:
        """How many messages the indexes tell of."""
        return sum(len(index.entries) for index in self.indexes)


@dataclass(frozen=True)
class Piece:
    """One record of a file, or a chunk with its indexes.

    Attributes
    ----------
    offset, end : int
        Where its bytes are.
    record : McapRecord, StoredChunk, Index, or None
        An Index is one without a chunk, None a record that is not known here.
    """

    offset: int
    end: int
    record: records.McapRecord | StoredChunk | Index | None


def scan(file: BinaryIO) -> Iterator[Piece]:
    """Records of a file, from where it stands to the magic behind its footer.

    Raises
    ------
    DamagedError
        Where the file ends before its time, or a record cannot be read; a chunk that is whole
        comes first, also if its indexes are not.
    """
    chunk: StoredChunk | None = None
    start = end = 0
    damage = None
    try:
        for piece in _records(file):
            match piece.record:
                case Index() if chunk is not None:
                    chunk.indexes.append(piece.record)
                    end = piece.end
                    continue
                case records.Chunk():
                    if chunk is not None:
                        yield Piece(start, end, chunk)
                    chunk = StoredChunk(piece.record, [])
                    start, end = piece.offset, piece.end
                    continue
            if chunk is not None:
                yield Piece(start, end, chunk)
                chunk = None
            yield piece
    except DamagedError as error:
        damage = error
    if chunk is not None:
        yield Piece(start, end, replace(chunk, cut=True))
    if damage is not None:
        raise damage


def _records(file: BinaryIO) -> Iterator[Piece]:
    """Records one by one; a footer and the magic behind it come last."""
    offset = file.tell()
    size = file.seek(0, os.SEEK_END)
    file.seek(offset)
    record = None
    while not isinstance(record, records.Footer):
        header = file.read(RECORD_HEADER.size)
        if len(header) < RECORD_HEADER.size:
            raise DamagedError(f"the file ends at byte {size}, before its footer")
        opcode, length = RECORD_HEADER.unpack(header)
        end = offset + RECORD_HEADER.size + length
        if end > size:
            raise DamagedError(f"the file ends at byte {size}, within the record at {offset}")
        try:
            record = _parse(opcode, file.read(length))
        except _UNREADABLE as error:
            raise DamagedError(f"the record at byte {offset} cannot be read") from error
        yield Piece(offset, end, record)
        offset = end
    if file.read() != MCAP0_MAGIC:
        raise DamagedError(f"the file does not end as MCAP files do, after byte {offset}")


def _parse(opcode: int, body: bytes) -> records.McapRecord | Index | None:
    match opcode:
        case Opcode.MESSAGE_INDEX:  # by hand: the package reads it an entry at a time
            channel, length = INDEX_HEADER.unpack_from(body)
            count = length // INDEX_ENTRY.itemsize
            return Index(channel, np.frombuffer(body, INDEX_ENTRY, count, INDEX_HEADER.size))
        case Opcode.MESSAGE:
            message: records.Message = records.Message.read(
                ReadDataStream(BytesIO(body)), len(body)
            )
            return message
        case known if known in _READERS:
            return _READERS[known](ReadDataStream(BytesIO(body)))
    return None
