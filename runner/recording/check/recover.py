"""A sound recording from a damaged one: `slipmode recover`."""

from __future__ import annotations

import struct
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records
from mcap.opcode import Opcode

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.files import replacing
from slipmode.runner.recording.channels import EVENTS, Event, encode_event
from slipmode.runner.recording.mcapfile.chunk import unpack
from slipmode.runner.recording.mcapfile.layout import RECORD_HEADER
from slipmode.runner.recording.mcapfile.scan import DamagedError, Piece, StoredChunk, scan
from slipmode.runner.recording.mcapfile.source import opened
from slipmode.runner.recording.mcapfile.statistics import Statistics
from slipmode.runner.recording.mcapfile.summary import read_summary
from slipmode.runner.recording.mcapfile.writer import McapWriter
from slipmode.runner.recording.record import SCENE_FILE

_NANOSECONDS = 1e9
_CHUNK_HEAD = struct.Struct("<QQQ")  # first, last, and size before compression
_MESSAGE_BYTES = 64  # where no message is left to tell


@dataclass(frozen=True)
class Recovery:
    """What `recover` kept and what it had to leave.

    Attributes
    ----------
    kept, lost : int
        Messages.
    exact : bool
        Whether `lost` was counted; otherwise it is told from the size of what was cut.
    end : float
        Simulation time of the last message that was kept [s].
    lost_seconds : float
        Simulation time that the lost chunks covered [s].
    duration : float or None
        How long the scene was to last [s], where the recording says so.
    """

    kept: int
    lost: int
    exact: bool
    end: float
    lost_seconds: float
    duration: float | None

    def text(self) -> str:
        """Lines for a reader."""
        lines = [f"kept: {self.kept} messages, up to t = {self.end:g} s"]
        about = "" if self.exact else "about "
        lines.append(
            f"lost: {about}{self.lost} messages, {self.lost_seconds:g} s"
            if self.lost
            else "lost: nothing of what had reached the file"
        )
        if self.duration is not None and self.duration > self.end:
            missing = self.duration - self.end
            lines.append(
                f"the scene lasts {self.duration:g} s: its last {missing:g} s are missing"
            )
        return "\n".join(lines)


def recover(path: str | PathLike[str], output: str | PathLike[str]) -> Recovery:
    """Write what is whole of a recording as a sound one.

    Chunks whose check sum is right are kept as they are; an event says what was lost.

    Parameters
    ----------
    path : path
        An MCAP file, which is only read.
    output : path
        File to write.

    Raises
    ------
    SlipmodeError
        If `path` is no such file, or holds nothing that could be kept, or is `output`.
    OSError
        If `output` cannot be written.
    """
    source, target = Path(path), Path(output)
    if target.is_dir():
        raise SlipmodeError(f"{target} is a directory: give the name of a file to write")
    if target.exists() and source.exists() and target.samefile(source):
        raise SlipmodeError(f"{target} is the file to recover from: give another name")
    with opened(source) as file, replacing(target) as out:
        return _Salvage(file, McapWriter(out)).recover()


