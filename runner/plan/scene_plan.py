"""What all plans of scenes have: the scene, its schedule, and decisions with their reasons."""

from __future__ import annotations

from slipmode.rom.validity import Finding
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene


class ScenePlan:
    """Hold a scene and all modelling decisions about it.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its forces and frequencies in each communication step.
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
