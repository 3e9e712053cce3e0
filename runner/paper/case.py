"""The paper's numerical example: Table 1, two forces, and its motion by each model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reduction import Formulation

NATURAL_FREQUENCIES = (1.0, 1.7)  # [rad/s], with bonded contacts
FORCE = (0.15, 0.25)  # [N], Table 1
STRONG_FORCE = (0.5, 0.75)  # [N], Fig. 8
ALPHA, BETA = 0.02, 0.0109  # [m/s], [s]: not stated; with these the peaks come nearest


@dataclass(frozen=True, eq=False)
class Signals:
    """Fast motion, by whatever model.

    Attributes
    ----------
    time : (n,) ndarray
        [s]
    elastic : (n, 2) ndarray
        x_e1, x_e2 [m].
    contact, friction : (n, 2) ndarray
        x_c1, x_c2 [m] and the friction forces [N].
    """

    time: Floats
    elastic: Floats
    contact: Floats
    friction: Floats


@dataclass(frozen=True)
class Case:
    """The structure of Table 1 under two harmonic forces.

    Parameters
    ----------
    alpha : float
        Regularisation velocity of the friction law [m/s].
    beta : float
        Stiffness-proportional damping [s].
    force : (float, float)
        Amplitudes of the forces on x_e1 and x_e2 [N].
    detuning : (float, float)
        Forcing frequencies less the natural ones [rad/s]; by default near both peaks.
    largest : (float, float)
        Amplitudes up to which friction is tabulated [kg^1/2 m].
    tolerance : float
        Of the tables.
    contact_mass : float
        m_c [kg].
    """

    alpha: float = ALPHA
    beta: float = BETA
    force: tuple[float, float] = FORCE
    detuning: tuple[float, float] = (-0.0175, -0.046)
    largest: tuple[float, float] = (5.0, 3.0)
    tolerance: float = 1e-3
    contact_mass: float = 0.01

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
        return self._model("paper")

    @cached_property
    def consistent(self) -> rom.Model:
        """The model whose carrier is the forcing, with residual flexibility."""
        return self._model("consistent")

    @property
    def frequency(self) -> Floats:
        """Forcing frequencies (2,) [rad/s]."""
        return np.asarray(NATURAL_FREQUENCIES) + self.detuning

    @property
    def period(self) -> float:
        """Of the slower force [s]."""
        return float(2 * np.pi / self.frequency[0])

    @property
    def contact_stiffness(self) -> Floats:
        """K_xx of Eq. (13), (2, 2) [N/m]."""
        return self.paper.reduced.stiffness

    def forces(self, forced: str = "AB") -> tuple[dict[int, float], dict[int, float]]:
        """{DOF: amplitude} per mode; nothing on a mode that is not in `forced`."""
        a, b = (f if mode in forced else 0.0 for mode, f in zip("AB", self.force, strict=True))
        return {0: a}, {1: b}

    def excitation(self, forced: str = "AB") -> full.Excitation:
        """The forces, switched on at t = 0."""
        return full.Excitation.harmonic(self.structure, self.forces(forced), self.frequency)

    def by_full_order(self, times: Floats, forced: str = "AB") -> Signals:
        """Motion from rest, all degrees of freedom integrated in time."""
        motion = full.integrate(self.structure, self.law, self.excitation(forced), times)
        return Signals(
            *(motion.time, motion.displacement[:, :2]),
            *(motion.contact_displacement, motion.contact_force),
        )

    def steady_by_full_order(self) -> Complexes:
        """Amplitudes of the carriers, a_A in x_e1 and a_B in x_e2, (2,) [m]."""
        steady = full.steady_amplitude(
            self.structure, self.law, self.excitation(), outputs=(0, 1), tolerance=1e-4
        )
        return np.diagonal(steady.amplitude)

    def by_model(self, model: rom.Model, times: Floats) -> Signals:
        """Steady motion by a reduced model, carried by the same angles as the forces."""
        steady = rom.steady(model, self.frequency, self.forces())
        trajectory = _steady_trajectory(model, steady, self, float(times[-1]))
        motion = rom.reconstruct(model, trajectory, times)
        elastic = motion.elastic(model, (0, 1))
        return Signals(times, elastic, motion.displacement, motion.force)

    def force_sum(self, signals: Signals) -> Floats:
        """Elastic and friction force on the contacts, the left side of Eq. (29), (n, 2) [N]."""
        return np.asarray(signals.contact @ self.contact_stiffness + signals.friction)

    def _model(self, formulation: Formulation) -> rom.Model:
        reduced = rom.reduce(self.structure, formulation=formulation)
        return rom.tabulate(
            *(reduced, self.law, self.largest, self.tolerance),
            harmonics=RESPONSE_ORDER if formulation == "consistent" else 0,
        )


def _steady_trajectory(
    model: rom.Model, steady: Complexes, case: Case, end: float
) -> rom.SlowTrajectory:
    """Constant amplitudes from t = 0 to the end."""
    modal = [model.reduced.modal_force(j, force) for j, force in enumerate(case.forces())]
    return rom.SlowTrajectory(
        time=np.array([0.0, end]),
        amplitude=np.tile(steady, (2, 1)),
        angle=np.outer([0.0, end], case.frequency),
        frequency=case.frequency[np.newaxis],
        frequency_rate=np.zeros((1, 2)),
        force=np.array([modal], dtype=complex),
        force_rate=np.zeros((1, 2), dtype=complex),
    )
