"""Writing of MCAP files: arrays of messages become whole chunks at once.

The Writer of the mcap package takes messages one by one: 0.2 million a second, against 3 million
here (`make bench-recordings`). Everything but the messages is written by its records.
"""

from __future__ import annotations

import time
import zlib
from collections import Counter
from collections.abc import Mapping
from functools import cache
from itertools import groupby
from operator import itemgetter
from typing import IO

import numpy as np
import zstandard
from mcap import records
from mcap.opcode import Opcode
from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC
from numpy.typing import NDArray

from slipmode.runner.recording.contents.layout import (
    HEADER_BYTES,
    INDEX_ENTRY,
    MESSAGE_PREFIX,
    MessageIndex,
    record_bytes,
)
from slipmode.runner.recording.contents.summary import Summary

CHUNK_BYTES = 1024 * 1024  # of messages before compression: what a kill may cost
FLUSH_SECONDS = 1.0  # of wall time, after which an unfinished chunk is written too
FIRST_FLUSH_SECONDS = 0.05  # the same for the first time; doubled each time, up to FLUSH_SECONDS
ZSTD_LEVEL = 1  # twice as fast as level 3 on smooth motion, with no larger files

OWN_HEADER = records.Header("", f"slipmode; {LIBRARY_IDENTIFIER}")


