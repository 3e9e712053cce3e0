"""The plan of a scene: what will be computed, and why."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Generic, Self, TypeAlias, TypeVar

import numpy as np

from slipmode.fmu import Component
from slipmode.rom import Model, Structure
from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.representable import round_up
from slipmode.rom.validity import Finding
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.plan.excited import Excited, Moving
from slipmode.runner.recording.channels import Channel
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene

Intervals = tuple[tuple[float, float], ...]
Kind = TypeVar("Kind", bound=Moving, covariant=True)


@dataclass(frozen=True, eq=False)
class Plan(Generic[Kind]):
    """Hold a scene and all modelling decisions about it, with their reasons.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its forces and frequencies in each communication step.
    excited : object
        What moves, with the forces on it: one or two modes, travelling waves, several modes on a
        tone (with the attribute `tone_model`), or the blades of a mistuned disk (with `disk`,
        `force`, `engine_order` and the recorded `dof`).
    decisions : list of Finding
        Decisions and warnings with their reasons.
    amplitude : tuple of float
        Amplitude range of the friction table [kg^1/2 m]; empty without a table.
    combinations : tuple of CombinationResonance
        Harmonics that come near a carrier during the scene.
    full_order : tuple of (float, float)
        Start and end of the intervals that are integrated at full order [s], from the dry run.
    """

    scene: Scene
    schedule: Schedule
    excited: Kind
    decisions: list[Finding] = field(default_factory=list)
    amplitude: tuple[float, ...] = ()
    combinations: tuple[CombinationResonance, ...] = ()
    full_order: Intervals = ()

    def __repr__(self) -> str:
        amplitudes = ", ".join(f"{amplitude:.4g}" for amplitude in self.amplitude)
        return (
            f"Plan({self.scene.title!r}: {self.summary}, "
            f"{f'amplitudes to {amplitudes}, ' if amplitudes else ''}{self.schedule.steps} steps, "
            f"{len(self.decisions)} decisions)"
        )

    @property
    def kind(self) -> str:
        """Which pass goes through the scene: a key of `slipmode.runner.run.PASSES`."""
        return "full order" if self.scene.model.table == "none" else self.excited.kind

    @property
    def summary(self) -> str:
        """What moves, and how it is computed, for the first event of a recording."""
        return self.excited.summary(self.scene)

    @property
    def warnings(self) -> list[str]:
        """Decisions that are warnings, one line each."""
        return [command_words(each.line()) for each in self.decisions if each.level != "info"]

    @property
    def channels(self) -> list[Channel]:
        """Channels that a run records."""
        return self.excited.channels(self.scene)

    @property
    def full_order_share(self) -> float:
        """Share of the duration that the dry run integrates at full order, 0 to 1."""
        return sum(end - start for start, end in self.full_order) / self.scene.run.duration

    @property
    def may_be_integrated(self) -> bool:
        """Whether the scene has a table, and `model.table = "none"` is possible as well."""
        scene = self.scene
        fixed = scene.limit_scale is None and scene.saved_model is None and scene.disk is None
        return scene.tabulated and fixed and scene.model.formulation != "paper"

    @property
    def structure(self: Plan[Excited]) -> Structure:
        """Structure of the scene.

        Raises
        ------
        SlipmodeError
            If the scene has a saved model, or a disk of one sector.
        """
        return self.excited.structure or self.scene.build()

    @property
    def detuning(self: Plan[Excited]) -> float:
        """Largest relative distance of the forcing from the reference frequencies of the table.

        Rounded up to two digits, so that small changes of a scene share a table; 0 without one.
        """
        if not self.scene.tabulated or self.excited.reduced.formulation == "paper":
            return 0.0
        reached = np.array(self.schedule.frequency_range(self.excited.modes))
        distance = float(np.abs(reached / self.excited.reduced.carrier - 1.0).max())
        return round_up(distance) if distance > 1e-9 else 0.0  # less is rounding

    def model(
        self: Plan[Excited],
        *,
        contact: bool = False,
        headroom: float = 1.0,
        detuning: bool = False,
        progress: bool = False,
    ) -> tuple[Model, bool]:
        """Return the model of the scene, from the cache if possible.

        Parameters
        ----------
        contact : bool, default False
            Include contact motion, even if the scene has no window of it.
        headroom : float, default 1.0
            Margin of the table: its range relative to `amplitude` [-], >= 1.
        detuning : bool, default False
            Let friction depend on the forcing frequencies, even if they are constant.
        progress : bool, default False
            Show a progress bar.

        Returns
        -------
        model : Model
            Reduced structure and friction table; a saved model unchanged.
        cached : bool
            Whether the model was not computed, but saved or cached.

        Raises
        ------
        SlipmodeError
            If the scene has no friction table, or its tolerance cannot be reached.
        """
        self.scene.check_tabulated()
        if self.scene.saved_model is not None:
            return self.scene.saved_model, True
        consistent = self.scene.model.formulation == "consistent"
        return self.excited.model(
            self.amplitude,
            self.scene.model.tolerance,
            combinations=self.combinations,
            harmonics=RESPONSE_ORDER if consistent and (contact or self.scene.windows) else 0,
            headroom=headroom,
            detuning=detuning or min(self.detuning, MOST_DETUNING) or False,
            budget=self.scene.model.budget,
            progress=progress,
        )

    def component(self: Plan[Excited], model: Model) -> Component:
        """Return a component at the start of the scene.

        Parameters
        ----------
        model : Model
            Model of the scene.

        Returns
        -------
        Component
            Component at t = 0 with the force patterns of the scene.
        """
        return self.excited.component(model, self.scene.run.tolerance)

    def with_decisions(self, *found: Finding) -> Self:
        """Return the plan with further decisions."""
        return replace(self, decisions=[*self.decisions, *found])


# Plan of the modes of one structure, or of waves.
ModesPlan: TypeAlias = Plan[Excited]


def recording_decisions(scene: Scene) -> list[Finding]:
    """Return the windows with fast motion, the DOFs that are recorded, and the files."""
    found = (
        []
        if scene.windows
        else [Finding("fast motion", "none", "no [[contact]] or [[elastic]] window")]
    )
    how = "integrated" if scene.model.table == "none" else "reconstructed"
    for kind, windows in (("contact", scene.contact), ("elastic", scene.elastic)):
        for window in windows:
            choice = f"{window.start:g} to {window.end:g} s, {how}"
            reason = f"{window.samples_per_period} samples per period"
            found.append(Finding(f"{kind} motion", choice, reason))
    if dofs := ", ".join(map(str, scene.output.elastic)):
        found.append(Finding("elastic DOFs", dofs, "output.elastic, in every window"))
    kinds = [name for name in ("mcap", "rerun") if getattr(scene.log, name)]
    return [*found, Finding("recording", " and ".join(kinds) or "none", "chosen in [log]")]
