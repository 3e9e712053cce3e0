"""A part of a recording: some of its channels, some of its time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.load import RecordingData, Signals


@dataclass(frozen=True)
class Selection:
    """What to take of a recording.

    Parameters
    ----------
    topics : sequence of str
        Channels; all of them if empty.
    start, end : float
        First and last simulation time [s].

    Raises
    ------
    SlipmodeError
        If the times are not in order.
    """

    topics: Sequence[str] = ()
    start: float = -math.inf
    end: float = math.inf

    def __post_init__(self) -> None:
        if not self.start <= self.end:
            raise SlipmodeError(f"start {self.start:g} s must not be after end {self.end:g} s")

    def of(self, data: RecordingData) -> RecordingData:
        """The selected part of a recording.

        Raises
        ------
        SlipmodeError
            If it has no such channel, or no sample between the times.
        """
        channels = chosen(data.channels, self.topics)
        header = data.header
        if self.start > -math.inf or self.end < math.inf:
            channels = {topic: self._within(signals) for topic, signals in channels.items()}
            header = replace(header, title=f"{header.title}, t = {self.start:g} to {self.end:g} s")
            if not any(signals.time.size for signals in channels.values()):
                raise SlipmodeError(
                    f"no samples from {self.start:g} to {self.end:g} s: "
                    f"the recording ends at {data.end_time:g} s"
                )
        events = [event for event in data.events if self.start <= event.time <= self.end]
        return replace(data, header=header, channels=channels, events=events)

    def _within(self, signals: Signals) -> Signals:
        kept = (self.start <= signals.time) & (signals.time <= self.end)
        return signals._replace(
            time=signals.time[kept], values=np.compress(kept, signals.values, 0)
        )


def chosen(channels: Mapping[str, Signals], topics: Sequence[str]) -> dict[str, Signals]:
    """The channels of some topics, or all of them if none is named.

    Raises
    ------
    SlipmodeError
        If there is no such channel.
    """
    for topic in topics:
        if topic not in channels:
            raise SlipmodeError(f"no channel {topic}: {', '.join(channels)}")
    return {topic: channels[topic] for topic in topics or channels}
