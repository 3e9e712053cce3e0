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

_Lost = tuple[int, int, int]  # first and last time [ns] of a chunk, bytes before compression


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
        lost = f"{about}{self.lost} messages, {self.lost_seconds:g} s"
        lines.append(f"lost: {lost if self.lost else 'nothing of what had reached the file'}")
        if self.duration is not None and self.duration > self.end:
            missing = f"its last {self.duration - self.end:g} s are missing"
            lines.append(f"the scene lasts {self.duration:g} s: {missing}")
        return "\n".join(lines)


def recover(path: str | PathLike[str], output: str | PathLike[str]) -> Recovery:
    """Write the whole chunks of an MCAP file as a sound recording.

    Chunks whose check sum is right are copied; an event says what was lost. Raises SlipmodeError
    if `path` is no such file, or holds nothing that could be kept, or is `output`; OSError if
    `output` cannot be written.
    """
    source, target = Path(path), Path(output)
    if target.is_dir():
        raise SlipmodeError(f"{target}: is a directory; give the name of a file to write")
    if target.exists() and source.exists() and target.samefile(source):
        raise SlipmodeError(f"{target}: is the file to recover from; give another name")
    with opened(source) as file, replacing(target) as out:
        return _salvage(file, McapWriter(out))


def _salvage(file: BinaryIO, writer: McapWriter) -> Recovery:
    """Copy the whole records of a file, and count the others."""
    inventory, kept_bytes = Inventory(), 0
    lost: list[_Lost] = []
    known: list[Record] = []  # schemas and channels that are written
    for record in _records(file, lost):
        if isinstance(record, records.Message):
            raise SlipmodeError("has messages outside chunks, which cannot be recovered")
        try:
            messages = inventory.add(record)
        except DamagedError:
            assert isinstance(record, records.Chunk)  # others hold no messages
            times = record.message_start_time, record.message_end_time
            lost.append((*times, record.uncompressed_size))
            continue
        # also those within chunks, as readers look for them in the summary
        for each in (*inventory.schemas.values(), *inventory.channels.values()):
            if each not in known:
                writer.add(each)
                known.append(each)
        match record:
            case records.Chunk():
                writer.add_chunk(record, {number: m.entries for number, m in messages.items()})
                kept_bytes += record.uncompressed_size
            case records.Metadata() | records.Attachment():
                writer.add(record)
    if not inventory.channels:
        raise SlipmodeError("ends before its first channel; nothing can be recovered")
    kept, lost_bytes = inventory.counts.total(), sum(size for *_, size in lost)
    mean = kept_bytes / kept if kept else 64  # bytes of a message; 64 is a guess
    count, exact = round(lost_bytes / mean), not lost_bytes
    for record in read_summary(file):
        if isinstance(record, records.Statistics):
            count, exact = record.message_count - kept, True
    end = max(inventory.last.values(), default=0) / NANOSECONDS
    lost_seconds = sum(max(0, last - first) for first, last, _ in lost) / NANOSECONDS
    found = Recovery(kept, count, exact, end, lost_seconds, _duration(inventory))
    events = [each.id for each in inventory.channels.values() if each.topic == EVENTS]
    if lost and events:
        time_ns = np.array([round(end * NANOSECONDS)])
        words = "recovered from a damaged recording; " + found.text().replace("\n", "; ")
        event = encode_event(Event(end, "warning", words), int(time_ns[0]))
        writer.add_messages(events[0], time_ns, np.array([event], np.void))
    writer.finish()
    return found


def _records(file: BinaryIO, lost: list[_Lost]) -> Iterator[Record]:
    """Yield the records in their order; after damage, the chunks that a summary lists."""
    end = file.tell()
    try:
        for _, record_end, record in scan(file):
            end = record_end
            yield record
        return
    except DamagedError:
        file.seek(end)
    chunk_head = struct.Struct("<BQQQQ")  # opcode, length, first and last time, size uncompressed
    head = file.read(chunk_head.size)
    is_chunk = len(head) == chunk_head.size and head[0] == Opcode.CHUNK
    lost.append(chunk_head.unpack(head)[2:] if is_chunk else (0, 0, 0))
    for index in read_summary(file):
        if isinstance(index, records.ChunkIndex) and index.chunk_start_offset > end:
            file.seek(index.chunk_start_offset)
            with suppress(DamagedError):
                yield next(scan(file))[2]


def _duration(inventory: Inventory) -> float | None:
    """Return the duration of the scene [s]; None if the recording has no scene."""
    try:
        scene = tomllib.loads(inventory.attachments.get(SCENE_FILE, b"").decode())
        return float(scene["run"]["duration"])
    except (ValueError, KeyError, TypeError):
        return None
