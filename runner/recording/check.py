"""What a recording holds, `slipmode info`, and whether it is sound, `slipmode doctor`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.channels import NANOSECONDS
from slipmode.runner.recording.contents.inventory import Inventory, Part
from slipmode.runner.recording.contents.layout import DamagedError, MessageIndex, record_bytes
from slipmode.runner.recording.contents.summary import Summary
from slipmode.runner.recording.contents.walk import Found, opened
from slipmode.runner.recording.load import sample_channel

_SUMMARY_RECORDS = (
    records.Schema,
    records.Channel,
    records.Statistics,
    records.ChunkIndex,
    records.AttachmentIndex,
    records.MetadataIndex,
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
    """Contents of a recording.

    Attributes
    ----------
    title, scene_name : str
        Empty for a file of another program.
    run : mapping of str to str
        Hashes, versions and wall clock of the run.
    channels : list of ChannelInfo
    span : tuple of two floats
        First and last simulation time [s]; 0 without messages.
    chunks : int
    size : int
        Bytes of the file.
    damage : str
        Why the file cannot be read to its end.
    """

    title: str
    scene_name: str
    run: Mapping[str, str]
    channels: list[ChannelInfo]
    span: tuple[float, float]
    chunks: int
    size: int
    damage: str

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

    Parameters
    ----------
    path : path
    """
    inventory = Inventory()
    with opened(path) as file:
        for _ in inventory.read(file):
            pass
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

    Raises SlipmodeError if there is no such file, or it is not MCAP.

    Parameters
    ----------
    path : path

    Returns
    -------
    list of str
        A line for each fault.
    """
    inventory, summary = Inventory(), Summary()
    latest: dict[int, int] = {}  # log time of each channel [ns]
    closing: list[Found] = []  # from the end of the data section on
    # entries that the indexes of the last chunk must have, and entries that they have
    expected: dict[int, bytes] | None = None
    indexed: dict[int, bytes] = {}
    with opened(path) as file:
        for part in inventory.read(file, beyond_damage=True):
            record, start = part.found.record, part.found.start
            if closing or isinstance(record, records.DataEnd):
                closing.append(part.found)
            elif not isinstance(record, records.Schema | records.Channel):
                summary.add(record, start, part.found.end)
            if isinstance(record, MessageIndex):
                if record.entries.size:
                    indexed[record.channel] = np.sort(record.entries).tobytes()
                continue
            if indexed and expected not in (None, indexed):
                inventory.faults.append("the index of a chunk does not fit its messages")
            indexed, expected = {}, None
            if part.whole:
                expected = {k: np.sort(m.entries).tobytes() for k, m in part.messages.items()}
            for words in _content_faults(inventory, part, latest):
                inventory.faults.append(words)
    summary.records += inventory.described()
    first, last = min(inventory.first.values(), default=0), max(inventory.last.values(), default=0)
    summary.records.append(summary.statistics(inventory.counts, first, last))
    faults = [*inventory.faults, *_summary_faults(closing, summary.records)]
    return [*dict.fromkeys(faults), *filter(None, [inventory.mixed_clocks()])]


def _content_faults(inventory: Inventory, part: Part, latest: dict[int, int]) -> Iterator[str]:
    """Check the messages of a chunk against its head, their times and their schemas."""
    where, chunk = f"chunk at byte {part.found.start}", part.found.record
    if isinstance(chunk, records.Chunk) and part.whole:
        if chunk.uncompressed_size != len(part.raw):
            yield f"{where}: it has another size than it claims"
        times = [each.prefix["log_time"] for each in part.messages.values()]
        span = chunk.message_start_time, chunk.message_end_time
        if times and span != (min(map(np.min, times)), max(map(np.max, times))):
            yield f"{where}: it has other times than it claims"
    for number, each in part.messages.items():
        if each.disordered(latest.get(number, 0)):
            yield f"{inventory.channels[number].topic}: time runs backwards"
        latest[number] = inventory.last[number]
        try:
            if channel := sample_channel(inventory, number):
                channel.decode(each.data())
        except (DamagedError, SlipmodeError) as error:
            yield f"{where}: {error}"


def _summary_faults(closing: list[Found], known: list[records.McapRecord]) -> Iterator[str]:
    """Check that the summary describes the records that are known from the data section."""
    if not closing or not isinstance(closing[-1].record, records.Footer):
        return  # the walk said why
    start, footer, end = closing[0].end, closing[-1].record, closing[-1].start
    listed = [(each, each.record) for each in closing[1:-1]]
    offsets = [(each, r) for each, r in listed if isinstance(r, records.SummaryOffset)]
    groups = [(each, r) for each, r in listed if isinstance(r, _SUMMARY_RECORDS)]
    if footer.summary_start != (start if listed else 0):
        yield "the footer places the summary elsewhere"
    if footer.summary_offset_start not in (0, offsets[0][0].start if offsets else end):
        yield "the footer places the offsets of the summary elsewhere"
    for kind in _SUMMARY_RECORDS:
        group = [(each, r) for each, r in groups if type(r) is kind]
        there = Counter(_key(each) for each in known if isinstance(each, kind))
        if group and Counter(_key(r) for _, r in group) != there:
            yield f"the {kind.__name__} records of the summary do not fit the file"
        for _, told in offsets if group else ():
            first, last = group[0][0].start, group[-1][0].end
            place = told.group_start, told.group_start + told.group_length
            if told.group_opcode == record_bytes(group[0][1])[0] and place != (first, last):
                yield f"the summary places its {kind.__name__} records elsewhere"


def _key(record: records.McapRecord) -> str:
    """Return the fields of a record; the order of maps and counts of 0 do not matter."""
    fields = dict(vars(record))
    for name, value in fields.items():
        if isinstance(value, dict):
            fields[name] = sorted(item for item in value.items() if item[1] != 0)
    return repr(fields)
