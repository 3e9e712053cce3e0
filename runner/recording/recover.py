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
from slipmode.runner.recording.channels import EVENTS, NANOSECONDS, Event, encode_event
from slipmode.runner.recording.mcap_reader import (
    DamagedError,
    Inventory,
    Record,
    opened,
    read_summary,
    scan,
)
from slipmode.runner.recording.mcap_writer import McapWriter
from slipmode.runner.recording.record import SCENE_FILE

_CHUNK_HEAD = struct.Struct("<BQQQQ")  # opcode, length, first and last time, size uncompressed


@dataclass(frozen=True)
class Recovery:
    """Messages that `recover` kept and lost."""

    kept: int
    lost: int
    exact: bool  # Whether `lost` was counted; else it is estimated from the size of lost chunks
    end: float  # Simulation time of the last message that was kept [s]
    lost_seconds: float  # Simulation time that the lost chunks covered [s]
    duration: float | None  # Duration of the scene [s], if the recording has its scene

    def text(self) -> str:
        """Return lines for a reader."""
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
    """Write the whole chunks of an MCAP file as a sound recording.

    Chunks whose check sum is right are copied; an event says what was lost. Raises SlipmodeError
    if `path` is no such file, or holds nothing that could be kept, or is `output`; OSError if
    `output` cannot be written.
    """
    source, target = Path(path), Path(output)
    if target.is_dir():
        raise SlipmodeError(f"{target} is a directory: give the name of a file to write")
    if target.exists() and source.exists() and target.samefile(source):
        raise SlipmodeError(f"{target} is the file to recover from: give another name")
    with opened(source) as file, replacing(target) as out:
        return _Salvage(file, McapWriter(out)).recover()


class _Salvage:
    """Copies what is whole of a file, and counts what is not."""

    def __init__(self, file: BinaryIO, writer: McapWriter) -> None:
        self._file = file
        self._writer = writer
        self._inventory = Inventory()
        self._whole = True
        self._kept_bytes = 0  # before compression, as all sizes
        self._lost_bytes = 0
        self._lost_ns = 0

    def recover(self) -> Recovery:
        """Copy everything that is whole."""
        for record in self._records():
            self._copy(record)
        inventory = self._inventory
        if not inventory.channels:
            raise SlipmodeError("cut before its first channel: nothing can be recovered")
        kept = inventory.counts.total()
        mean = self._kept_bytes / kept if kept else 64  # bytes of a message; 64 is a guess
        lost, exact = round(self._lost_bytes / mean), not self._lost_bytes
        for record in read_summary(self._file):
            if isinstance(record, records.Statistics):
                lost, exact = record.message_count - kept, True
        found = Recovery(
            kept=kept,
            lost=lost,
            exact=exact,
            end=max(inventory.last.values(), default=0) / NANOSECONDS,
            lost_seconds=self._lost_ns / NANOSECONDS,
            duration=_duration(inventory),
        )
        if not self._whole:
            self._add_event(found)
        self._writer.finish()
        return found

    def _records(self) -> Iterator[Record]:
        """Yield the records in their order; after damage, the chunks that a summary lists."""
        end = self._file.tell()
        try:
            for _, record_end, record in scan(self._file):
                end = record_end
                yield record
            return
        except DamagedError:
            self._whole = False
        self._file.seek(end)
        head = self._file.read(_CHUNK_HEAD.size)
        if len(head) == _CHUNK_HEAD.size and head[0] == Opcode.CHUNK:
            self._lose(*_CHUNK_HEAD.unpack(head)[2:])
        for index in read_summary(self._file):
            if isinstance(index, records.ChunkIndex) and index.chunk_start_offset > end:
                self._file.seek(index.chunk_start_offset)
                with suppress(DamagedError):
                    yield next(scan(self._file))[2]

    def _copy(self, record: Record) -> None:
        inventory = self._inventory
        match record:
            case records.Chunk() as chunk:
                self._copy_chunk(chunk)
                return
            case records.Message():
                raise SlipmodeError("messages outside chunks are not recovered here")
            case records.Metadata() | records.Attachment():
                self._writer.add(record)
            case records.Schema() if record.id not in inventory.schemas:
                self._writer.add(record)
            case records.Channel() if record.id not in inventory.channels:
                self._writer.add(record)
        inventory.add(record)

    def _copy_chunk(self, chunk: records.Chunk) -> None:
        inventory = self._inventory
        known = [*inventory.schemas.values(), *inventory.channels.values()]
        try:
            messages = inventory.add(chunk)
        except DamagedError:
            self._whole = False
            self._lose(chunk.message_start_time, chunk.message_end_time, chunk.uncompressed_size)
            return
        for record in (*inventory.schemas.values(), *inventory.channels.values()):
            if record not in known:  # readers look for them in the summary, which the writer makes
                self._writer.add(record)
        self._writer.add_chunk(chunk, {number: m.entries for number, m in messages.items()})
        self._kept_bytes += chunk.uncompressed_size

    def _lose(self, first: int, last: int, size: int) -> None:
        """Count a chunk as lost: its first and last time [ns], its size before compression."""
        self._lost_ns += max(0, last - first)
        self._lost_bytes += size

    def _add_event(self, found: Recovery) -> None:
        for channel in self._inventory.channels.values():
            if channel.topic == EVENTS:
                time_ns = np.array([round(found.end * NANOSECONDS)])
                words = "recovered from a damaged recording; " + found.text().replace("\n", "; ")
                event = encode_event(Event(found.end, "warning", words), int(time_ns[0]))
                self._writer.add_messages(channel.id, time_ns, np.array([event], np.void))


def _duration(inventory: Inventory) -> float | None:
    """Return the duration of the scene [s]; None if the recording has no scene."""
    try:
        scene = tomllib.loads(inventory.attachments.get(SCENE_FILE, b"").decode())
        return float(scene["run"]["duration"])
    except (ValueError, KeyError, TypeError):
        return None
