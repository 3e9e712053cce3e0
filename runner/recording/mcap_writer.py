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
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC
from numpy.typing import NDArray
from zstandard import ZstdCompressor

CHUNK_BYTES = 1024 * 1024  # of messages before compression: what a kill may cost
FLUSH_SECONDS = 1.0  # of wall time, after which an unfinished chunk is written too
FIRST_FLUSH_SECONDS = 0.05  # the same for the first time; doubled each time, up to FLUSH_SECONDS
ZSTD_LEVEL = 1  # twice as fast as level 3 on smooth motion, with no larger files

MESSAGE_PREFIX = np.dtype(  # in front of each message
    {
        "names": ["opcode", "length", "channel", "sequence", "log_time", "publish_time"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
    }
)
HEADER_BYTES = 9  # of any record: opcode and length, which counts what follows
INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


class McapWriter:
    """Writes an MCAP file: chunks with check sums, message indexes, statistics and a summary.

    A chunk is written when it is full. An unfinished chunk is written after FLUSH_SECONDS, and
    later overwritten by the finished one, so that the bytes of the file do not depend on the
    speed of the run. The file is opened for writing, at its beginning; the writer does not close
    it.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._end = 0  # of the finished records, where the next one is written
        self._crc = 0
        self._blocks: list[tuple[int, NDArray[np.void]]] = []  # records of the unfinished chunk
        self._filled = 0  # bytes of the blocks
        self._compressor = ZstdCompressor(level=ZSTD_LEVEL)
        self._last_flush = time.monotonic()
        self._flush_after = FIRST_FLUSH_SECONDS
        self._summary: list[records.McapRecord] = []
        self._counts: Counter[int] = Counter()
        self._put(MCAP0_MAGIC)
        self.add(records.Header("", f"slipmode; {LIBRARY_IDENTIFIER}"))

    def add(self, record: records.McapRecord) -> None:
        """Append a schema, channel, attachment or metadata record.

        A schema precedes its channels, a channel precedes its messages.
        """
        self._finish_chunk()
        offset = self._end
        length = self._put(record_bytes(record))
        match record:
            case records.Schema() | records.Channel():
                self._summary.append(record)
            case records.Metadata():
                self._summary.append(records.MetadataIndex(offset, length, record.name))
            case records.Attachment(name=name, media_type=media_type, data=data):
                about = record.log_time, record.create_time, len(data), name, media_type
                self._summary.append(records.AttachmentIndex(offset, length, *about))

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
        start = self._end
        length = self._put(record_bytes(chunk))
        offsets = {}
        for channel, index in entries.items():
            offsets[channel] = self._end
            self._put(_index_bytes(channel, index))
            self._counts[channel] += len(index)
        self._file.truncate()  # the unfinished chunk before may have been longer
        self._file.flush()
        self._last_flush = time.monotonic()
        self._summary.append(
            records.ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                message_end_time=chunk.message_end_time,
                message_index_length=self._end - start - length,
                message_index_offsets=offsets,
                message_start_time=chunk.message_start_time,
                uncompressed_size=chunk.uncompressed_size,
            )
        )

    def flush(self) -> None:
        """Write everything to the file, including the unfinished chunk."""
        if self._blocks:
            chunk, entries = self._pack()
            self._file.write(record_bytes(chunk))
            self._file.writelines(_index_bytes(*item) for item in entries.items())
        self._file.flush()
        self._file.seek(self._end)
        self._last_flush = time.monotonic()

    def finish(self) -> None:
        """Write the last chunk, the summary and the footer."""
        self._finish_chunk()
        self._put(record_bytes(records.DataEnd(self._crc)))
        self._summary.append(self._statistics())
        section = offsets = b""
        summary = sorted(map(record_bytes, self._summary), key=itemgetter(0))
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
        chunk = records.Chunk(
            compression="zstd",
            data=self._compressor.compress(raw),
            message_start_time=int(index["log_time"].min()),
            message_end_time=int(index["log_time"].max()),
            uncompressed_crc=zlib.crc32(raw),
            uncompressed_size=len(raw),
        )
        in_order = dict.fromkeys(channel for channel, _ in self._blocks)
        return chunk, {channel: index[channels == channel] for channel in in_order}

    def _statistics(self) -> records.Statistics:
        kinds = Counter(type(record) for record in self._summary)
        chunks = [each for each in self._summary if isinstance(each, records.ChunkIndex)]
        return records.Statistics(
            attachment_count=kinds[records.AttachmentIndex],
            channel_count=kinds[records.Channel],
            channel_message_counts=dict(sorted(self._counts.items())),
            chunk_count=len(chunks),
            message_count=self._counts.total(),
            metadata_count=kinds[records.MetadataIndex],
            message_start_time=min((c.message_start_time for c in chunks), default=0),
            message_end_time=max((c.message_end_time for c in chunks), default=0),
            schema_count=kinds[records.Schema],
        )

    def _put(self, data: bytes) -> int:
        """Append bytes to the data section; return their number."""
        self._file.write(data)
        self._end += len(data)
        self._crc = zlib.crc32(data, self._crc)
        return len(data)


def record_bytes(record: records.McapRecord) -> bytes:
    """Return a record as it is written to a file."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


@cache
def _message_layout(size: int) -> np.dtype[np.void]:
    """Return the layout of a message record with `size` bytes of "data"."""
    prefix = [(name, MESSAGE_PREFIX[name]) for name in MESSAGE_PREFIX.names or ()]
    return np.dtype([*prefix, ("data", f"V{size}")])


def _index_bytes(channel: int, entries: NDArray[np.void]) -> bytes:
    """Return a message index record; the mcap package would write it entry by entry."""
    body = channel.to_bytes(2, "little") + entries.nbytes.to_bytes(4, "little") + entries.tobytes()
    return bytes([Opcode.MESSAGE_INDEX]) + len(body).to_bytes(8, "little") + body
