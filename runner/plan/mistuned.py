"""The plan of a scene whose disk is mistuned: the amplitudes of all its modes, without a table."""

from __future__ import annotations

import warnings
from dataclasses import field
from typing import cast

import numpy as np

from slipmode.rom import MistunedDisk, SlipmodeError, ToneFlow, excited_diameter
from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic import resonance_findings
from slipmode.rom.errors import ValidityWarning, naming
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.validity import Finding
from slipmode.runner.plan.checks import check_outputs
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.plan.scene_plan import ScenePlan
from slipmode.runner.plan.shared_tone import SharedTonePlan, plan_shared_tone
from slipmode.runner.recording import channels
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.sections import Scene

# Highest frequency of modes that respond with their inertia, relative to the forcing frequency.
# Higher modes follow statically (`MistunedDisk`).
_HIGHEST = 10.0
_FREQUENCIES = 64  # at which internal resonances are sought


@frozen
class MistunedPlan(ScenePlan):
    """Hold a scene with a mistuned disk and all modelling decisions about it.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its forces and frequencies in each communication step.
    disk : MistunedDisk
        Reduced disk with all blades.
    force : (n_s,) ndarray
        Force on the free DOFs of every sector per unit of `forcing.A.amplitude` [-].
    decisions : list of Finding
        Decisions and warnings with their reasons.
    """

    scene: Scene
    schedule: Schedule
    disk: MistunedDisk
    force: Floats
    decisions: list[Finding] = field(default_factory=list)

    @property
    def engine_order(self) -> int:
        """Engine order of the force."""
        return cast(int, self.scene.forcing["A"].engine_order)

    @property
    def frequency_range(self) -> tuple[float, float]:
        """Smallest and largest forcing frequency [rad/s]."""
        low, high = self.schedule.frequency_range(("A",))
        return float(low[0]), float(high[0])

    @property
    def summary(self) -> str:
        """What the scene moves, for the first event of its recording."""
        return f"{self.disk.structure!r}, mistuned, engine order {self.engine_order}"

    def flow(self) -> ToneFlow:
        """Return the disk at rest, with the middle of the range as reference frequency."""
        middle, tolerance = 0.5 * sum(self.frequency_range), self.scene.run.tolerance
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)  # the plan has this finding
            return self.disk.flow(middle, self.engine_order, self.force, tolerance=tolerance)

    @property
    def dof(self) -> int:
        """DOF of every blade that is recorded: from [output], or where the force is largest."""
        chosen = self.scene.output.elastic
        return chosen[0] if chosen else int(np.abs(self.force).argmax())

    @property
    def channels(self) -> list[channels.Channel]:
        """Channels that a run records."""
        sectors = self.disk.structure.sectors
        listed = [channels.blades(sectors, self.dof), channels.forcing(("A",))]
        return listed + ([channels.disk(sectors, self.dof)] if self.scene.windows else [])


AnyPlan = Plan | SharedTonePlan | MistunedPlan


def plan_scene(scene: Scene, *, progress: bool = False) -> AnyPlan:
    """Return the plan of any scene.

    Parameters
    ----------
    scene : Scene
        Scene from `runner.load_scene`.
    progress : bool, default False
        Print the phases of the computation on standard error.

    Returns
    -------
    Plan, SharedTonePlan or MistunedPlan
        Decisions about the scene: with one or two modes or waves, with several modes on a tone, or
        with a mistuned disk.

    Raises
    ------
    SlipmodeError
        If the scene and its structure do not fit together.
    """
    if scene.mistuning:
        return _plan_mistuned(scene)
    if scene.modes.tones:
        return plan_shared_tone(scene)
    return make_plan(scene, progress=progress)


def _plan_mistuned(scene: Scene) -> MistunedPlan:
    assert scene.disk is not None  # `read_scene` refuses mistuning of other structures
    built = scene.disk.build_disk()
    scene, structure = scene.located(built.labels), built.structure
    law = cast(Elastic, law_of(scene, structure.n_contacts))
    if not law.elements(structure.n_contacts).odd:
        raise SlipmodeError(
            'contacts.law: must be "jenkins", "iwan" or "sliders" with [mistuning], because '
            "contacts of mistuned disks do not lift off"
        )
    check_outputs(scene, structure.free_dofs.size)
    force = scene.forcing["A"].vector(structure.free_dofs.size)
    schedule = make_schedule(scene, {"A": 0.0})  # the mode is forced
    highest = _HIGHEST * float(schedule.frequency_range(("A",))[1][0])
    with naming("structure"):
        disk = MistunedDisk(structure, law, scene.mistuning, highest)
    plan = MistunedPlan(scene, schedule, disk, force)
    _check_range(plan)
    plan.decisions.extend(_decisions(plan))
    return plan


def _check_range(plan: MistunedPlan) -> None:
    """Refuse frequencies that leave the span of one flow."""
    low, high = plan.frequency_range
    if high - low > SPAN * (high + low):
        units = plan.scene.units
        ends = " to ".join(f"{units.of_frequency(each):.6g}" for each in (low, high))
        raise SlipmodeError(
            f"forcing.A.engine_order * rotor_speed: must stay within {percentage(SPAN)} of the "
            f"middle of its range, got {ends} {units.frequency}; use one scene per resonance"
        )


def _decisions(plan: MistunedPlan) -> list[Finding]:
    scene, sectors, order = plan.scene, plan.disk.structure.sectors, plan.engine_order
    deviation = np.array(scene.mistuning)
    spread = f"{100 * deviation.min():+.2f} to {100 * deviation.max():+.2f} %"
    tuned = excited_diameter(order, sectors)
    at = np.linspace(*plan.frequency_range, _FREQUENCIES)
    shown = f"[{', '.join(f'{each.start:g} to {each.end:g} s' for each in scene.windows)}]"
    return [
        Finding(
            "nodal diameters",
            f"0 to {sectors // 2} respond",
            f"blade stiffnesses deviate by {spread}, so the modes are not travelling waves; with "
            f"equal blades engine order {order} excites nodal diameter {tuned} alone",
        ),
        Finding(
            "amplitudes",
            f"{sectors} of each family",
            "each mode of the mistuned disk has its own frequency, and each blade its own "
            "amplitude",
        ),
        Finding(
            "contacts",
            "one friction table per contact of a sector",
            "over the amplitude of the contact, with its own response to higher harmonics",
        ),
        Finding(
            "fast motion",
            f"DOF {plan.dof} of every blade in {shown}" if scene.windows else "not reconstructed",
            "[[elastic]] windows" if scene.windows else "the scene has no [[elastic]] window",
        ),
        *resonance_findings(plan.disk.internal_resonance(order, at)),
    ]
