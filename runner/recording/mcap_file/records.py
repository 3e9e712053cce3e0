"""Records of MCAP files, from bytes and to bytes; the layout of messages and of their index."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from numpy.typing import NDArray

from slipmode.rom.short_repr import short_repr

MESSAGE_PREFIX = np.dtype(  # in front of each message
    {
        "names": ["opcode", "length", "channel", "sequence", "log_time", "publish_time"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
    }
)
RECORD_HEAD = struct.Struct("<BQ")  # of any record: opcode, and length of what follows
INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


class DamagedError(Exception):
    """Why a part of a file cannot be read."""


@dataclass(eq=False)
class MessageIndex(records.McapRecord):
    """Where the messages of a channel are in the chunk before it: INDEX_ENTRY items.

    The record of the mcap package is read and written entry by entry.
    """

    channel: int
    entries: NDArray[np.void]

    __repr__ = short_repr

    def write(self, stream: RecordBuilder) -> None:
        """Append the record to a stream."""
        data = self.entries.tobytes()
        stream.start_record(Opcode.MESSAGE_INDEX)
        stream.write(struct.pack("<HI", self.channel, len(data)) + data)
        stream.finish_record()  # type: ignore[no-untyped-call]

    @staticmethod
    def read(stream: ReadDataStream) -> MessageIndex:
        """Return the record whose content a stream has."""
        channel, size = stream.read2(), stream.read4()
        return MessageIndex(channel, np.frombuffer(stream.read(size), INDEX_ENTRY))


class Loose(records.Chunk):
    """Messages outside chunks, one record after the other, as the data of a chunk."""

    def __init__(self, raw: bytes) -> None:
        super().__init__("", raw, 0, 0, 0, len(raw))


Record = records.McapRecord | None  # None: of a kind that is unknown here

_KINDS: dict[int, Any] = {  # CHUNK_INDEX is read by ChunkIndex
    **{code: getattr(records, code.name.title().replace("_", "")) for code in Opcode},
    Opcode.MESSAGE_INDEX: MessageIndex,
}


def record_bytes(record: records.McapRecord) -> bytes:
    """Return a record as it is written to a file."""
    builder = RecordBuilder()
    record.write(builder)
    written: bytes = builder.end()  # type: ignore[no-untyped-call]
    return written


def parsed(opcode: int, body: bytes) -> Record:
    """Return a record; raise DamagedError if its parts do not fit its length."""
    if opcode not in _KINDS:
        return None
    try:
        record: records.McapRecord = _KINDS[opcode].read(ReadDataStream(BytesIO(body)))
        again = record_bytes(record)[RECORD_HEAD.size :]
    except (McapError, struct.error, ValueError, OverflowError, MemoryError) as error:
        raise DamagedError(f"a record of kind {opcode} cannot be read") from error
    if isinstance(record, records.Attachment) and body[-4:] == bytes(4):  # without a check sum
        again = again[:-4] + bytes(4)
    if not body.startswith(again):  # later versions may append fields
        raise DamagedError(f"the parts of a record of kind {opcode} do not fit its length")
    return record
