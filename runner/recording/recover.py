"""A sound recording from a damaged one: `slipmode recover`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import EVENTS, NANOSECONDS, Event, encode_event
from slipmode.runner.recording.inventory import Inventory, is_ours, opened
from slipmode.runner.recording.mcap_file.reader import unpack
from slipmode.runner.recording.mcap_file.records import Loose
from slipmode.runner.recording.mcap_file.walk import Part
from slipmode.runner.recording.mcap_file.writer import OWN_HEADER, McapWriter, chunk_records

_UNKNOWN_HEADER = records.Header("", "recovered by slipmode")
_MESSAGE_BYTES = 64  # of a lost message, where no other is known


@dataclass(frozen=True)
class Recovery:
    """Messages that `recover` kept and lost.

    Attributes
    ----------
    kept, lost : int
        Numbers of messages.
    exact : bool
        Whether `lost` was counted; else it is estimated from the size of lost chunks.
    end : float
        Simulation time of the last message that was kept [s].
    lost_seconds : float
        Simulation time that the lost chunks covered [s].
    duration : float, optional
        Duration of the scene [s], if the recording has its scene.
    unread : int
        Bytes of the file that could not be read.
    """

    kept: int
    lost: int
    exact: bool
    end: float
    lost_seconds: float
    duration: float | None
    unread: int = 0

    def text(self) -> str:
        """Return lines for a reader."""
        lines = [f"kept: {self.kept} messages, up to t = {self.end:g} s"]
        about = "" if self.exact else "about "
        lost = "nothing of what had reached the file"
        if self.lost:
            lost = f"{about}{self.lost} messages, {self.lost_seconds:g} s"
        elif self.unread:
            lost = f"{self.unread} bytes that cannot be read"
        lines.append(f"lost: {lost}")
        if self.duration is not None and self.duration > self.end:
            missing = f"its last {self.duration - self.end:g} s are missing"
            lines.append(f"the scene lasts {self.duration:g} s: {missing}")
        return "\n".join(lines)


def recover(path: str | PathLike[str], output: str | PathLike[str]) -> Recovery:
    """Write the whole parts of an MCAP file as a sound recording.

    Chunks whose check sum is right are copied; messages outside chunks are packed into chunks. An
    event says what was lost. Raises SlipmodeError if `path` is no such file, or holds nothing that
    could be kept, or is `output`; OSError if `output` cannot be written.

    Parameters
    ----------
    path : path
        The damaged recording.
    output : path
        The file to write.
    """
    source, target = Path(path), Path(output)
    if target.is_dir():
        raise SlipmodeError(f"{target}: is a directory; give the name of a file to write")
    if target.exists() and source.exists() and target.samefile(source):
        raise SlipmodeError(f"{target}: is the file to recover from; give another name")
    with opened(source) as inventory, replacing(target) as out:
        return _salvage(inventory, out)


def _salvage(inventory: Inventory, out: BinaryIO) -> Recovery:
    """Copy the whole parts of a file, and count the others."""
    writer: McapWriter | None = None
    written, kept_bytes = set[tuple[type, int]](), 0  # schemas and channels; bytes of chunks
    for part in inventory.read(beyond_damage=True):
        record = part.record
        if writer is None:
            header = record if isinstance(record, records.Header) else _UNKNOWN_HEADER
            marked = inventory.ours and not is_ours(header)
            writer = McapWriter(out, OWN_HEADER if marked else header)
        for each in inventory.described():  # also those within chunks: readers need them outside
            if (type(each), each.id) not in written:
                writer.add(each)
                written.add((type(each), each.id))
        if part.messages:
            writer.add_chunk(_sound(part))
            kept_bytes += len(part.raw)
        elif isinstance(record, records.Metadata | records.Attachment):
            writer.add(record)
    if writer is None or not inventory.channels:
        raise SlipmodeError("ends before its first channel; nothing can be recovered")
    found = _count(inventory, kept_bytes)
    described = (each for each in inventory.described() if isinstance(each, records.Channel))
    events = [each.id for each in described if each.topic == EVENTS]
    if inventory.ours and inventory.lost and events:
        time_ns = np.array([inventory.span[1]])
        words = "recovered from a damaged recording; " + found.text().replace("\n", "; ")
        event = encode_event(Event(found.end, "warning", words), int(time_ns[0]))
        writer.add_messages(events[0], time_ns, np.array([event], np.void))
    writer.finish()
    return found


def _sound(part: Part) -> list[records.McapRecord]:
    """Return a chunk of the messages that are kept, with its index."""
    raw, messages, chunk, packed = part.raw, part.messages, part.record, None
    if not part.whole:
        spans = [zip(m.offsets.tolist(), m.ends.tolist(), strict=True) for m in messages.values()]
        raw = b"".join(raw[start:end] for start, end in sorted(chain(*spans)))
        messages = unpack(Loose(raw), len(raw))[2]
    elif isinstance(chunk, records.Chunk) and not isinstance(chunk, Loose):
        packed = chunk
    return chunk_records(raw, {k: each.entries for k, each in messages.items()}, packed)


def _count(inventory: Inventory, kept_bytes: int) -> Recovery:
    """Count what is kept, and what is lost by the statistics of the file or else by its size."""
    kept, lost = inventory.counts.total(), inventory.lost
    lost_bytes = sum(each.size for each in lost)
    exact = inventory.expected is not None or not lost_bytes
    count = round(lost_bytes * kept / kept_bytes if kept else lost_bytes / _MESSAGE_BYTES)
    if inventory.expected is not None:
        count = max(inventory.expected - kept, 0)
    return Recovery(
        kept,
        count,
        exact,
        end=inventory.span[1] / NANOSECONDS,
        lost_seconds=sum(max(0, each.last_ns - each.first_ns) for each in lost) / NANOSECONDS,
        duration=_duration(inventory),
        unread=sum(each.end - each.start for each in lost),
    )


def _duration(inventory: Inventory) -> float | None:
    """Return the duration of the scene [s]; None if the recording has no scene."""
    try:
        return float(tomllib.loads(inventory.header().scene_text)["run"]["duration"])
    except (ValueError, KeyError, TypeError):
        return None
