"""The plan of a scene with several modes on a tone."""

from __future__ import annotations

import warnings
from dataclasses import field
from itertools import product

import numpy as np

from slipmode.fmu import Component
from slipmode.rom import SlipmodeError, Structure, ToneModel, tabulate
from slipmode.rom.errors import ValidityWarning, naming
from slipmode.rom.frequencies import carrier_findings, check_carrier
from slipmode.rom.reduction.tones import sliding_law
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.slow.tone.tone_states import ForcedTone
from slipmode.rom.validity import Finding
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.scene_plan import ScenePlan
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.sections import Scene


@frozen
class SharedTonePlan(ScenePlan):
    """Hold a scene with several modes on a tone, and all modelling decisions about it.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its forces and frequencies in each communication step.
    model : ToneModel
        Reduced structure, with a friction table for each contact.
    excited : Excited
        Tones at rest, and the force of each on the DOFs per unit of its amplitude [-].
    structure : Structure
        Structure of the scene.
    decisions : list of Finding
        Decisions and warnings with their reasons.
    """

    scene: Scene
    schedule: Schedule
    model: ToneModel
    excited: Excited
    structure: Structure
    decisions: list[Finding] = field(default_factory=list)

    @property
    def summary(self) -> str:
        """What the scene moves, for the first event of its recording."""
        reduced, tones = self.model.reduced, " and ".join(self.excited.modes)
        names = " and ".join(reduced.mode_names)
        return f"modes {names} on tone {tones}, {reduced.n_contacts} contacts"

    def component(self) -> Component:
        """Return the structure at rest, with the outputs of contacts if the scene has windows."""
        return Component(
            self.model,
            self.excited.force_patterns,
            contact=bool(self.scene.windows),
            elastic=self.scene.output.elastic,
            tolerance=self.scene.run.tolerance,
            warned=False,
        )


def plan_shared_tone(scene: Scene) -> SharedTonePlan:
    """Return the plan of a scene with several modes on a tone."""
    structure = scene.build()
    scene, tones = scene.located(structure.labels), scene.modes.tones
    for dof in scene.output.elastic:
        if dof >= structure.n_dofs:
            raise SlipmodeError(
                f"output.elastic: DOF {dof} is out of range, allowed: 0 to {structure.n_dofs - 1}"
            )
    with naming("contacts"):
        law = sliding_law(law_of(scene, structure.n_contacts), structure.n_contacts)
    numbers = [number for each in tones for number in each]
    tone_of_each = tuple(tone for tone, each in enumerate(tones) for _ in each)
    with naming("modes"):
        reduced = kept_reduction(structure, numbers, "consistent", law, None, tones=tone_of_each)
        model = tabulate(reduced, law, tolerance=scene.model.tolerance)
    names = tuple(scene.modes.numbers)
    forces = tuple(scene.forcing[name].rotating(structure.n_dofs) for name in names)
    for name, force, own in zip(names, forces, reduced.on_tones, strict=True):
        parts = product(range(own.start, own.stop), (force.real, force.imag))
        if not any(reduced.is_moved_by(*part) for part in parts):
            raise SlipmodeError(
                f"forcing.{name}: this force does no work on the modes of tone {name}; choose "
                "another DOF or vector"
            )
    rest = model.modes * (0j,)
    excited = Excited(names, model.reduced, model.law, forces, rest, rest)
    schedule = make_schedule(scene, dict(zip(names, model.carrier.tolist(), strict=True)))
    plan = SharedTonePlan(scene, schedule, model, excited, structure)
    plan.decisions.extend(_decisions(plan))
    return plan


def _decisions(plan: SharedTonePlan) -> list[Finding]:
    scene, names, unit = plan.scene, plan.excited.modes, plan.scene.units.frequency
    reached, middle = np.array(plan.schedule.frequency_range(names)), plan.model.carrier
    found = []
    for tone, name in enumerate(names):
        check_carrier(f"forcing.{name}.frequency", name, middle[tone], reached[:, tone], unit)
        if np.abs(reached[:, tone] / middle[tone] - 1.0).max() > SPAN:
            shown = scene.units.of_frequency(np.append(middle[tone], reached[:, tone]))
            raise SlipmodeError(
                f"forcing.{name}.frequency: must stay within {percentage(SPAN)} of {shown[0]:.6g} "
                f"{unit}, the middle of the modes on tone {name}, got {shown[1]:.6g} to "
                f"{shown[2]:.6g} {unit}; choose other modes, or a scene for each resonance"
            )
        found.append(_modes_on_tone(plan, tone))
    windows = [f"{each.start:g} to {each.end:g} s" for each in scene.windows]
    reason = "displacements at the forcing frequencies, and the forces of contacts that move so"
    return [
        *found,
        Finding(
            "contacts",
            "one friction table per contact",
            "over its amplitude on each tone, with its own response to higher harmonics",
        ),
        Finding(
            "fast motion",
            ", ".join(windows) or "none",
            reason if windows else "no [[contact]] or [[elastic]] window",
        ),
        *carrier_findings("forcing.{}.frequency", names, middle, reached, unit),
        *_transient_findings(plan),
    ]


def _modes_on_tone(plan: SharedTonePlan, tone: int) -> Finding:
    """Return which modes a tone moves, and why."""
    reduced, units = plan.model.reduced, plan.scene.units
    own, name = reduced.on_tones[tone], plan.excited.modes[tone]
    modes, omega = reduced.mode_names[own], reduced.frequency[own]
    listed = ", ".join(f"{units.of_frequency(each):.5g}" for each in omega.tolist())
    numbers = f"numbers {', '.join(map(str, reduced.modes[own]))} at {listed} {units.frequency}"
    if len(modes) == 1:
        return Finding(f"mode {name}", f"is on tone {name}", numbers)
    spread = percentage(float(omega.max() / omega.min() - 1.0))
    reason = f"{numbers}, within {spread}; one force moves all of them, and contacts couple them"
    return Finding(f"modes {', '.join(modes)}", f"share tone {name}", reason)


def _transient_findings(plan: SharedTonePlan) -> list[Finding]:
    """Return what a run neglects, under the largest forces at the ends of the frequencies."""
    names = plan.excited.modes
    reached = np.array(plan.schedule.frequency_range(names))
    force = np.abs(plan.schedule.extremes([f"force_{name}" for name in names])).max(axis=0)
    patterns = [f * size for f, size in zip(plan.excited.force_patterns, force, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # the plan has these findings
        forced = ForcedTone.of(plan.model, patterns, 0.0, reached)
    return max((forced.transient_findings(each) for each in np.unique(reached, axis=0)), key=len)
