"""The travelling waves of a scene with sectors: their modes, their forces and their models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self, cast

import numpy as np

from slipmode.rom import CyclicStructure, Model, travelling_wave
from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.wave.wave_motion import SectorWaves
from slipmode.rom.cyclic.wave.wave_problem import Carrier
from slipmode.rom.cyclic.wave.wave_table import cached_waves, reduced_waves
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.tabulation import extended_range
from slipmode.rom.validity import Finding
from slipmode.runner.plan.excited import Excited, initial_amplitudes
from slipmode.runner.recording import channels
from slipmode.runner.recording.channels import Channel, Mode
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene


@frozen
class ExcitedWaves(Excited):
    """The waves of a scene with sectors; `reduced` and `law` have no contacts."""

    kind: ClassVar[str] = "waves"

    sector: SectorWaves  # The waves under their forces, and the contacts of a sector

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what makes the same waves in other processes; modes are computed again there."""
        carriers = [
            (each.wave.nodal_diameter, each.wave.mode, each.frequency, each.force)
            for each in self.sector.carriers
        ]
        alike = self.force_patterns, self.initial, self.amplitude
        return _made_again, (self.disk, self.contacts[1], carriers, self.modes, *alike)

    @property
    def disk(self) -> CyclicStructure:
        """Disk of the waves."""
        return self.sector.carriers[0].wave.structure

    @property
    def contacts(self) -> tuple[Reduced, Elastic]:
        """Contacts of a sector, and their law."""
        return self.sector.problem.reduced, self.sector.carriers[0].wave.law

    def channels(self, scene: Scene) -> list[Channel]:
        """See `Moving`."""
        listed = super().channels(scene)
        if scene.windows:
            listed.append(channels.disk(self.disk.sectors, self.shown_dof(scene)))
        return listed

    def shown_dof(self, scene: Scene) -> int:
        """Return the first DOF of output.elastic; without it the DOF that moves most."""
        chosen, shape = scene.output.elastic, self.sector.carriers[0].wave.shape
        return chosen[0] if chosen else int(np.abs(shape).argmax())

    def at_carriers(self, frequency: Sequence[float]) -> Self:
        """Return the same waves with carriers of these frequencies [rad/s]."""
        each = zip(self.sector.carriers, frequency, strict=True)
        carriers = tuple(replace(carrier, frequency=omega) for carrier, omega in each)
        return replace(self, reduced=reduced_waves(carriers), sector=SectorWaves(carriers))

    def combinations(self, schedule: Schedule) -> tuple[CombinationResonance, ...]:
        """Return none: the friction table includes all harmonics."""
        return ()

    def other_modes(self) -> Finding:
        """Return how the modes of other nodal diameters are modelled."""
        reason = "harmonics of the contacts excite the modes of their nodal diameters"
        return Finding("other modes", "in the friction table", reason)

    def model(
        self, amplitude: Sequence[float], tolerance: float, **options: Any
    ) -> tuple[Model, bool]:
        """See `Excited.model`; of the options, waves need the headroom alone."""
        ends = extended_range(amplitude, options.get("headroom", 1.0))
        return cached_waves(self.sector.carriers, ends.tolist(), tolerance)


def _made_again(
    disk: CyclicStructure, law: Elastic, given: list[Any], modes: tuple[Mode, ...], *alike: Any
) -> ExcitedWaves:
    """Return waves from what `ExcitedWaves.__reduce__` returns."""
    carriers = tuple(Carrier(travelling_wave(disk, law, k, m), *rest) for k, m, *rest in given)
    reduced, (patterns, initial, amplitude) = reduced_waves(carriers), alike
    sector = SectorWaves(carriers)
    return ExcitedWaves(modes, reduced, NoContacts(), patterns, initial, amplitude, sector)


def excite_waves(scene: Scene, modes: tuple[Mode, ...]) -> tuple[Scene, ExcitedWaves]:
    """Return the located scene, and its waves under their forces."""
    assert scene.disk is not None
    disk = scene.disk.build_disk()
    scene, structure = scene.located(disk.labels), disk.structure
    law = cast(Elastic, law_of(scene, structure.n_contacts))
    carriers = tuple(_carrier(scene, mode, structure, law) for mode in modes)
    reduced, initial = reduced_waves(carriers), initial_amplitudes(scene, modes)
    patterns, sector = tuple(map(_pattern, carriers)), SectorWaves(carriers)
    return scene, ExcitedWaves(modes, reduced, NoContacts(), patterns, initial, initial, sector)


def _carrier(scene: Scene, mode: Mode, structure: CyclicStructure, law: Elastic) -> Carrier:
    """Return the wave of a mode of a scene, at its natural frequency, under its force.

    Raises SlipmodeError, naming the key, if there is no such mode, or its force does no work.
    """
    numbers = scene.modes.numbers
    diameter = dict(zip(numbers, scene.modes.nodal_diameters or (), strict=True))[mode]
    try:
        wave = travelling_wave(structure, law, diameter, numbers[mode])
    except SlipmodeError as refusal:
        of_mode, _, allowed = str(refusal).partition("mode: ")
        if of_mode:
            raise SlipmodeError(f"structure: {refusal}") from None
        raise SlipmodeError(f"modes: {allowed}; modes of a nodal diameter count from 0") from None
    force = None
    if mode in scene.forcing:
        force = scene.forcing[mode].vector(structure.free_dofs.size)
    try:
        return wave.carrier(force if force is not None and force.any() else None, wave.frequency)
    except SlipmodeError as refusal:
        said = str(refusal).removeprefix("force: ")
        raise SlipmodeError(f"forcing.{mode}: {said}; choose another DOF or vector") from None


def _pattern(carrier: Carrier) -> Floats:
    """Return a force on one DOF that does the same work as the force on a wave.

    It acts on the modes of `reduced_waves`, which have the sizes of the shapes alone.
    """
    size = np.abs(carrier.mode_shape)
    at = int(np.argmax(size * np.abs(carrier.force)))
    pattern = np.zeros(size.size)
    pattern[at] = abs(carrier.modal_force) / size[at]
    return pattern


def wave_decisions(scene: Scene, excited: ExcitedWaves) -> list[Finding]:
    """Return which nodal diameter and mode each engine order excites, and why."""
    found = []
    for name, carrier in zip(excited.modes, excited.sector.carriers, strict=True):
        wave, sectors = carrier.wave, excited.disk.sectors
        k = wave.nodal_diameter
        omega = scene.units.of_frequency(wave.frequency)
        choice = f"nodal diameter {k}, mode {wave.mode}"
        direction = "backward" if k < 0 else "forward"
        reason = f"natural frequency {omega:.6g} {scene.units.frequency}"
        order = scene.forcing[name].engine_order if name in scene.forcing else None
        if order is not None and order == k:
            reason += f"; engine order {order} excites it"
        elif order is not None:
            turns = round((order - k) / sectors)
            reason += (
                f"; engine order {order} = {k} + {turns} x {sectors} sectors is aliased to it"
            )
        found.append(Finding(f"wave {name}", choice, f"{reason}; it travels {direction}"))
    return found