class _Salvage:
    """What is whole of a file is copied; what is not is counted."""

    def __init__(self, file: BinaryIO, writer: McapWriter) -> None:
        self._file = file
        self._writer = writer
        self._statistics = Statistics()
        self._kept_bytes = 0  # before compression
        self._whole = True  # as far as the file is known
        self._lost = 0
        self._exact = True
        self._lost_ns = 0

    def recover(self) -> Recovery:
        """Copy all that is whole."""
        for piece in self._pieces():
            self._copy(piece.record)
        statistics = self._statistics
        if not statistics.channels:
            raise SlipmodeError("cut before its first channel: nothing can be recovered")
        kept = statistics.counts.total()
        for record in read_summary(self._file):
            if isinstance(record, records.Statistics):
                self._lost, self._exact = record.message_count - kept, True
        found = Recovery(
            kept=kept,
            lost=self._lost,
            exact=self._exact,
            end=max(statistics.last.values(), default=0) / _NANOSECONDS,
            lost_seconds=self._lost_ns / _NANOSECONDS,
            duration=_duration(statistics),
        )
        if not self._whole:
            self._add_event(found)
        self._writer.finish()
        return found

    def _pieces(self) -> Iterator[Piece]:
        """Pieces in their order; beyond damage, the chunks that a summary tells of."""
        end = self._file.tell()
        try:
            for piece in scan(self._file):
                end = piece.end
                yield piece
            return
        except DamagedError:
            self._whole = False
        self._lose_cut_chunk(end)
        for record in read_summary(self._file):
            if isinstance(record, records.ChunkIndex) and record.chunk_start_offset > end:
                self._file.seek(record.chunk_start_offset)
                with suppress(DamagedError):
                    yield next(scan(self._file))

    def _copy(self, record: object) -> None:
        match record:
            case StoredChunk():
                self._copy_chunk(record)
            case records.Message():
                raise SlipmodeError("messages outside chunks are not recovered here")
            case records.Metadata():
                self._writer.add_metadata(record.name, record.metadata)
            case records.Attachment():
                self._writer.add_attachment(record)
            case records.Schema() if record.id not in self._statistics.schemas:
                self._writer.add_schema(record)
            case records.Channel() if record.id not in self._statistics.channels:
                self._writer.add_channel(record)
        self._statistics.take(record)

    def _copy_chunk(self, stored: StoredChunk) -> None:
        try:
            contents = unpack(stored)
            for record in (*contents.schemas, *contents.channels):
                self._copy(record)
            self._statistics.take_contents(contents)
        except DamagedError:
            self._whole = False
            chunk = stored.chunk
            self._lose(chunk.message_start_time, chunk.message_end_time)
            self._lost += self._count(stored)
            return
        entries = {number: found.entries for number, found in contents.messages.items()}
        self._writer.add_chunk(stored.chunk, entries)
        self._kept_bytes += stored.chunk.uncompressed_size

    def _lose_cut_chunk(self, offset: int) -> None:
        """Count what a chunk held that begins at `offset` and is not whole."""
        self._file.seek(offset)
        head = self._file.read(RECORD_HEADER.size + _CHUNK_HEAD.size)
        if len(head) == RECORD_HEADER.size + _CHUNK_HEAD.size and head[0] == Opcode.CHUNK:
            first, last, size = _CHUNK_HEAD.unpack_from(head, RECORD_HEADER.size)
            self._lose(first, last)
            self._lost += self._guess(size)

    def _lose(self, first: int, last: int) -> None:
        self._lost_ns += max(0, last - first)

    def _count(self, stored: StoredChunk) -> int:
        """How many messages a chunk held that cannot be unpacked."""
        counted = stored.indexes and not stored.cut
        return stored.count if counted else self._guess(stored.chunk.uncompressed_size)

    def _guess(self, size: int) -> int:
        """How many messages took `size` bytes before compression."""
        self._exact = False
        kept = self._statistics.counts.total()
        return round(size / (self._kept_bytes / kept if kept else _MESSAGE_BYTES))

    def _add_event(self, found: Recovery) -> None:
        for channel in self._statistics.channels.values():
            if channel.topic == EVENTS:
                time_ns = np.array([round(found.end * _NANOSECONDS)])
                words = "recovered from a damaged recording; " + found.text().replace("\n", "; ")
                event = encode_event(Event(found.end, "warning", words), int(time_ns[0]))
                self._writer.add_messages(channel.id, time_ns, np.array([event], np.void))


def _duration(statistics: Statistics) -> float | None:
    """How long the scene was to last [s], None if that is not known."""
    try:
        scene = tomllib.loads(statistics.attachments.get(SCENE_FILE, b"").decode())
        return float(scene["run"]["duration"])
    except (ValueError, KeyError, TypeError):
        return None
