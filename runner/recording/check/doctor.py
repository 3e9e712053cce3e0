"""Whether a recording is sound: `slipmode doctor`."""

from __future__ import annotations

import zlib
from os import PathLike
from typing import BinaryIO

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.load import sample_channel
from slipmode.runner.recording.mcapfile.chunk import Contents, decompress, walk
from slipmode.runner.recording.mcapfile.scan import DamagedError, Piece, StoredChunk, scan
from slipmode.runner.recording.mcapfile.source import opened
from slipmode.runner.recording.mcapfile.statistics import Statistics
from slipmode.runner.recording.mcapfile.summary import read_summary

_BLOCK = 1024 * 1024


def doctor(path: str | PathLike[str]) -> list[str]:
    """Check the structure of a recording, its check sums, its index and its times.

    Parameters
    ----------
    path : path
        An MCAP file.

    Returns
    -------
    list of str
        What is wrong, a line each; empty for a sound file.

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not MCAP.
    """
    with opened(path) as file:
        examination = _Examination(file)
        try:
            for piece in scan(file):
                examination.look_at(piece)
            examination.compare_with_summary()
        except DamagedError as error:
            examination.complaints.append(str(error))
    complaints = examination.complaints + examination.messages_outside_chunks()
    return complaints + examination.statistics.mixed_clocks()


class _Examination:
    """Complaints about a file, gathered as its records are met."""

    def __init__(self, file: BinaryIO) -> None:
        self.complaints: list[str] = []
        self._file = file
        self.statistics = Statistics()
        self._starts: list[int] = []
        self._outside: list[int] = []  # messages that no chunk holds
        self._disordered: set[int] = set()

    def look_at(self, piece: Piece) -> None:
        """Check one record, or a chunk with its indexes."""
        match piece.record:
            case StoredChunk():
                self._starts.append(piece.offset)
                try:
                    self._look_at_chunk(piece.record)
                except (DamagedError, SlipmodeError) as error:
                    self.complaints.append(f"chunk at byte {piece.offset}: {error}")
            case records.DataEnd(data_section_crc=crc) if crc:
                if crc != self._check_sum(piece.offset):
                    self.complaints.append("the check sum of the data section does not fit it")
            case records.Message():
                self._outside.append(piece.offset)
                self.statistics.take(piece.record)
            case other:
                self.statistics.take(other)

    def _look_at_chunk(self, stored: StoredChunk) -> None:
        contents = walk(decompress(stored.chunk))
        before = dict(self.statistics.last)
        self.statistics.take_contents(contents)
        found = {number: messages.entries for number, messages in contents.messages.items()}
        listed = {index.channel: index.entries for index in stored.indexes if index.entries.size}
        if not stored.cut and (
            listed.keys() != found.keys()
            or any(not np.array_equal(np.sort(listed[n]), np.sort(found[n])) for n in found)
        ):
            self.complaints.append("the index of a chunk does not fit its messages")
        times = [entries["log_time"] for entries in found.values()]
        if times:
            reach = min(t.min() for t in times), max(t.max() for t in times)
            if reach != (stored.chunk.message_start_time, stored.chunk.message_end_time):
                self.complaints.append("a chunk has other times than it claims")
        for number in found:
            self._look_at_messages(number, contents, before.get(number, 0))

    def _look_at_messages(self, number: int, contents: Contents, before: int) -> None:
        record, messages = self.statistics.channels[number], contents.messages[number]
        time_ns = messages.prefix["log_time"]
        if number not in self._disordered and (
            int(time_ns[0]) < before or np.any(time_ns[1:] < time_ns[:-1])
        ):
            self._disordered.add(number)
            self.complaints.append(f"{record.topic}: time runs backwards")
        channel = sample_channel(record, self.statistics.schemas.get(record.schema_id))
        if channel is not None:
            channel.decode(messages.data())

    def messages_outside_chunks(self) -> list[str]:
        """A complaint, if there are some: no index finds them."""
        if not self._outside:
            return []
        return [f"messages outside chunks: {len(self._outside)}, from byte {self._outside[0]} on"]

    def compare_with_summary(self) -> None:
        """Check that the summary tells of what is there."""
        summary = read_summary(self._file)
        if not summary:
            self.complaints.append("there is no summary, or it is damaged")
        starts = [r.chunk_start_offset for r in summary if isinstance(r, records.ChunkIndex)]
        if starts and starts != self._starts:
            self.complaints.append("the summary lists other chunks than there are")
        for record in summary:
            if isinstance(record, records.Statistics):
                counts = {k: n for k, n in record.channel_message_counts.items() if n}
                if counts != dict(self.statistics.counts):
                    self.complaints.append("the statistics count other messages than there are")

    def _check_sum(self, end: int) -> int:
        """Of the file up to byte `end`; leaves the file where it stands."""
        here = self._file.tell()
        self._file.seek(0)
        crc = 0
        for start in range(0, end, _BLOCK):
            crc = zlib.crc32(self._file.read(min(_BLOCK, end - start)), crc)
        self._file.seek(here)
        return crc
