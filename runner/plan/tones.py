"""The plan of a scene with several modes on a tone."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import product
from typing import ClassVar

import numpy as np

from slipmode.rom import SlipmodeError, Structure, ToneModel, tabulate
from slipmode.rom.errors import ValidityWarning, naming
from slipmode.rom.frequencies import carrier_findings
from slipmode.rom.reduction.tones import sliding_law
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.slow.tone.tone_states import ForcedTone
from slipmode.rom.validity import Finding
from slipmode.runner.plan.checks import checked_schedule
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import Plan, recording_decisions
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.sections import Scene


@frozen
class ExcitedTones(Excited):
    """Modes at rest that share tones; the model has a friction table for each contact."""

    kind: ClassVar[str] = "tones"

    tone_model: ToneModel

    @property
    def natural(self) -> dict[str, float]:
        """See `Moving`: the middle of the modes on each tone."""
        return dict(zip(self.modes, self.tone_model.carrier.tolist(), strict=True))

    @property
    def mode_names(self) -> Sequence[str]:
        """Names of the amplitudes: A, A2, ..., B, B2, ..."""
        return self.reduced.mode_names

    def summary(self, scene: Scene) -> str:
        """See `Moving`."""
        tones, names = " and ".join(self.modes), " and ".join(self.mode_names)
        return f"modes {names} on tone {tones}, {self.reduced.n_contacts} contacts"


# Plan of several modes on a tone.
TonesPlan = Plan[ExcitedTones]


def plan_tones(scene: Scene, structure: Structure) -> TonesPlan:
    """Return the plan of a scene with several modes on a tone."""
    scene, tones = scene.located(structure.labels), scene.modes.tones
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
    excited = ExcitedTones(names, model.reduced, model.law, forces, rest, rest, model)
    schedule = checked_schedule(scene, excited)
    plan = Plan(scene, schedule, excited)
    tables = "over its amplitude on each tone, with its own response to higher harmonics"
    reached, unit = np.array(schedule.frequency_range(names)), scene.units.frequency
    return plan.with_decisions(
        *(_modes_on_tone(plan, tone) for tone in range(len(names))),
        Finding("contacts", "one friction table per contact", tables),
        *recording_decisions(scene),
        *carrier_findings("forcing.{}.frequency", names, model.carrier, reached, unit),
        *_transients(plan),
    )


def _modes_on_tone(plan: TonesPlan, tone: int) -> Finding:
    """Return which modes a tone moves, and why; refuse frequencies that leave its span."""
    reduced, units, name = plan.excited.reduced, plan.scene.units, plan.excited.modes[tone]
    middle = plan.excited.natural[name]
    reached = np.ravel(plan.schedule.frequency_range((name,)))
    if np.abs(reached / middle - 1.0).max() > SPAN:
        shown, unit = units.of_frequency(np.append(middle, reached)), units.frequency
        raise SlipmodeError(
            f"forcing.{name}.frequency: must stay within {percentage(SPAN)} of {shown[0]:.6g} "
            f"{unit}, the middle of the modes on tone {name}, got {shown[1]:.6g} to "
            f"{shown[2]:.6g} {unit}; choose other modes, or a scene for each resonance"
        )
    own = reduced.on_tones[tone]
    modes, omega = reduced.mode_names[own], reduced.frequency[own]
    listed = ", ".join(f"{units.of_frequency(each):.5g}" for each in omega.tolist())
    numbers = f"numbers {', '.join(map(str, reduced.modes[own]))} at {listed} {units.frequency}"
    if len(modes) == 1:
        return Finding(f"mode {name}", f"is on tone {name}", numbers)
    spread = percentage(float(omega.max() / omega.min() - 1.0))
    reason = f"{numbers}, within {spread}; one force moves all of them, and contacts couple them"
    return Finding(f"modes {', '.join(modes)}", f"share tone {name}", reason)


def _transients(plan: TonesPlan) -> list[Finding]:
    """Return what a run neglects, under the largest forces at the ends of the frequencies."""
    names = plan.excited.modes
    reached = np.array(plan.schedule.frequency_range(names))
    force = np.abs(plan.schedule.extremes([f"force_{name}" for name in names])).max(axis=0)
    patterns = [f * size for f, size in zip(plan.excited.force_patterns, force, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # the plan has these findings
        forced = ForcedTone.of(plan.excited.tone_model, patterns, 0.0, reached)
    return max((forced.transient_findings(each) for each in np.unique(reached, axis=0)), key=len)
