"""The paper's numerical example: Table 1, two forces, and its motion by each model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER

NATURAL_FREQUENCIES = (1.0, 1.7)  # [rad/s], with bonded contacts
FORCE = (0.15, 0.25)  # [N], Table 1
STRONG_FORCE = (0.5, 0.75)  # [N], Fig. 8
ALPHA, BETA = 0.02, 0.0109  # [m/s], [s]: not stated; with these the peaks are nearest


@dataclass(frozen=True, eq=False)
class Signals:
    """Fast motion by one of the models: time (n,) [s], and signals (n, 2).

    Displacements x_e1, x_e2 and x_c1, x_c2 [m], and the friction forces [N].
    """

    time: Floats
    elastic: Floats
    contact: Floats
    friction: Floats


@dataclass(frozen=True)
class Case:
    """The structure of Table 1 under two harmonic forces."""

    alpha: float = ALPHA
    beta: float = BETA
    force: tuple[float, float] = FORCE  # on x_e1 and x_e2
    detuning: tuple[float, float] = (-0.0175, -0.046)  # [rad/s]; near both peaks
    largest: tuple[float, float] = (5.0, 3.0)  # range of the friction tables [kg^1/2 m]
    tolerance: float = 1e-3  # of the tables
    contact_mass: float = 0.01  # m_c [kg]

    @cached_property
    def structure(self) -> rom.Structure:
        """The lumped model of Fig. 2."""
        return rom.two_mass(beta=self.beta, contact_mass=self.contact_mass)

    @property
    def law(self) -> rom.Tanh:
        """Eq. (28) with mu N = 2."""
        return rom.Tanh(limit=2.0, alpha=self.alpha)

    @cached_property
    def paper(self) -> rom.Model:
        """The paper's own reduced model."""
        reduced = rom.reduce(self.structure, formulation="paper")
        return rom.tabulate(reduced, self.law, self.largest, self.tolerance)

    @cached_property
    def consistent(self) -> rom.Model:
        """The model whose carrier is the forcing, with residual flexibility."""
        arguments = rom.reduce(self.structure), self.law, self.largest, self.tolerance
        return rom.tabulate(*arguments, harmonics=RESPONSE_ORDER)

    @property
    def frequency(self) -> Floats:
        """Forcing frequencies (2,) [rad/s]."""
        return np.asarray(NATURAL_FREQUENCIES) + self.detuning

    @property
    def period(self) -> float:
        """Period of the slower force [s]."""
        return float(2 * np.pi / self.frequency[0])

    @property
    def contact_stiffness(self) -> Floats:
        """K_xx of Eq. (13), (2, 2) [N/m]."""
        return self.paper.reduced.stiffness

    def forces(self, forced: str = "AB") -> tuple[dict[int, float], dict[int, float]]:
        """Return {DOF: amplitude} per mode; 0 for modes that are not in `forced`."""
        a, b = (f if mode in forced else 0.0 for mode, f in zip("AB", self.force, strict=True))
        return {0: a}, {1: b}

    def excitation(self, forced: str = "AB") -> full.Excitation:
        """Return the forces, switched on at t = 0."""
        return full.Excitation.harmonic(self.structure, self.forces(forced), self.frequency)

    def by_full_order(self, times: Floats, forced: str = "AB") -> Signals:
        """Return the motion from rest, all degrees of freedom integrated in time."""
        m = full.integrate(self.structure, self.law, self.excitation(forced), times)
        return Signals(m.time, m.displacement[:, :2], m.contact_displacement, m.contact_force)

    def steady_by_full_order(self) -> Complexes:
        """Return the amplitudes of the carriers, a_A in x_e1 and a_B in x_e2, (2,) [m]."""
        steady = full.steady_amplitude(
            self.structure, self.law, self.excitation(), outputs=(0, 1), tolerance=1e-4
        )
        return np.diagonal(steady.amplitude)

    def by_model(self, model: rom.Model, times: Floats) -> Signals:
        """Return the steady motion by a reduced model, in phase with the forces."""
        end, steady = float(times[-1]), rom.steady(model, self.frequency, self.forces())
        modal = [model.reduced.modal_force(j, force) for j, force in enumerate(self.forces())]
        trajectory = rom.SlowTrajectory(
            time=np.array([0.0, end]),
            amplitude=np.tile(steady, (2, 1)),
            angle=np.outer([0.0, end], self.frequency),
            frequency=self.frequency[np.newaxis],
            frequency_rate=np.zeros((1, 2)),
            force=np.array([modal], dtype=complex),
            force_rate=np.zeros((1, 2), dtype=complex),
        )
        motion = rom.reconstruct(model, trajectory, times)
        return Signals(times, motion.elastic(model, (0, 1)), motion.displacement, motion.force)

    def force_sum(self, signals: Signals) -> Floats:
        """Return elastic and friction force on the contacts, left side of Eq. (29), (n, 2) [N]."""
        return np.asarray(signals.contact @ self.contact_stiffness + signals.friction)
