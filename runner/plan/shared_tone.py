"""The plan of a scene with several modes on one tone."""

from __future__ import annotations

import warnings
from dataclasses import field
from itertools import product

import numpy as np

from slipmode.rom import SlipmodeError, Structure, ToneFlow, ToneModel, tabulate
from slipmode.rom.errors import ValidityWarning, naming
from slipmode.rom.frequencies import carrier_findings, check_carrier
from slipmode.rom.reduction.tones import sliding_law
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.tone_states import ForcedTone
from slipmode.rom.validity import Finding
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.tone_plan import TonePlan
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.sections import Scene


@frozen
class SharedTonePlan(TonePlan):
    """Hold a scene with several modes on one tone, and all modelling decisions about it.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its force and frequency in each communication step.
    model : ToneModel
        Reduced structure, with a friction table for each contact.
    excited : Excited
        Its modes at rest, and the force on the DOFs per unit of `forcing.A.amplitude` [-].
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
        names = " and ".join(self.model.reduced.mode_names)
        return f"modes {names} on one tone, {self.model.reduced.n_contacts} contacts"

    def forced(self, frequency: float) -> ForcedTone:
        """Return the model under the force, without its warnings; the plan has them."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            force = self.excited.force_patterns
            return ForcedTone.of(self.model, force, 0.0, np.array([[frequency]]))

    def flow(self) -> ToneFlow:
        """Return the structure at rest, with the middle of the range as reference frequency."""
        middle = 0.5 * sum(self.frequency_range)
        return self.forced(middle).flow(np.array([middle]), self.scene.run.tolerance)


def plan_shared_tone(scene: Scene) -> SharedTonePlan:
    """Return the plan of a scene with several modes on tone A."""
    structure = scene.build()
    scene, numbers = scene.located(structure.labels), scene.modes.on_tone
    for dof in scene.output.elastic:
        if dof >= structure.n_dofs:
            raise SlipmodeError(
                f"output.elastic: DOF {dof} is out of range, allowed: 0 to {structure.n_dofs - 1}"
            )
    with naming("contacts"):
        law = sliding_law(law_of(scene, structure.n_contacts), structure.n_contacts)
    with naming("modes.A"):
        reduced = kept_reduction(structure, numbers, "consistent", law, None, shares_tone=True)
        model = tabulate(reduced, law, tolerance=scene.model.tolerance)
    force = scene.forcing["A"].rotating(structure.n_dofs)
    parts = product(range(model.modes), (force.real, force.imag))
    if not any(model.reduced.is_moved_by(*part) for part in parts):
        raise SlipmodeError(
            "forcing.A: this force does no work on the modes of tone A; choose another DOF or "
            "vector"
        )
    rest = model.modes * (0j,)
    excited = Excited(("A",), model.reduced, model.law, (force,), rest, rest)
    schedule = make_schedule(scene, {"A": model.middle})
    plan = SharedTonePlan(scene, schedule, model, excited, structure)
    plan.check_range("forcing.A.frequency")
    plan.decisions.extend(_decisions(plan))
    return plan


def _decisions(plan: SharedTonePlan) -> list[Finding]:
    scene, reduced, unit = plan.scene, plan.model.reduced, plan.scene.units.frequency
    reached, middle = np.array(plan.frequency_range), plan.model.carrier
    check_carrier("forcing.A.frequency", "A", plan.model.middle, reached, unit)
    omega = [f"{scene.units.of_frequency(each):.5g}" for each in reduced.frequency.tolist()]
    spread = float(reduced.frequency.max() / reduced.frequency.min() - 1.0)
    windows = [f"{each.start:g} to {each.end:g} s" for each in scene.windows]
    return [
        Finding(
            f"modes {', '.join(reduced.mode_names)}",
            "share tone A",
            f"numbers {', '.join(map(str, reduced.modes))} at {', '.join(omega)} {unit}, within "
            f"{percentage(spread)}; one force moves all of them, and contacts couple them",
        ),
        Finding(
            "contacts",
            "one friction table per contact",
            "over the amplitude of the contact, with its own response to higher harmonics",
        ),
        Finding(
            "fast motion",
            ", ".join(windows) or "none",
            "the harmonic of displacements at the forcing frequency, and the forces of contacts "
            "that move by it"
            if windows
            else "no [[contact]] or [[elastic]] window",
        ),
        *carrier_findings("forcing.{}.frequency", ("A",), middle, reached[:, np.newaxis], unit),
        *plan.forced(float(reached.mean())).transient_findings(reached.mean(keepdims=True)),
    ]
