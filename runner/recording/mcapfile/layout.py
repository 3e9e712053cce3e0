"""Where bytes lie in the records of an MCAP file that come by the million."""

from __future__ import annotations

import struct
from functools import cache

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

RECORD_HEADER = struct.Struct("<BQ")  # opcode, and length of what follows
MESSAGE_PREFIX = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)  # of a message record, in front of the message itself
INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])
INDEX_HEADER = struct.Struct("<HI")  # channel, and length of the entries


@cache
def message_dtype(size: int) -> np.dtype[np.void]:
    """A message record whose message, field "data", takes `size` bytes."""
    prefix = [(name, MESSAGE_PREFIX[name]) for name in MESSAGE_PREFIX.names or ()]
    return np.dtype([*prefix, ("data", f"V{size}")])


def record_bytes(record: records.McapRecord) -> bytes:
    """A record as the bytes of the file."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def chunk_start(chunk: records.Chunk) -> bytes:
    """A chunk record as the bytes of the file, without its data, which would be copied."""
    name = chunk.compression.encode()
    length = 8 + 8 + 8 + 4 + 4 + len(name) + 8 + len(chunk.data)
    times = struct.pack("<QQ", chunk.message_start_time, chunk.message_end_time)
    raw = struct.pack("<QI", chunk.uncompressed_size, chunk.uncompressed_crc)
    packing = struct.pack(f"<I{len(name)}sQ", len(name), name, len(chunk.data))
    return RECORD_HEADER.pack(Opcode.CHUNK, length) + times + raw + packing


def index_bytes(channel: int, entries: NDArray[np.void]) -> bytes:
    """The record that says where in a chunk the messages of a channel are."""
    body = INDEX_HEADER.pack(channel, entries.nbytes) + entries.tobytes()
    return RECORD_HEADER.pack(Opcode.MESSAGE_INDEX, len(body)) + body
