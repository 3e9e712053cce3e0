"""Writing an MCAP file in whole chunks, each built from arrays of messages at once."""

from __future__ import annotations

import time
import zlib
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import IO

import numpy as np
from mcap import records
from mcap.opcode import Opcode
from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC
from numpy.typing import NDArray
from zstandard import ZstdCompressor

from slipmode.runner.recording.mcapfile.layout import (
    INDEX_ENTRY,
    RECORD_HEADER,
    chunk_start,
    index_bytes,
    message_dtype,
    record_bytes,
)
from slipmode.runner.recording.mcapfile.summary import Summary

CHUNK_BYTES = 1024 * 1024  # of messages before compression; two of them are in memory at most
FLUSH_SECONDS = 1.0  # of wall time, after which an unfinished chunk is put on disk too
FIRST_FLUSH_SECONDS = 0.05  # after which it is for the first time; then twice as long each time

ZSTD_LEVEL = 1  # on samples of smooth motion it is twice as fast as level 3, and no larger


@dataclass(frozen=True)
class _Compressing:
    """A chunk whose data are to come, and the index entries of each channel."""

    chunk: records.Chunk
    entries: dict[int, NDArray[np.void]]
    data: Future[bytes]

    def result(self) -> records.Chunk:
        """The chunk, as soon as it is compressed."""
        return replace(self.chunk, data=self.data.result())


