"""The travelling waves of a scene with sectors: their modes, their forces and their models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from slipmode.rom import CyclicStructure, Model, TravellingWave, travelling_wave
from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic import SectorWaves, cached_waves, reduced_waves
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.validity import Finding
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.sections import Scene


@frozen
class Waves:
    """One or two travelling waves, and the excitations that hold them steady.

    Attributes
    ----------
    structure : CyclicStructure
    law : Elastic
        Of the contacts of a sector.
    numbers : tuple of (int, int)
        Nodal diameter and mode of each wave.
    force : tuple of (n_s,) ndarray
        Force on the free DOFs of every sector per unit of the scripted amplitude; 0 of a wave
        that is not forced.
    frequency : tuple of float, optional
        Carriers [rad/s]. Default: the natural frequencies.
    """

    structure: CyclicStructure
    law: Elastic
    numbers: tuple[tuple[int, int], ...]
    force: tuple[Floats, ...]
    frequency: tuple[float, ...] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone, for other processes: modes are computed again there."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def at_carriers(self, frequency: Sequence[float]) -> Self:
        """Return the same waves with other carriers [rad/s]."""
        found = replace(self, frequency=tuple(frequency))
        found.__dict__["waves"] = self.waves  # they do not depend on the carriers
        return found

    @cached_property
    def waves(self) -> tuple[TravellingWave, ...]:
        """The waves."""
        return tuple(travelling_wave(self.structure, self.law, *each) for each in self.numbers)

    @cached_property
    def reduced(self) -> Reduced:
        """The waves as modes without contacts, whose DOFs are the free DOFs of a sector."""
        return reduced_waves(self.sector.carriers)

    @cached_property
    def sector(self) -> SectorWaves:
        """The waves under their forces, and the contacts of a sector."""
        frequency = self.frequency or [each.frequency for each in self.waves]
        carriers = (
            wave.carrier(force if force.any() else None, omega)
            for wave, force, omega in zip(self.waves, self.force, frequency, strict=True)
        )
        return SectorWaves(tuple(carriers))

    @property
    def patterns(self) -> tuple[Floats, ...]:
        """Forces on one DOF each, which do the same work as `force` on the modes of `reduced`.

        Those modes have the sizes of the shapes alone.
        """
        found = []
        for carrier, force in zip(self.sector.carriers, self.force, strict=True):
            size = np.abs(carrier.mode_shape)
            at = int(np.argmax(size * np.abs(force)))
            pattern = np.zeros(force.size)
            pattern[at] = abs(carrier.modal_force) / size[at]
            found.append(pattern)
        return tuple(found)

    def model(self, amplitude: Floats, tolerance: float) -> tuple[Model, bool]:
        """Return the model up to amplitudes (modes,) [kg^1/2 m], and whether it was cached."""
        return cached_waves(self.sector.carriers, amplitude.tolist(), tolerance)


def waves_of(
    scene: Scene, modes: tuple[Mode, ...], structure: CyclicStructure, law: Elastic
) -> Waves:
    """Return the waves of some modes of a scene.

    Raises SlipmodeError, naming the key, if there is no such mode, or a force does no work on it.
    """
    diameters = dict(zip(scene.modes.numbers, scene.modes.nodal_diameters or (), strict=True))
    numbers = tuple((diameters[mode], scene.modes.numbers[mode]) for mode in modes)
    size = structure.free_dofs.size
    force = tuple(
        scene.forcing[mode].vector(size) if mode in scene.forcing else np.zeros(size)
        for mode in modes
    )
    found = Waves(structure, law, numbers, force)
    try:
        waves = found.waves
    except SlipmodeError as refusal:
        of_mode, _, allowed = str(refusal).partition("mode: ")
        if of_mode:
            raise SlipmodeError(f"structure: {refusal}") from None
        raise SlipmodeError(f"modes: {allowed}; modes of a nodal diameter count from 0") from None
    for mode, wave, pattern in zip(modes, waves, force, strict=True):
        if pattern.any():
            try:
                wave.carrier(pattern, None)
            except SlipmodeError as refusal:
                said = str(refusal).removeprefix("force: ")
                raise SlipmodeError(
                    f"forcing.{mode}: {said}; choose another DOF or vector"
                ) from None
    return found


def wave_decisions(scene: Scene, modes: tuple[Mode, ...], waves: Waves) -> list[Finding]:
    """Return which nodal diameter and mode each engine order excites, and why."""
    found = []
    for name, wave in zip(modes, waves.waves, strict=True):
        k, sectors = wave.nodal_diameter, waves.structure.sectors
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
