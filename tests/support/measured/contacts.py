"""Chains with contacts, and their backbones with noise, by friction tables and in full order."""

import numpy as np

from slipmode import rom
from slipmode.rom import full

SENSOR = 3
JENKINS = {"joint": (rom.Jenkins(1.0, 1e4), [0, 1]), "wall": (rom.Jenkins(0.5, 2e4), [2])}
IWAN = {"joint": (rom.Iwan(2.0, 2e4, -0.3, 1.0), [0, 1]), "wall": (rom.Jenkins(0.5, 2e4), [2])}


def chain(seed):
    """Eight masses between walls; contacts beside two springs, and to the ground."""
    rng = np.random.default_rng(seed)
    k, m = 1e6 * rng.uniform(0.7, 1.4, 9), rng.uniform(0.7, 1.4, 8)
    K = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    W = np.zeros((8, 3))
    W[[2, 3], 0], W[[5, 4], 1], W[6, 2] = (1, -1), (1, -1), 1
    return rom.Structure(np.diag(m), K, 1e-6, contact=W)


def contacts(groups):
    return rom.Contacts(list(groups.values()))


def tabulated(structure, groups, mode=0, largest=4e-4, shift=0.002):
    """The model of one mode, with its carrier where slip shifts the frequency to."""
    law = contacts(groups)
    reduced = rom.reduce(structure, (mode,), law=law)
    reduced = reduced.at_carrier([(1.0 - shift) * reduced.frequency[0]])
    return rom.tabulate(reduced, law, (largest,), detuning=True)


def backbone(model, noise, seed, mode=0, points=20):
    """Points of steady vibration by a table; noise relative to the damping."""
    rng = np.random.default_rng(seed)
    largest = model.table.amplitude_range[0]
    found = rom.backbone(model, amplitude=np.geomspace(2e-2, 0.95, points) * largest)
    zeta, omega = found.damping, found.frequency
    return rom.IdentifiedBackbone(
        mode=mode,
        amplitude=found.displacement(SENSOR),
        frequency=omega * (1.0 + noise * zeta * rng.standard_normal(points)),
        damping=zeta * (1.0 + noise * rng.standard_normal(points)),
        frequency_deviation=noise * zeta * omega,
        damping_deviation=noise * zeta,
        unit="m",
        steady=True,
    )


def free_decay(structure, groups, noise, seed, start=4e-4, points=20):
    """Points of a free decay from the shape of mode 0, integrated in full order."""
    rng, law = np.random.default_rng(seed), contacts(groups)
    reduced = rom.reduce(structure, (0,), law=law)
    nothing = full.Excitation.harmonic(structure, [np.zeros(8)], reduced.frequency)
    initial = full.State(0.0, 2.0 * start * reduced.mode_shapes[:, 0], np.zeros(8))
    motion = full.integrate(
        structure, law, nothing, np.arange(0.0, 8.0, 1e-3), step=5e-5, outputs=[SENSOR],
        start=initial,
    )  # fmt: skip
    time, x, carrier = motion.time, motion.displacement[:, 0], reduced.frequency[0]
    instants = np.arange(0.1, 7.9, 0.005)
    around = np.exp(-0.5 * ((time - instants[:, np.newaxis]) / 0.02) ** 2)  # Gaussian windows
    z = 2.0 * around @ (x * np.exp(-1j * carrier * time)) / around.sum(axis=1)
    rate = np.gradient(np.unwrap(np.angle(z)) - 1j * np.log(np.abs(z)), instants)  # omega, delta
    size = np.geomspace(0.95, 0.1, points) * np.abs(z).max()
    at = np.abs(np.abs(z) - size[:, np.newaxis]).argmin(axis=1)
    omega = carrier + rate[at].real
    zeta = rate[at].imag / omega
    return rom.IdentifiedBackbone(
        mode=0,
        amplitude=np.abs(z[at]),
        frequency=omega * (1.0 + noise * zeta * rng.standard_normal(points)),
        damping=zeta * (1.0 + noise * rng.standard_normal(points)),
        frequency_deviation=noise * zeta * omega,
        damping_deviation=noise * zeta,
        unit="m",
    )
