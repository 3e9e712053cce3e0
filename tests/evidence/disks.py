"""Drawn bladed disks: travelling waves and mistuned disks beside the ring of all sectors."""

from dataclasses import dataclass

import numpy as np
from cyclic.ring import in_wave, ring, steady_wave

from evidence.answers import Answer, limited
from slipmode import rom

SECTORS = 6
TOLERANCE = 1e-3  # of waves and of mistuned disks


@dataclass(frozen=True)
class DiskCase:
    """A lumped disk of 6 sectors near the resonance of a nodal diameter."""

    name: str
    disk: rom.CyclicStructure
    law: rom.Jenkins
    diameter: int
    part: float  # of the natural frequency
    force: np.ndarray
    deviation: np.ndarray


def disk(seed: int) -> DiskCase:
    """Return the disk of a seed: weak (2e4 N/m) to strong (4e5 N/m) contacts between blades."""
    rng = np.random.default_rng([61, seed])
    k, stiffness = (
        int(rng.choice([-2, -1, 1, 2, 3])),
        float(np.exp(rng.uniform(*np.log([2e4, 4e5])))),
    )
    size = float(np.exp(rng.uniform(*np.log([3.0, 20.0]))))
    phase = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi))
    deviation = 0.03 * rng.standard_normal(SECTORS)
    name = f"{seed}: nodal diameter {k}, {stiffness:.3g} N/m, {size:.3g} N"
    force = np.array([0.0, 0.3 * size, size * phase])
    part, law = rng.uniform(0.985, 1.0), rom.Jenkins(1.0, stiffness)
    # the second family is away from three times the first one
    made = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))
    return DiskCase(name, made, law, k, part, force, deviation)


def wave(given: DiskCase) -> list[Answer]:
    """Amplitude of a travelling wave."""
    found = rom.travelling_wave(given.disk, given.law, given.diameter)
    omega = given.part * found.frequency
    (state,) = limited(lambda: found.steady_states(omega, given.force, TOLERANCE))
    system = ring(SECTORS, given.law, tip=4e6)
    c, own = steady_wave(system, given.diameter, omega, given.force, 1e-6, 2048)
    a, largest = in_wave(found.shape, given.diameter, c), np.abs(c).max()
    size = abs(a)
    return [Answer("a", abs(state.amplitude - a) / size, state.error / size, own / largest)]


def mistuned(given: DiskCase) -> list[Answer]:
    """Displacement of the blade that is worst, relative to the largest one."""
    natural = rom.travelling_wave(given.disk, given.law, given.diameter).frequency
    omega = given.part * natural
    disks = rom.MistunedDisk(given.disk, given.law, given.deviation, 1e5)
    found = limited(lambda: disks.response([omega], given.diameter, given.force)).displacement
    system = ring(SECTORS, given.law, tip=4e6, deviation=given.deviation)
    c, own = steady_wave(system, given.diameter, omega, given.force)
    size = np.abs(c).max()
    return [Answer("worst DOF", np.abs(found.ravel() - c).max() / size, TOLERANCE, own / size)]
