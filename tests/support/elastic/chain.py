"""Lumped structures that nobody chose: plane trusses of 4 to 8 masses with elastic contacts.

Each seed draws masses, springs, 1 to 6 inclined contacts to the ground, friction and two modes.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from slipmode import rom

LAWS = ("Jenkins", "Iwan", "frictional")  # in turn


@dataclass(frozen=True)
class Chain:
    """One structure with two separated modes."""

    structure: rom.Structure
    law: rom.Jenkins | rom.Iwan | rom.FrictionalContact
    modes: tuple[int, ...]
    frequency: tuple[float, ...]  # of the forces [rad/s]
    amplitude_range: tuple[float, ...]


def chain(seed: int) -> Chain:
    """Return the chain of a seed: of what it draws, the first with two separated modes."""
    rng = np.random.default_rng([35, seed])
    while True:
        drawn = _drawn(LAWS[seed % 3], rng)
        if drawn is not None:
            return drawn


def _drawn(kind: str, rng: np.random.Generator) -> Chain | None:
    masses = int(rng.integers(4, 9))
    stiffness = np.zeros((2 * masses, 2 * masses))
    for mass in range(masses):
        # two inclined springs to the mass before, or to the ground
        for size, angle in (
            (rng.uniform(20.0, 60.0), rng.uniform(-0.6, 0.6)),
            (rng.uniform(5.0, 40.0), rng.uniform(0.8, 2.2)),
        ):
            spring = np.zeros(2 * masses)
            spring[2 * mass : 2 * mass + 2] = np.cos(angle), np.sin(angle)
            if mass:
                spring[2 * mass - 2 : 2 * mass] = -np.cos(angle), -np.sin(angle)
            stiffness += size * np.outer(spring, spring)
    inertia = np.diag(np.repeat(rng.uniform(0.5, 2.0, masses), 2))
    count = min(int(rng.integers(1, 7)), masses)
    directions = []
    for mass in np.sort(rng.choice(masses, count, replace=False)):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        for turned in (angle, angle + 0.5 * np.pi)[: 2 if kind == "frictional" else 1]:
            direction = np.zeros(2 * masses)
            direction[2 * mass : 2 * mass + 2] = np.cos(turned), np.sin(turned)
            directions.append(direction)
    W = np.array(directions).T
    tangential = float(np.exp(rng.uniform(np.log(0.3), np.log(6.0))))
    normal = rng.uniform(0.5, 2.0) * tangential
    reference = np.full(W.shape[1], tangential)
    if kind == "frictional":
        reference[1::2] = normal
    squares, shapes = scipy.linalg.eigh(stiffness + (W * reference) @ W.T, inertia)
    omega = np.sqrt(squares)
    ratio = np.exp(rng.uniform(np.log(1e-3), np.log(1e-2)))
    damping = inertia @ (shapes * (2.0 * ratio * omega)) @ shapes.T @ inertia
    moved = np.abs(W.T @ shapes).max(axis=0)
    separated = [
        mode
        for mode in range(4)
        if np.abs(np.delete(omega, mode) / omega[mode] - 1.0).min() > 0.08
        and moved[mode] > 0.05 * moved.max()
    ]
    if len(separated) < 2:
        return None
    modes = tuple(sorted(int(mode) for mode in rng.choice(separated, 2, replace=False)))
    chosen = list(modes)
    reached = np.exp(rng.uniform(np.log(0.3), 0.0, 2)) / moved[chosen]
    limit = tangential * np.exp(rng.uniform(np.log(0.15), np.log(2.0)))
    law: rom.Jenkins | rom.Iwan | rom.FrictionalContact = rom.Jenkins(limit, tangential)
    if kind == "Iwan":
        law = rom.Iwan(4.0 * limit, tangential, chi=-0.5, beta=0.3, sliders=6)
    elif kind == "frictional":
        mu = rng.uniform(0.2, 0.6)
        law = rom.FrictionalContact(mu, 0.5 * limit / mu, tangential, normal)
    return Chain(
        rom.Structure(inertia, stiffness, 0.5 * (damping + damping.T), contact=W),
        law,
        modes,
        tuple(omega[chosen] * (1.0 + rng.uniform(-0.02, 0.01, 2))),
        tuple(1.2 * reached),
    )
