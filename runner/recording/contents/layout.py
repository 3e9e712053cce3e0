"""Messages of MCAP files as arrays: the layout of their records."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

from slipmode.rom.short_repr import short_repr

MESSAGE_PREFIX = np.dtype(  # in front of each message
    {
        "names": ["opcode", "length", "channel", "sequence", "log_time", "publish_time"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
    }
)
HEADER_BYTES = 9  # of any record: opcode and length, which counts what follows
INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


class DamagedError(Exception):
    """Why a part of a file cannot be read."""


@dataclass(frozen=True)
class MessageIndex:
    """Where the messages of a channel are in the chunk before it: INDEX_ENTRY items."""

    channel: int
    entries: NDArray[np.void]

    __repr__ = short_repr


@dataclass(frozen=True)
class Messages:
    """Messages of one channel within a chunk, in the order of the file."""

    raw: bytes  # The decompressed chunk
    offsets: NDArray[np.int64]  # (n,): Where the records of the messages begin
    prefix: NDArray[np.void]  # (n,): Their MESSAGE_PREFIX, with lengths and times

    __repr__ = short_repr

    @classmethod
    def at(cls, raw: bytes, starts: NDArray[np.int64]) -> Messages:
        """Return the messages whose records begin at `starts`."""
        return cls(raw, starts, _items(raw, starts, MESSAGE_PREFIX))

    @property
    def entries(self) -> NDArray[np.void]:
        """Their INDEX_ENTRY items, shape (n,)."""
        found = np.empty(len(self.offsets), INDEX_ENTRY)
        found["log_time"], found["offset"] = self.prefix["log_time"], self.offsets
        return found

    @property
    def ends(self) -> NDArray[np.int64]:
        """Where the records of the messages end, shape (n,)."""
        ends: NDArray[np.int64] = self.offsets + HEADER_BYTES
        return ends + self.prefix["length"].astype(np.int64)

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
        starts = self.offsets + MESSAGE_PREFIX.itemsize
        for time_ns, start, end in zip(self.prefix["log_time"], starts, self.ends, strict=True):
            yield int(time_ns), self.raw[start:end]


def record_bytes(record: records.McapRecord | MessageIndex) -> bytes:
    """Return a record as it is written to a file."""
    if isinstance(record, MessageIndex):  # the mcap package would write it entry by entry
        data = record.entries.tobytes()
        body = struct.pack("<HI", record.channel, len(data)) + data
        return struct.pack("<BQ", Opcode.MESSAGE_INDEX, len(body)) + body
    builder = RecordBuilder()
    record.write(builder)
    written: bytes = builder.end()  # type: ignore[no-untyped-call]
    return written


def _items(raw: bytes, offsets: NDArray[np.int64], layout: np.dtype[np.void]) -> NDArray[np.void]:
    """Return copies of the items of a layout that begin at `offsets`."""
    # Every byte begins an item of this view, so that picking items is one fast copy.
    count = max(len(raw) - layout.itemsize + 1, 0)
    overlapping = np.ndarray((count,), np.dtype(f"V{layout.itemsize}"), raw, 0, (1,))
    return overlapping[offsets].view(layout)
