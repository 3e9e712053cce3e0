"""What a recording holds, without reading its samples: `slipmode info`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.load import sample_channel
from slipmode.runner.recording.mcapfile.chunk import unpack
from slipmode.runner.recording.mcapfile.scan import DamagedError, StoredChunk, scan
from slipmode.runner.recording.mcapfile.source import opened
from slipmode.runner.recording.mcapfile.statistics import Statistics

_NANOSECONDS = 1e9


@dataclass(frozen=True)
class ChannelInfo:
    """One channel of a recording.

    Attributes
    ----------
    topic, message_type : str
    units : dict of str to str
        Unit of each field; empty for a channel that holds no samples of ours.
    count : int
        Messages.
    start, end : float
        Simulation time of the first and the last [s]; 0 without messages.
    """

    topic: str
    message_type: str
    units: dict[str, str]
    count: int
    start: float
    end: float


@dataclass(frozen=True)
class Info:
    """What a recording holds.

    Attributes
    ----------
    title, scene_name : str
        Empty for a file of another program.
    run : mapping of str to str
        Hashes, versions and wall clock of the run.
    channels : list of ChannelInfo
    chunks, size : int
        Chunks, and bytes of the file.
    damage : str
        Why the file cannot be read to its end; empty if it can.
    """

    title: str
    scene_name: str
    run: Mapping[str, str]
    channels: list[ChannelInfo]
    chunks: int
    size: int
    damage: str

    __repr__ = short_repr

    @property
    def span(self) -> tuple[float, float]:
        """First and last simulation time [s]; 0 without messages."""
        used = [channel for channel in self.channels if channel.count]
        first = min((channel.start for channel in used), default=0.0)
        return first, max((channel.end for channel in used), default=0.0)

    def text(self) -> str:
        """Lines for a reader."""
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
    """Say what a recording holds; also of a damaged one, as far as it can be read.

    Parameters
    ----------
    path : path
        An MCAP file.

    Raises
    ------
    SlipmodeError
        If there is no such file, or it is not MCAP.
    """
    statistics, damage = Statistics(), ""
    with opened(path) as file:
        try:
            for piece in scan(file):
                if isinstance(piece.record, StoredChunk):
                    _count(statistics, piece.record)
                else:
                    statistics.take(piece.record)
        except DamagedError as error:
            damage = str(error)
    scene = statistics.metadata.get("scene", {})
    return Info(
        title=scene.get("title", ""),
        scene_name=scene.get("name", ""),
        run=statistics.metadata.get("run", {}),
        channels=[_describe(statistics, number) for number in statistics.channels],
        chunks=statistics.chunks,
        size=Path(path).stat().st_size,
        damage=damage,
    )


def _count(statistics: Statistics, stored: StoredChunk) -> None:
    """Count messages by the index, or, where it does not tell all, by looking at them."""
    known = all(index.channel in statistics.channels for index in stored.indexes)
    if stored.indexes and known and not stored.cut:
        statistics.chunks += 1
        for index in stored.indexes:
            statistics.take_times(index.channel, index.entries["log_time"])
    else:
        statistics.take_contents(unpack(stored))


def _describe(statistics: Statistics, number: int) -> ChannelInfo:
    record = statistics.channels[number]
    schema = statistics.schemas.get(record.schema_id)
    try:
        channel = sample_channel(record, schema)
    except SlipmodeError:  # of another program
        channel = None
    return ChannelInfo(
        topic=record.topic,
        message_type="" if schema is None else schema.name,
        units={} if channel is None else {field.name: field.unit for field in channel.fields},
        count=statistics.counts[number],
        start=statistics.first.get(number, 0) / _NANOSECONDS,
        end=statistics.last.get(number, 0) / _NANOSECONDS,
    )
