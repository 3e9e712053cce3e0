"""Structures beyond the paper's: larger, with more contacts, damped otherwise."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from slipmode import rom
from slipmode.rom import Structure
from slipmode.rom.arrays import Floats

_BETA = 0.01
_JOINT = 150.0  # stiffness of a joint with friction, in springs of a chain as long as that


def damped_between_modes() -> Structure:
    """The paper's structure with dashpots that no multiple of K or M gives."""
    base = rom.two_mass(beta=_BETA)
    dashpots = np.zeros((4, 4))
    dashpots[:2, :2] = [[0.012, -0.008], [-0.008, 0.02]]
    dashpots[2, 2] = 0.1
    return Structure(
        base.mass, base.stiffness, np.asarray(base.damping) + dashpots, contact=(2, 3)
    )


def six_dofs() -> Structure:
    """Three masses, each held by a contact; neighbouring contacts are coupled."""
    mass = np.diag([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
    held = np.array([1.0, 1.7**2, 2.6**2])
    to_ground, between = np.array([20.0, 40.0, 60.0]), 5.0
    contacts = np.diag(held + to_ground) + between * (
        np.diag([1.0, 2.0, 1.0]) - np.eye(3, k=1) - np.eye(3, k=-1)
    )
    stiffness = np.block([[np.diag(held), -np.diag(held)], [-np.diag(held), contacts]])
    return Structure(mass, stiffness, _BETA, contact=(3, 4, 5))


class Chain:
    """Masses on an elastic foundation, joined by springs, with friction in three of the joints.

    Stuck, its first two natural frequencies are about 1 and 1.7 rad/s. Where a joint slips, its
    own spring still holds it, so that contacts move little against the modes.

    Parameters
    ----------
    masses : int
    """

    def __init__(self, masses: int) -> None:
        self.masses = masses
        self.joints = [round(masses * share) for share in (0.15, 0.45, 0.8)]

    @cached_property
    def _matrices(self) -> tuple[Floats, Floats, Floats]:
        """Mass, stiffness and contact directions: each modal mass is about 1."""
        n = self.masses
        mass = 2.0 / n
        spring = 0.63 * mass * (n + 1) ** 2 / np.pi**2
        neighbours = np.eye(n, k=1) + np.eye(n, k=-1)
        stiffness = (2.0 * spring + 0.37 * mass) * np.eye(n) - spring * neighbours
        directions = np.zeros((n, len(self.joints)))
        for contact, joint in enumerate(self.joints):
            directions[joint, contact], directions[joint + 1, contact] = -1.0, 1.0
        stiffness += (_JOINT / n - 1.0) * spring * directions @ directions.T
        return mass * np.eye(n), stiffness, directions

    def structure(self, modal_damping: bool = True) -> Structure:
        """The chain; its damping proportional to stiffness, or with dashpots of uneven size."""
        mass, stiffness, directions = self._matrices
        if modal_damping:
            return Structure(mass, stiffness, _BETA, contact=directions)
        uneven = np.linspace(0.0, 0.02, self.masses)
        damping = _BETA * stiffness + np.asarray(mass) * uneven
        return Structure(mass, stiffness, damping, contact=directions)

    @cached_property
    def _reduced(self) -> rom.Reduced:
        return rom.reduce(self.structure())

    @property
    def limit(self) -> list[float]:
        """Friction limits: each contact begins to slip at amplitude 1 of the mode that acts
        on it with the larger force.
        """
        force = np.abs(self._reduced.spring).max(axis=0)
        return [float(value) for value in 2.0 * force]

    @property
    def alpha(self) -> float:
        """A fifth of the sliding speeds of the weakest contact."""
        return float(0.2 * (np.array(self.limit) / np.diag(self._reduced.stiffness)).min())

    @property
    def observed(self) -> tuple[int, int]:
        """Where each mode moves most."""
        peaks = np.abs(self._reduced.mode_shapes).argmax(axis=0)
        return int(peaks[0]), int(peaks[1])

    def frequencies(self, detuning: tuple[float, float]) -> tuple[float, ...]:
        """Forcing frequencies, as fractions of the natural ones [rad/s]."""
        return tuple(float(value) for value in self._reduced.frequency * detuning)

    def modal_forces(self, amplitude: tuple[float, float]) -> tuple[Floats, Floats]:
        """Forces in the shape of each mode, with these modal amplitudes."""
        shape = self._matrices[0] @ self._reduced.mode_shapes
        return amplitude[0] * shape[:, 0], amplitude[1] * shape[:, 1]

    def point_forces(self, amplitude: tuple[float, float]) -> tuple[dict[int, float], ...]:
        """Forces of these modal amplitudes, each on the one DOF where its mode moves most."""
        shapes = self._reduced.mode_shapes
        return tuple(
            {dof: float(amplitude[mode] / abs(shapes[dof, mode]))}
            for mode, dof in enumerate(self.observed)
        )