class McapWriter:
    """Writes an MCAP file: chunks with check sums, message indexes, statistics and a summary.

    A chunk is written when it is full. An unfinished chunk is written after FLUSH_SECONDS, and
    later overwritten by the finished one, so that the bytes of the file do not depend on the
    speed of the run. The file is opened for writing, at its beginning; the writer does not close
    it.
    """

    def __init__(self, file: IO[bytes], header: records.Header = OWN_HEADER) -> None:
        self._file = file
        self._end = 0  # of the finished records, where the next one is written
        self._crc = 0
        self._blocks: list[tuple[int, NDArray[np.void]]] = []  # records of the unfinished chunk
        self._filled = 0  # bytes of the blocks
        self._last_flush = time.monotonic()
        self._flush_after = FIRST_FLUSH_SECONDS
        self._summary = Summary()
        self._counts: Counter[int] = Counter()
        self._times: list[int] = []  # first and last of each chunk [ns]
        self._put(MCAP0_MAGIC)
        self.add(header)

    def add(self, record: records.McapRecord) -> None:
        """Append a schema, channel, attachment or metadata record.

        A schema precedes its channels, a channel precedes its messages.
        """
        self._finish_chunk()
        self._put_record(record)

    def add_messages(
        self, channel: int, time_ns: NDArray[np.int64], messages: NDArray[np.void]
    ) -> None:
        """Append messages (n,) of one length to a channel, logged at `time_ns` (n,) [ns]."""
        layout = _message_layout(messages.dtype.itemsize)
        rows = max(CHUNK_BYTES // layout.itemsize, 1)
        for start in range(0, len(messages), rows):
            part = slice(start, start + rows)
            block = np.zeros(len(messages[part]), layout)
            block["opcode"] = Opcode.MESSAGE
            block["length"] = layout.itemsize - HEADER_BYTES
            block["channel"] = channel
            block["log_time"] = block["publish_time"] = time_ns[part]
            block["data"] = messages[part].view(layout["data"])
            if self._filled + block.nbytes > CHUNK_BYTES:
                self._finish_chunk()
            self._blocks.append((channel, block))
            self._filled += block.nbytes
        if time.monotonic() - self._last_flush > self._flush_after:
            self._flush_after = min(2.0 * self._flush_after, FLUSH_SECONDS)
            self.flush()

    def add_chunk(self, chunk: records.Chunk, entries: Mapping[int, NDArray[np.void]]) -> None:
        """Append a finished chunk; `entries` has the INDEX_ENTRY items of each channel."""
        self._finish_chunk()
        self._put_record(chunk)
        for channel, index in entries.items():
            self._put_record(MessageIndex(channel, index))
            self._counts[channel] += len(index)
        if entries:
            self._times += [chunk.message_start_time, chunk.message_end_time]
        self._file.truncate()  # the unfinished chunk before may have been longer
        self._file.flush()
        self._last_flush = time.monotonic()

    def flush(self) -> None:
        """Write everything to the file, including the unfinished chunk."""
        if self._blocks:
            chunk, entries = self._pack()
            self._file.write(record_bytes(chunk))
            self._file.writelines(record_bytes(MessageIndex(*item)) for item in entries.items())
        self._file.flush()
        self._file.seek(self._end)
        self._last_flush = time.monotonic()

    def finish(self) -> None:
        """Write the last chunk, the summary and the footer."""
        self._finish_chunk()
        self._put(record_bytes(records.DataEnd(self._crc)))
        first, last = min(self._times, default=0), max(self._times, default=0)
        listed = [*self._summary.records, self._summary.statistics(self._counts, first, last)]
        section = offsets = b""
        summary = sorted(map(record_bytes, listed), key=itemgetter(0))
        for opcode, group in groupby(summary, itemgetter(0)):
            start, data = self._end + len(section), b"".join(group)
            offsets += record_bytes(records.SummaryOffset(opcode, start, len(data)))
            section += data
        footer = records.Footer(self._end, self._end + len(section), 0)
        checked = section + offsets + record_bytes(footer)[:-4]  # all but the check sum itself
        self._put(checked + zlib.crc32(checked).to_bytes(4, "little") + MCAP0_MAGIC)
        self._file.flush()

    def _finish_chunk(self) -> None:
        if self._blocks:
            packed = self._pack()
            self._blocks, self._filled = [], 0
            self.add_chunk(*packed)

    def _pack(self) -> tuple[records.Chunk, dict[int, NDArray[np.void]]]:
        """Return the blocks as a chunk, and the index entries of each channel."""
        counts = [len(block) for _, block in self._blocks]
        sizes = np.repeat([block.itemsize for _, block in self._blocks], counts)
        channels = np.repeat([channel for channel, _ in self._blocks], counts)
        index = np.empty(len(sizes), INDEX_ENTRY)
        index["log_time"] = np.concatenate([block["log_time"] for _, block in self._blocks])
        index["offset"] = np.cumsum(sizes) - sizes
        raw = b"".join(block.view(np.uint8).data for _, block in self._blocks)
        in_order = dict.fromkeys(channel for channel, _ in self._blocks)
        entries = {channel: index[channels == channel] for channel in in_order}
        return packed_chunk(raw, entries), entries

    def _put_record(self, record: records.McapRecord | MessageIndex) -> None:
        start = self._end
        self._put(record_bytes(record))
        self._summary.add(record, start, self._end)

    def _put(self, data: bytes) -> None:
        """Append bytes to the data section."""
        self._file.write(data)
        self._end += len(data)
        self._crc = zlib.crc32(data, self._crc)


def packed_chunk(raw: bytes, entries: Mapping[int, NDArray[np.void]]) -> records.Chunk:
    """Return a chunk of messages; `entries` has the INDEX_ENTRY items of each channel."""
    times = np.concatenate([each["log_time"] for each in entries.values()])
    return records.Chunk(
        compression="zstd",
        data=zstandard.compress(raw, ZSTD_LEVEL),
        message_start_time=int(times.min()),
        message_end_time=int(times.max()),
        uncompressed_crc=zlib.crc32(raw),
        uncompressed_size=len(raw),
    )


@cache
def _message_layout(size: int) -> np.dtype[np.void]:
    """Return the layout of a message record with `size` bytes of "data"."""
    prefix = [(name, MESSAGE_PREFIX[name]) for name in MESSAGE_PREFIX.names or ()]
    return np.dtype([*prefix, ("data", f"V{size}")])
