"""What has been met of an MCAP file: channels, texts, and the number and times of messages."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mcap import records
from numpy.typing import NDArray

from slipmode.runner.recording.mcapfile.chunk import Contents
from slipmode.runner.recording.mcapfile.scan import DamagedError

WALL_CLOCK = 10**18  # [ns], of 2001; no simulation lasts for thirty years


@dataclass
class Statistics:
    """What has been met of a file.

    Attributes
    ----------
    schemas, channels : dict
        By number.
    metadata : dict of str to dict
    attachments : dict of str to bytes
    counts : Counter
        Messages of each channel, by its number.
    first, last : dict of int to int
        Earliest and latest log time of each channel that has messages [ns].
    chunks : int
    published_later : set of int
        Channels whose log times count from the run's start, and publish times from 1970.
    """

    schemas: dict[int, records.Schema] = field(default_factory=dict)
    channels: dict[int, records.Channel] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    first: dict[int, int] = field(default_factory=dict)
    last: dict[int, int] = field(default_factory=dict)
    chunks: int = 0
    published_later: set[int] = field(default_factory=set)

    def take(self, record: object) -> None:
        """Count in what is not a chunk."""
        match record:
            case records.Schema():
                self.schemas[record.id] = record
            case records.Channel():
                self.channels[record.id] = record
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Attachment():
                self.attachments[record.name] = record.data
            case records.Message():
                self.take_times(record.channel_id, np.array([record.log_time]))

    def take_contents(self, contents: Contents) -> None:
        """Count in a chunk."""
        self.chunks += 1
        for record in (*contents.schemas, *contents.channels):
            self.take(record)
        for number, messages in contents.messages.items():
            log_time, publish_time = (messages.prefix[f"{of}_time"] for of in ("log", "publish"))
            self.take_times(number, log_time)
            if np.any((publish_time >= WALL_CLOCK) & (log_time < WALL_CLOCK)):
                self.published_later.add(number)

    def take_times(self, number: int, time_ns: NDArray[Any]) -> None:
        """Count in messages of channel `number`, by their log times [ns].

        Raises
        ------
        DamagedError
            If the channel has not been described before.
        """
        if number not in self.channels:
            raise DamagedError(f"messages on channel {number}, which the file does not describe")
        if not time_ns.size:
            return
        first, last = int(time_ns.min()), int(time_ns.max())
        self.first[number] = min(first, self.first.get(number, first))
        self.last[number] = max(last, self.last.get(number, last))
        self.counts[number] += time_ns.size

    def mixed_clocks(self) -> list[str]:
        """A complaint, if some times count from 1970 and others from the run's start."""
        for number in self.published_later:
            topic = self.channels[number].topic
            words = f"mixed clocks: {topic} has publish times from 1970, log times from the run's"
            return [f"{words} start"]
        wall = [number for number, last in self.last.items() if last >= WALL_CLOCK]
        simulated = [number for number, first in self.first.items() if first < WALL_CLOCK]
        if not (wall and simulated):
            return []
        late, early = (self.channels[numbers[0]].topic for numbers in (wall, simulated))
        return [f"mixed clocks: {late} has times from 1970, {early} from the run's start"]
