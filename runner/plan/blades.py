"""The plan of a mistuned disk: the amplitudes of all its modes, without a table."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import ClassVar, cast

import numpy as np

from slipmode.rom import MistunedDisk, SlipmodeError, ToneFlow, excited_diameter
from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.mistuned.internal_resonance import resonance_findings
from slipmode.rom.errors import ValidityWarning, naming
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.validity import Finding
from slipmode.runner.plan.checks import checked_schedule
from slipmode.runner.plan.plan import Plan, recording_decisions
from slipmode.runner.recording import channels
from slipmode.runner.recording.channels import Channel, Mode, Moved
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.sections import Scene

# Highest frequency of modes that respond with their inertia, relative to the forcing frequency.
# Higher modes follow statically (`MistunedDisk`).
_HIGHEST = 10.0
_FREQUENCIES = 64  # at which internal resonances are sought


@frozen
class ExcitedBlades:
    """Hold a mistuned disk with all blades, and the force on them.

    Attributes
    ----------
    disk : MistunedDisk
        Reduced disk.
    force : (n_s,) ndarray
        Force on the free DOFs of every sector per unit of `forcing.A.amplitude` [-].
    engine_order : int
        Engine order of the force.
    dof : int
        DOF of every blade that is recorded: from [output], or where the force is largest.
    frequency : (float, float)
        Smallest and largest forcing frequency [rad/s].
    """

    disk: MistunedDisk
    force: Floats
    engine_order: int
    dof: int
    frequency: tuple[float, float]

    kind: ClassVar[str] = "blades"

    modes: tuple[Mode, ...] = ("A",)

    @property
    def natural(self) -> dict[str, float]:
        """See `Moving`."""
        return {"A": 0.0}

    @property
    def n_dofs(self) -> int:
        """See `Moving`."""
        return self.disk.structure.free_dofs.size

    def summary(self, scene: Scene) -> str:
        """See `Moving`."""
        return f"{self.disk.structure!r}, mistuned, engine order {self.engine_order}"

    def channels(self, scene: Scene) -> list[Channel]:
        """See `Moving`."""
        sectors = self.disk.structure.sectors
        listed = [channels.blades(sectors, self.dof), channels.forcing(self.modes)]
        return listed + ([channels.disk(sectors, self.dof)] if scene.windows else [])

    def moved(self, amplitude: Sequence[float] = ()) -> dict[str, Moved]:
        """See `Moving`: recordings have displacements of blades, not amplitudes of modes."""
        return {}

    def flow(self, tolerance: float) -> ToneFlow:
        """Return the disk at rest, with the middle of the frequencies as reference frequency."""
        middle = 0.5 * sum(self.frequency)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)  # the plan has this finding
            return self.disk.flow(middle, self.engine_order, self.force, tolerance=tolerance)


# Plan of a mistuned disk.
BladesPlan = Plan[ExcitedBlades]


def plan_blades(scene: Scene) -> BladesPlan:
    """Return the plan of a scene with a mistuned disk."""
    assert scene.disk is not None  # `read_scene` refuses mistuning of other structures
    built = scene.disk.build_disk()
    scene, structure = scene.located(built.labels), built.structure
    law = cast(Elastic, law_of(scene, structure.n_contacts))
    if not law.elements(structure.n_contacts).odd:
        raise SlipmodeError(
            'contacts.law: must be "jenkins", "iwan" or "sliders" with [mistuning], because '
            "contacts of mistuned disks do not lift off"
        )
    forcing = scene.forcing["A"]
    force, order = forcing.vector(structure.free_dofs.size), cast(int, forcing.engine_order)
    low, high = forcing.frequency.range(0.0, scene.run.duration)
    with naming("structure"):
        disk = MistunedDisk(structure, law, scene.mistuning, _HIGHEST * high)
    dof = scene.output.elastic[0] if scene.output.elastic else int(np.abs(force).argmax())
    excited = ExcitedBlades(disk, force, order, dof, (low, high))
    schedule = checked_schedule(scene, excited)
    if high - low > SPAN * (high + low):
        units = scene.units
        ends = " to ".join(f"{units.of_frequency(each):.6g}" for each in (low, high))
        raise SlipmodeError(
            f"forcing.A.engine_order * rotor_speed: must stay within {percentage(SPAN)} of the "
            f"middle of its range, got {ends} {units.frequency}; use one scene per resonance"
        )
    sectors, deviation = structure.sectors, 100 * np.array(scene.mistuning)
    tuned, at = excited_diameter(order, sectors), np.linspace(low, high, _FREQUENCIES)
    modes = (
        f"blade stiffnesses deviate by {deviation.min():+.2f} to {deviation.max():+.2f} %, so the "
        f"modes are not travelling waves; with equal blades engine order {order} excites nodal "
        f"diameter {tuned} alone"
    )
    each = "each mode of the mistuned disk has its own frequency, and each blade its own amplitude"
    tables = "over the amplitude of the contact, with its own response to higher harmonics"
    return Plan(scene, schedule, excited).with_decisions(
        Finding("nodal diameters", f"0 to {sectors // 2} respond", modes),
        Finding("amplitudes", f"{sectors} of each family", each),
        Finding("contacts", "one friction table per contact of a sector", tables),
        *recording_decisions(scene),
        *resonance_findings(disk.internal_resonance(order, at)),
    )
