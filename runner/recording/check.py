"""What a recording holds, `slipmode info`, and whether it is sound, `slipmode doctor`."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.channels import NANOSECONDS
from slipmode.runner.recording.load import sample_channel
from slipmode.runner.recording.mcap_reader import (
    DamagedError,
    Inventory,
    MessageIndex,
    opened,
    read_summary,
    scan,
)


@dataclass(frozen=True)
class ChannelInfo:
    """One channel of a recording."""

    topic: str
    message_type: str
    units: dict[str, str]  # Of each field; empty for a channel without samples of slipmode
    count: int  # Messages


@dataclass(frozen=True)
class Info:
    """Contents of a recording."""

    title: str  # Title and scene_name are empty for a file of another program
    scene_name: str
    run: Mapping[str, str]  # Hashes, versions and wall clock of the run
    channels: list[ChannelInfo]
    span: tuple[float, float]  # First and last simulation time [s]; 0 without messages
    chunks: int
    size: int  # Bytes of the file
    damage: str  # Why the file cannot be read to its end

    __repr__ = short_repr

    def text(self) -> str:
        """Return lines for a reader."""
        start, end = self.span
        name = f"  ({self.scene_name})" if self.scene_name else ""
        lines = [f"{self.title or 'not a recording of slipmode'}{name}"]
        size = f"chunks: {self.chunks}; {self.size / 1024:.0f} KiB"
        count = f"{sum(channel.count for channel in self.channels)} messages"
        lines.append(f"  {end - start:g} s, t = {start:g} to {end:g} s; {count}; {size}")
        if self.damage:
            lines.append(f"  damaged: {self.damage}: see slipmode recover")
        width = max((len(channel.topic) for channel in self.channels), default=0)
        for channel in self.channels:
            fields = ", ".join(f"{name} [{unit}]" for name, unit in channel.units.items())
            kind = fields or channel.message_type
            lines.append(f"  {channel.topic:{width}} {channel.count:9}  {kind}")
        return "\n".join(lines + [f"  {key:15} {value}" for key, value in self.run.items()])


def info(path: str | PathLike[str]) -> Info:
    """Return the contents of an MCAP file; of a damaged one, up to the damage.

    Raises SlipmodeError if there is no such file, or it is not MCAP.
    """
    inventory = Inventory()
    with opened(path) as file:
        inventory.read(file, lambda number, messages: None)
    scene = inventory.metadata.get("scene", {})
    first, last = min(inventory.first.values(), default=0), max(inventory.last.values(), default=0)
    return Info(
        title=scene.get("title", ""),
        scene_name=scene.get("name", ""),
        run=inventory.metadata.get("run", {}),
        channels=[_describe(inventory, number) for number in inventory.channels],
        span=(first / NANOSECONDS, last / NANOSECONDS),
        chunks=inventory.chunks,
        size=Path(path).stat().st_size,
        damage=inventory.damage,
    )


def _describe(inventory: Inventory, number: int) -> ChannelInfo:
    units = {}
    with suppress(SlipmodeError):  # another program's channel has no fields of samples
        if channel := sample_channel(inventory, number):
            units = channel.units
    topic, kind = inventory.channels[number].topic, inventory.schema_of(number).name
    return ChannelInfo(topic, kind, units, inventory.counts[number])


def doctor(path: str | PathLike[str]) -> list[str]:
    """Check the structure of an MCAP file, its check sums, its index and its times.

    Returns a line for each fault. Raises SlipmodeError if there is no such file, or it is not
    MCAP.
    """
    with opened(path) as file:
        return list(_faults(file))


def _faults(file: BinaryIO) -> Iterator[str]:
    inventory = Inventory()
    chunks: list[int] = []  # their first bytes
    outside: list[int] = []  # first bytes of messages outside chunks
    disordered: set[int] = set()  # channels whose times are known to run backwards
    # entries that the indexes of the last chunk must have, and entries that they have
    expected: dict[int, bytes] | None = None
    indexed: dict[int, bytes] = {}
    try:
        for start, _, record in scan(file):
            if isinstance(record, MessageIndex):
                if record.entries.size:
                    indexed[record.channel] = np.sort(record.entries).tobytes()
                continue
            if expected not in (None, indexed):
                yield "the index of a chunk does not fit its messages"
            expected, indexed = None, {}
            match record:
                case records.Chunk():
                    chunks.append(start)
                    before = dict(inventory.last)
                    try:
                        messages = inventory.add(record)
                        expected = {k: np.sort(m.entries).tobytes() for k, m in messages.items()}
                        times = [each.prefix["log_time"] for each in messages.values()]
                        span = record.message_start_time, record.message_end_time
                        if times and span != (min(map(np.min, times)), max(map(np.max, times))):
                            yield "a chunk has other times than it claims"
                        for number, each in messages.items():
                            if number not in disordered and each.disordered(before.get(number, 0)):
                                disordered.add(number)
                                yield f"{inventory.channels[number].topic}: time runs backwards"
                            channel = sample_channel(inventory, number)
                            if channel is not None:
                                channel.decode(each.data())
                    except (DamagedError, SlipmodeError) as error:
                        yield f"chunk at byte {start}: {error}"
                case records.DataEnd(data_section_crc=crc) if crc:
                    if crc != _check_sum(file, start):
                        yield "the check sum of the data section does not fit it"
                case other:
                    if isinstance(other, records.Message):
                        outside.append(start)
                    inventory.add(other)
        yield from _summary_faults(file, chunks, inventory)
    except DamagedError as error:
        yield str(error)
    if outside:
        yield f"messages outside chunks: {len(outside)}, from byte {outside[0]} on"
    if mixed := inventory.mixed_clocks():
        yield mixed


def _summary_faults(file: BinaryIO, chunks: list[int], inventory: Inventory) -> Iterator[str]:
    """Check that the summary describes the chunks and messages of the file."""
    summary = read_summary(file)
    if not summary:
        yield "there is no summary, or it is damaged"
    starts = [r.chunk_start_offset for r in summary if isinstance(r, records.ChunkIndex)]
    if starts and starts != chunks:
        yield "the summary lists other chunks than there are"
    for record in summary:
        if isinstance(record, records.Statistics):
            counts = {k: n for k, n in record.channel_message_counts.items() if n}
            if counts != dict(inventory.counts):
                yield "the statistics count other messages than there are"


def _check_sum(file: BinaryIO, end: int) -> int:
    """Return the check sum of a file up to byte `end`; leave the file's position."""
    here, crc, block = file.tell(), 0, 1024 * 1024
    file.seek(0)
    for start in range(0, end, block):
        crc = zlib.crc32(file.read(min(block, end - start)), crc)
    file.seek(here)
    return crc
