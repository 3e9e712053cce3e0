"""What a recording holds, `slipmode info`, and whether it is sound, `slipmode doctor`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from os import PathLike

import numpy as np
from mcap import records

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.channels import NANOSECONDS
from slipmode.runner.recording.inventory import Inventory, opened
from slipmode.runner.recording.mcap_file.records import (
    DamagedError,
    Loose,
    MessageIndex,
    Record,
    record_bytes,
)
from slipmode.runner.recording.mcap_file.walk import Part
from slipmode.runner.recording.mcap_file.writer import statistics, summarize


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
    with opened(path) as inventory:
        for _ in inventory.read():
            pass
    header, (first, last) = inventory.header(), inventory.span
    return Info(
        title=header.title,
        scene_name=header.scene_name,
        run=header.run,
        channels=[_describe(inventory, number) for number in inventory.channels],
        span=(first / NANOSECONDS, last / NANOSECONDS),
        chunks=inventory.chunks,
        size=inventory.walk.size,
        damage=inventory.damage,
    )


def _describe(inventory: Inventory, number: int) -> ChannelInfo:
    units = {}
    with suppress(SlipmodeError):  # another program's channel has no fields of samples
        if channel := inventory.sample_channel(number):
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
    latest: dict[int, int] = {}  # log time of each channel [ns]
    summary: list[records.McapRecord] = []  # as it must be
    closing: list[Part] = []  # from the end of the data section on
    chunk = Part(0, 0, None)  # the one before the message indexes
    with opened(path) as inventory:
        faults = inventory.faults
        for part in inventory.read(beyond_damage=True):
            if closing or isinstance(part.record, records.DataEnd):
                closing.append(part)
            elif not isinstance(part.record, records.Schema | records.Channel | Loose):
                summarize(summary, part.record, part.start, part.end)
            if isinstance(part.record, MessageIndex):
                if chunk.whole and not _fits(part.record, chunk):
                    faults.append("the index of a chunk does not fit its messages")
                continue
            chunk = part
            faults.extend(_content_faults(inventory, part, latest))
    summary += inventory.described()
    summary.append(statistics(summary, inventory.counts, inventory.span))
    faults += _summary_faults(closing, summary)
    return [*dict.fromkeys(faults), *filter(None, [inventory.mixed_clocks()])]


def _fits(index: MessageIndex, chunk: Part) -> bool:
    """Return whether an index has the messages of its channel; it may be empty."""
    messages = chunk.messages.get(index.channel)
    there = index.entries[:0] if messages is None else messages.entries
    same = np.sort(index.entries).tobytes() == np.sort(there).tobytes()
    return same or not index.entries.size


def _content_faults(inventory: Inventory, part: Part, latest: dict[int, int]) -> Iterator[str]:
    """Check the messages of a chunk against its head, their times and their schemas."""
    where, chunk = f"chunk at byte {part.start}", part.record
    if isinstance(chunk, records.Chunk) and part.whole:
        if chunk.uncompressed_size != len(part.raw):
            yield f"{where}: it has another size than it claims"
        times = [each.prefix["log_time"] for each in part.messages.values()]
        span = chunk.message_start_time, chunk.message_end_time
        known = times and not isinstance(chunk, Loose)
        if known and span != (min(map(np.min, times)), max(map(np.max, times))):
            yield f"{where}: it has other times than it claims"
    for number, each in part.messages.items():
        time_ns = each.prefix["log_time"]
        if time_ns[0] < latest.get(number, 0) or np.any(time_ns[1:] < time_ns[:-1]):
            yield f"{inventory.channels[number].topic}: time runs backwards"
        latest[number] = inventory.last[number]
        try:
            if channel := inventory.sample_channel(number):
                channel.decode(each.data())
        except (DamagedError, SlipmodeError) as error:
            yield f"{where}: {error}"


def _summary_faults(closing: list[Part], expected: list[records.McapRecord]) -> Iterator[str]:
    """Check the records after the data section, its end included."""
    if not closing or not isinstance(footer := closing[-1].record, records.Footer):
        return  # the walk said why
    listed, groups = closing[1:-1], set[tuple[int, int, int]]()  # opcode, place, length
    offsets = (part.start for part in listed if isinstance(part.record, records.SummaryOffset))
    if footer.summary_start != (closing[0].end if listed else 0):
        yield "the footer places the summary elsewhere"
    if footer.summary_offset_start not in (0, next(offsets, closing[-1].start)):
        yield "the footer places the offsets of the summary elsewhere"
    for kind, parts in groupby(listed, lambda part: type(part.record)):
        group = list(parts)
        found = [part.record for part in group if part.record]
        if kind is records.SummaryOffset:
            places = {tuple(vars(each).values()) for each in found}
            if not {place for place in places if place[-1]} <= groups:  # some are of no records
                yield "the summary places its records elsewhere"
        elif found:
            start, end = group[0].start, group[-1].end
            groups.add((record_bytes(found[0])[0], start, end - start))
            there = Counter(_key(each) for each in expected if isinstance(each, kind))
            if Counter(map(_key, found)) != there:
                yield f"the {kind.__name__} records of the summary do not fit the file"


def _key(record: Record) -> str:
    """Return the fields of a record; the order of maps and counts of 0 do not matter."""
    fields = dict(vars(record))
    for name, value in fields.items():
        if isinstance(value, dict):
            fields[name] = sorted(item for item in value.items() if item[1] != 0)
    return repr(fields)