class McapWriter:
    """Writes an MCAP file: chunks with CRCs, message indexes, statistics and a summary.

    A full chunk is compressed in a thread beside, and is in the file before the next one is full.
    So is an unfinished one after FLUSH_SECONDS, and sooner in the beginning; it is later written
    over by its longer self, so that the bytes of a finished file do not depend on how fast it was
    written.

    Parameters
    ----------
    file : binary file
        Opened for writing, at its beginning.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._end = 0  # of what is finished, where the next record belongs
        self._unfinished_behind = False  # whether a part of the next chunk is there already
        self._crc = 0
        self._summary = Summary()
        self._pool = ThreadPoolExecutor(max_workers=1)
        self._compressor = ZstdCompressor(level=ZSTD_LEVEL)
        self._compressing: _Compressing | None = None
        self._buffer, self._spare = bytearray(CHUNK_BYTES), bytearray(CHUNK_BYTES)
        self._filled = 0
        self._entries: dict[int, list[NDArray[np.void]]] = {}
        self._last_flush = time.monotonic()
        self._flush_after = FIRST_FLUSH_SECONDS
        self._put(MCAP0_MAGIC)
        self._put(record_bytes(records.Header("", f"slipmode; {LIBRARY_IDENTIFIER}")))

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Append named text."""
        offset = self._end
        length = self._put(record_bytes(records.Metadata(name, dict(data))))
        self._summary.metadata.append(records.MetadataIndex(offset, length, name))

    def add_attachment(self, attachment: records.Attachment) -> None:
        """Append a file."""
        offset = self._end
        length = self._put(record_bytes(attachment))
        index = records.AttachmentIndex(
            *(offset, length, attachment.log_time, attachment.create_time),
            *(len(attachment.data), attachment.name, attachment.media_type),
        )
        self._summary.attachments.append(index)

    def add_schema(self, schema: records.Schema) -> None:
        """Append a schema, before any channel that refers to its number."""
        self._put(record_bytes(schema))
        self._summary.schemas.append(schema)

    def add_channel(self, channel: records.Channel) -> None:
        """Append a channel, before any message that refers to its number."""
        self._put(record_bytes(channel))
        self._summary.channels.append(channel)

    def add_messages(
        self, channel: int, time_ns: NDArray[np.int64], messages: NDArray[np.void]
    ) -> None:
        """Append messages of one length.

        Parameters
        ----------
        channel : int
            Number of their channel.
        time_ns : ndarray, shape (n,)
            When each was logged and published [ns].
        messages : ndarray, shape (n,)
            The bytes of an item are those of a message: its dtype has no padding.
        """
        size = message_dtype(messages.dtype.itemsize).itemsize
        done = 0
        while done < len(messages):
            room = (len(self._buffer) - self._filled) // size
            if room:
                part = slice(done, min(done + room, len(messages)))
                self._fill(channel, time_ns[part], messages[part])
                done = part.stop
            elif self._filled:
                self._finish_chunk()
            else:  # longer than a chunk, it gets one of its own
                self._buffer = bytearray(size)
        if self._compressing and self._compressing.data.done():
            self._put_whole_chunks()
        if time.monotonic() - self._last_flush > self._flush_after:
            self._flush_after = min(2.0 * self._flush_after, FLUSH_SECONDS)
            self.flush()

    def add_chunk(self, chunk: records.Chunk, entries: Mapping[int, NDArray[np.void]]) -> None:
        """Append a chunk as it is; `entries` index the messages of each channel."""
        self._finish_chunk()
        self._put_whole_chunks()
        self._put_chunk(chunk, entries)

    def flush(self) -> None:
        """Put in the file what was added until now, an unfinished chunk included."""
        self._put_whole_chunks()
        if self._filled:
            unfinished = self._start_compressing()
            chunk = unfinished.result()
            self._file.writelines((chunk_start(chunk), chunk.data))
            self._file.writelines(index_bytes(*item) for item in unfinished.entries.items())
            self._file.seek(self._end)
            self._unfinished_behind = True
        self._file.flush()
        self._last_flush = time.monotonic()

    def finish(self) -> None:
        """Write what is buffered, the summary and the footer; leaves the file open."""
        self._finish_chunk()
        self._put_whole_chunks()
        self._pool.shutdown()
        self._put(record_bytes(records.DataEnd(self._crc)))
        self._file.write(self._summary.to_bytes(self._end) + MCAP0_MAGIC)
        self._file.flush()

    def _fill(self, channel: int, time_ns: NDArray[np.int64], messages: NDArray[np.void]) -> None:
        """Lay messages out as records, behind those that the chunk holds."""
        layout = message_dtype(messages.dtype.itemsize)
        block = np.ndarray(len(messages), layout, self._buffer, self._filled)
        block["opcode"] = Opcode.MESSAGE
        block["length"] = layout.itemsize - RECORD_HEADER.size
        block["channel"] = channel
        block["sequence"] = 0
        block["log_time"] = block["publish_time"] = time_ns
        block["data"] = messages.view(layout["data"])
        entries = np.empty(len(messages), INDEX_ENTRY)
        entries["log_time"] = time_ns
        entries["offset"] = self._filled + layout.itemsize * np.arange(len(messages))
        self._entries.setdefault(channel, []).append(entries)
        self._filled += block.nbytes

    def _finish_chunk(self) -> None:
        """Have what was filled compressed, while the next chunk is being filled."""
        if not self._filled:
            return
        before, self._compressing = self._compressing, self._start_compressing()
        self._put_compressed(before)
        self._buffer, self._spare = self._spare, self._buffer
        if len(self._spare) != CHUNK_BYTES:
            self._spare = bytearray(CHUNK_BYTES)
        self._filled = 0
        self._entries = {}

    def _start_compressing(self) -> _Compressing:
        """Begin to compress what was filled, with its index."""
        raw = memoryview(self._buffer)[: self._filled]
        entries = {number: np.concatenate(parts) for number, parts in self._entries.items()}
        times = [index["log_time"] for index in entries.values()]
        chunk = records.Chunk(
            compression="zstd",
            data=b"",
            message_start_time=int(min(time_ns.min() for time_ns in times)),
            message_end_time=int(max(time_ns.max() for time_ns in times)),
            uncompressed_crc=zlib.crc32(raw),
            uncompressed_size=self._filled,
        )
        return _Compressing(chunk, entries, self._pool.submit(self._compressor.compress, raw))

    def _put_whole_chunks(self) -> None:
        """Write the chunk that is being compressed, if there is one."""
        before, self._compressing = self._compressing, None
        self._put_compressed(before)

    def _put_compressed(self, compressing: _Compressing | None) -> None:
        if compressing is not None:
            self._put_chunk(compressing.result(), compressing.entries)

    def _put_chunk(self, chunk: records.Chunk, entries: Mapping[int, NDArray[np.void]]) -> None:
        start = self._end
        self._put(chunk_start(chunk))
        self._put(chunk.data)
        length = self._end - start
        offsets = {}
        for number, index in entries.items():
            offsets[number] = self._end
            self._put(index_bytes(number, index))
            self._summary.counts[number] += len(index)
        if self._unfinished_behind:
            self._file.truncate()
            self._unfinished_behind = False
        self._file.flush()
        self._last_flush = time.monotonic()
        self._summary.chunks.append(
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

    def _put(self, data: bytes) -> int:
        """Append bytes to the data section; returns their number."""
        self._file.write(data)
        self._end += len(data)
        self._crc = zlib.crc32(data, self._crc)
        return len(data)
