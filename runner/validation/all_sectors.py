"""The motion of all sectors of a bladed disk, integrated at full order."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.rom import Contacts, CyclicStructure
from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.wave.wave_motion import phase_factor
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full import FullMotion, State, integrate
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.structure.structure import Structure
from slipmode.runner.plan.blades import BladesPlan
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.waves import ExcitedWaves
from slipmode.runner.transients.full_order import excitation_of


def check_one_wave(plan: ModesPlan) -> None:
    """Refuse two waves: forces of two patterns in two phases each."""
    if len(plan.excited.modes) > 1:
        raise SlipmodeError(
            "forcing.B: must be left out, or [forcing.A], because all sectors are integrated "
            "under one engine order"
        )


def sector_in_full(
    plan: ModesPlan,
    waves: ExcitedWaves,
    annulus: Structure,
    times: Floats,
    steps_per_period: float,
) -> FullMotion:
    """Return the motion of sector 0 among all sectors.

    Its output is the modal displacement of the wave. The energy is not known for one sector.
    """
    disk, (carrier,) = waves.disk, waves.sector.carriers
    wave = carrier.wave
    k, size = wave.nodal_diameter, disk.n_contacts
    pattern = disk.around(carrier.force, k)
    excitation = excitation_of(plan.excited.modes, pattern[np.newaxis], plan.schedule)
    turn = phase_factor(carrier)
    shape = disk.around(wave.shape, k)
    start = 2.0 * shape * turn * plan.excited.initial[0]
    velocity = 1j * excitation.frequency[0, 0] * start
    # of both waves with this shape, forward and backward, if they are not the same one
    weight = (1.0 if 2 * k % disk.sectors == 0 else 2.0) / disk.sectors
    output = weight * np.asarray(annulus.mass @ (turn * shape)).real
    motion = integrate(
        annulus,
        _law_of_all(wave.law, disk),
        excitation,
        times,
        steps_per_period=steps_per_period,
        outputs=output[np.newaxis],
        start=State(0.0, displacement=start.real, velocity=velocity.real),
    )
    return replace(
        motion,
        contact_displacement=motion.contact_displacement[:, :size],
        contact_velocity=motion.contact_velocity[:, :size],
        contact_force=motion.contact_force[:, :size],
        dissipated=np.full_like(motion.dissipated, np.nan),
    )


def blades_in_full(plan: BladesPlan, times: Floats, steps_per_period: float) -> Floats:
    """Return the displacement of the plan's DOF of every blade of a mistuned disk, (n, N) [m]."""
    blades, disk = plan.excited, plan.excited.disk.structure
    annulus = disk.annulus(blades.disk.deviation[0])
    pattern = disk.around(blades.force.astype(complex), blades.engine_order)
    motion = integrate(
        annulus,
        _law_of_all(blades.disk.law, disk),
        excitation_of(("A",), pattern[np.newaxis], plan.schedule),
        times,
        steps_per_period=steps_per_period,
        outputs=range(blades.dof, annulus.n_dofs, disk.free_dofs.size),
    )
    return motion.displacement


def _law_of_all(law: Elastic, disk: CyclicStructure) -> Contacts:
    """Return the contact law of all sectors."""
    size = disk.n_contacts
    whole: Any = (law, range(size))
    groups = law.groups if isinstance(law, Contacts) else [whole]
    return Contacts(
        [
            (each, [j * size + column for column in columns])
            for j in range(disk.sectors)
            for each, columns in groups
        ]
    )
