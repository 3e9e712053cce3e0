"""The plan of a scene whose amplitudes share one tone: several modes, or a mistuned disk."""

from __future__ import annotations

from abc import ABC, abstractmethod

from slipmode.rom import SlipmodeError, ToneFlow
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.validity import Finding
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene


class TonePlan(ABC):
    """Hold a scene with one force on all amplitudes, and all modelling decisions about it.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its force and frequency in each communication step.
    decisions : list of Finding
        Decisions and warnings with their reasons.
    """

    scene: Scene
    schedule: Schedule
    decisions: list[Finding]

    @property
    def warnings(self) -> list[str]:
        """Decisions that are warnings, one line each."""
        return [command_words(each.line()) for each in self.decisions if each.level != "info"]

    @property
    def frequency_range(self) -> tuple[float, float]:
        """Smallest and largest forcing frequency [rad/s]."""
        low, high = self.schedule.frequency_range(("A",))
        return float(low[0]), float(high[0])

    @property
    @abstractmethod
    def summary(self) -> str:
        """What the scene moves, for the first event of its recording."""

    @abstractmethod
    def flow(self) -> ToneFlow:
        """Return the structure at rest, with the middle of the range as reference frequency."""

    def check_range(self, key: str) -> None:
        """Refuse frequencies that leave the span of one flow; the refusal names a key."""
        low, high = self.frequency_range
        if high - low > SPAN * (high + low):
            units = self.scene.units
            ends = " to ".join(f"{units.of_frequency(each):.6g}" for each in (low, high))
            raise SlipmodeError(
                f"{key}: must stay within {percentage(SPAN)} of the middle of its range, got "
                f"{ends} {units.frequency}; use one scene per resonance"
            )
