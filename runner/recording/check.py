"""What a recording holds, `slipmode info`, and whether it is sound, `slipmode doctor`."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.channels import NANOSECONDS
from slipmode.runner.recording.load import sample_channel
from slipmode.runner.recording.mcap_reader import (
    DamagedError,
    Inventory,
    MessageIndex,
    Messages,
    Record,
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
        count = sum(channel.count for channel in self.channels)
        name = f"  ({self.scene_name})" if self.scene_name else ""
        lines = [
            f"{self.title or 'no slipmode recording'}{name}",
            f"  {end - start:g} s, t = {start:g} to {end:g} s; {count} messages; "
            f"chunks: {self.chunks}; {self.size / 1024:.0f} KiB",
        ]
        if self.damage:
            lines.append(f"  damaged: {self.damage}: see slipmode recover")
        width = max((len(channel.topic) for channel in self.channels), default=0)
        for channel in self.channels:
            fields = ", ".join(f"{name} [{unit}]" for name, unit in channel.units.items())
            lines.append(
                f"  {channel.topic:{width}} {channel.count:9}  {fields or channel.message_type}"
            )
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
    record = inventory.channels[number]
    schema = inventory.schemas.get(record.schema_id)
    units = {}
    with suppress(SlipmodeError):  # another program's channel has no fields of samples
        if channel := sample_channel(inventory, number):
            units = channel.units
    return ChannelInfo(
        topic=record.topic,
        message_type="" if schema is None else schema.name,
        units=units,
        count=inventory.counts[number],
    )


def doctor(path: str | PathLike[str]) -> list[str]:
    """Check the structure of an MCAP file, its check sums, its index and its times.

    Returns a line for each fault. Raises SlipmodeError if there is no such file, or it is not
    MCAP.
    """
    with opened(path) as file:
        examination = _Examination(file)
        try:
            for start, _, record in scan(file):
                examination.check(start, record)
            examination.compare_with_summary()
        except DamagedError as error:
            examination.complaints.append(str(error))
    complaints, outside = examination.complaints, examination.outside
    if outside:
        complaints.append(f"messages outside chunks: {len(outside)}, from byte {outside[0]} on")
    mixed = examination.inventory.mixed_clocks()
    return [*complaints, mixed] if mixed else complaints


class _Examination:
    """Complaints about a file, collected record by record."""

    def __init__(self, file: BinaryIO) -> None:
        self.complaints: list[str] = []
        self.inventory = Inventory()
        self.outside: list[int] = []  # first bytes of messages that no chunk holds
        self._file = file
        self._chunks: list[int] = []  # their first bytes
        self._disordered: set[int] = set()
        # entries that the indexes of the last chunk must have, and entries that they have
        self._expected: dict[int, NDArray[np.void]] | None = None
        self._indexed: dict[int, NDArray[np.void]] = {}

    def check(self, start: int, record: Record) -> None:
        """Check a record that begins at byte `start`."""
        if isinstance(record, MessageIndex):
            if record.entries.size:
                self._indexed[record.channel] = np.sort(record.entries)
            return
        self._check_index()
        match record:
            case records.Chunk():
                self._chunks.append(start)
                try:
                    self._check_chunk(record)
                except (DamagedError, SlipmodeError) as error:
                    self.complaints.append(f"chunk at byte {start}: {error}")
            case records.DataEnd(data_section_crc=crc) if crc:
                if crc != self._check_sum(start):
                    self.complaints.append("the check sum of the data section does not fit it")
            case records.Message():
                self.outside.append(start)
                self.inventory.add(record)
            case other:
                self.inventory.add(other)

    def _check_index(self) -> None:
        """Compare the indexes of the last chunk with its messages, after the last index."""
        expected, found = self._expected, self._indexed
        self._expected, self._indexed = None, {}
        if expected is not None and (
            expected.keys() != found.keys()
            or any(not np.array_equal(found[number], expected[number]) for number in found)
        ):
            self.complaints.append("the index of a chunk does not fit its messages")

    def _check_chunk(self, chunk: records.Chunk) -> None:
        before = dict(self.inventory.last)
        messages = self.inventory.add(chunk)
        self._expected = {number: np.sort(each.entries) for number, each in messages.items()}
        times = [each.prefix["log_time"] for each in messages.values()]
        if times:
            span = min(t.min() for t in times), max(t.max() for t in times)
            if span != (chunk.message_start_time, chunk.message_end_time):
                self.complaints.append("a chunk has other times than it claims")
        for number, each in messages.items():
            self._check_messages(number, each, before.get(number, 0))

    def _check_messages(self, number: int, messages: Messages, before: int) -> None:
        time_ns = messages.prefix["log_time"]
        if number not in self._disordered and (
            int(time_ns[0]) < before or np.any(time_ns[1:] < time_ns[:-1])
        ):
            self._disordered.add(number)
            topic = self.inventory.channels[number].topic
            self.complaints.append(f"{topic}: time runs backwards")
        channel = sample_channel(self.inventory, number)
        if channel is not None:
            channel.decode(messages.data())

    def compare_with_summary(self) -> None:
        """Check that the summary describes the chunks and messages of the file."""
        summary = read_summary(self._file)
        if not summary:
            self.complaints.append("there is no summary, or it is damaged")
        starts = [r.chunk_start_offset for r in summary if isinstance(r, records.ChunkIndex)]
        if starts and starts != self._chunks:
            self.complaints.append("the summary lists other chunks than there are")
        for record in summary:
            if isinstance(record, records.Statistics):
                counts = {k: n for k, n in record.channel_message_counts.items() if n}
                if counts != dict(self.inventory.counts):
                    self.complaints.append("the statistics count other messages than there are")

    def _check_sum(self, end: int) -> int:
        """Return the check sum of the file up to byte `end`; leave the file's position."""
        here = self._file.tell()
        self._file.seek(0)
        crc = 0
        block = 1024 * 1024
        for start in range(0, end, block):
            crc = zlib.crc32(self._file.read(min(block, end - start)), crc)
        self._file.seek(here)
        return crc
