"""A sound recording from a damaged one: `slipmode recover`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import EVENTS, NANOSECONDS, Event, encode_event
from slipmode.runner.recording.contents.chunks import unpack
from slipmode.runner.recording.contents.inventory import Inventory, Part, is_ours
from slipmode.runner.recording.contents.walk import Loose, opened
from slipmode.runner.recording.mcap_writer import OWN_HEADER, McapWriter, packed_chunk
from slipmode.runner.recording.record import SCENE_FILE

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
    with opened(source) as file, replacing(target) as out:
        return _salvage(file, out)


def _salvage(file: BinaryIO, out: BinaryIO) -> Recovery:
    """Copy the whole parts of a file, and count the others."""
    inventory, kept_bytes = Inventory(), 0
    writer: McapWriter | None = None
    written: set[tuple[type, int]] = set()  # schemas and channels
    for part in inventory.read(file, beyond_damage=True):
        record = part.found.record
        if writer is None:
            header = record if isinstance(record, records.Header) else _UNKNOWN_HEADER
            marked = inventory.ours and not is_ours(header)
            writer = McapWriter(out, OWN_HEADER if marked else header)
        _describe(inventory, writer, written)
        if part.messages or (isinstance(record, records.Chunk) and part.whole):
            writer.add_chunk(*_copied(part))
            kept_bytes += len(part.raw)
        elif isinstance(record, records.Metadata | records.Attachment):
            writer.add(record)
    if writer is None or not inventory.channels:
        raise SlipmodeError("ends before its first channel; nothing can be recovered")
    _describe(inventory, writer, written)
    kept = inventory.counts.total()
    lost_bytes = sum(each.size for each in inventory.lost)
    count = round(lost_bytes * kept / kept_bytes if kept else lost_bytes / _MESSAGE_BYTES)
    exact = inventory.expected is not None or not lost_bytes
    if inventory.expected is not None:
        count = max(inventory.expected - kept, 0)
    end = max(inventory.last.values(), default=0) / NANOSECONDS
    lost_seconds = sum(max(0, each.last_ns - each.first_ns) for each in inventory.lost)
    found = Recovery(
        kept,
        count,
        exact,
        end,
        lost_seconds / NANOSECONDS,
        _duration(inventory),
        sum(each.end - each.start for each in inventory.lost),
    )
    events = [each.id for each in inventory.channels.values() if each.topic == EVENTS]
    if inventory.ours and inventory.lost and events:
        time_ns = np.array([round(end * NANOSECONDS)])
        words = "recovered from a damaged recording; " + found.text().replace("\n", "; ")
        event = encode_event(Event(end, "warning", words), int(time_ns[0]))
        writer.add_messages(events[0], time_ns, np.array([event], np.void))
    writer.finish()
    return found


def _describe(inventory: Inventory, writer: McapWriter, written: set[tuple[type, int]]) -> None:
    """Write new schemas and channels, also those within chunks: readers need them outside."""
    for each in inventory.described():
        if (type(each), each.id) not in written:
            writer.add(each)
            written.add((type(each), each.id))


def _copied(part: Part) -> tuple[records.Chunk, dict[int, NDArray[np.void]]]:
    """Return a chunk of the messages of a part, with their index entries by channel."""
    chunk, raw, messages = part.found.record, part.raw, part.messages
    if not part.whole:
        spans = [zip(m.offsets.tolist(), m.ends.tolist(), strict=True) for m in messages.values()]
        raw = b"".join(raw[start:end] for start, end in sorted(chain(*spans)))
        messages = unpack(Loose(raw), len(raw))[2]
    entries = {number: each.entries for number, each in messages.items()}
    if not isinstance(chunk, records.Chunk) or not part.whole:
        return packed_chunk(raw, entries), entries
    times = [each["log_time"] for each in entries.values()]
    first, last = (int(f(np.concatenate(times))) if times else 0 for f in (np.min, np.max))
    sound = replace(
        chunk, message_start_time=first, message_end_time=last, uncompressed_size=len(raw)
    )
    return sound, entries


def _duration(inventory: Inventory) -> float | None:
    """Return the duration of the scene [s]; None if the recording has no scene."""
    try:
        scene = tomllib.loads(inventory.attachments.get(SCENE_FILE, b"").decode())
        return float(scene["run"]["duration"])
    except (ValueError, KeyError, TypeError):
        return None
