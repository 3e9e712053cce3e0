"""The cases of the report: a structure, its friction, and a steady two-frequency force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from slipmode import rom
from slipmode.rom import Structure
from slipmode.rom.arrays import Floats
from slipmode.rom.full import Excitation
from slipmode.runner.report.cases.structures import Chain, damped_between_modes, six_dofs

Force = Mapping[int, float] | ArrayLike

SAMPLING = 0.5  # [s], of every signal
WINDOW = 100.0  # [s], at the end, in which the contact motion is compared


@dataclass(frozen=True, eq=False)
class Case:
    """What every method is given.

    Attributes
    ----------
    name : str
    structure : Structure
    law : Tanh or Coulomb
    force : tuple of {DOF: amplitude} or (n,) array_like
        Force amplitudes [N], one per mode.
    frequency : tuple of float
        [rad/s], one per mode.
    observed : tuple of int
        DOFs whose displacement is compared; the first moves most in mode A, the second in B.
    duration : float
        From rest [s].
    """

    name: str
    structure: Structure
    law: rom.Friction
    force: tuple[Force, ...]
    frequency: tuple[float, ...]
    observed: tuple[int, ...] = (0, 1)
    duration: float = 600.0

    @property
    def times(self) -> Floats:
        """Where signals are compared (samples,)."""
        return np.asarray(SAMPLING * np.arange(1.0, round(self.duration / SAMPLING) + 1.0))

    @property
    def in_window(self) -> np.ndarray:
        """Which samples lie in the contact window, (samples,) of bool."""
        return self.times > self.duration - WINDOW

    @property
    def excitation(self) -> Excitation:
        """The force for the full-order integration."""
        return Excitation.harmonic(self.structure, self.force, self.frequency)


def two_mode() -> Case:
    """The paper's structure with both modes near resonance."""
    return Case(
        "two-mode",
        rom.two_mass(beta=0.01),
        rom.Tanh(limit=2.0, alpha=0.02),
        force=({0: 0.15}, {1: 0.25}),
        frequency=(0.98, 1.65),
    )


def near_commensurate() -> Case:
    """-4 Omega_A + 3 Omega_B = 0.98: a harmonic of the contacts drives mode A."""
    return replace(
        two_mode(), name="near-commensurate", force=({0: 0.1}, {1: 0.3}), frequency=(1.0, 1.66)
    )


def sharp() -> Case:
    """Friction that is four times as sharp."""
    return replace(two_mode(), name="sharp friction", law=rom.Tanh(limit=2.0, alpha=0.005))


def blunt() -> Case:
    """Friction that is five times as blunt."""
    return replace(two_mode(), name="blunt friction", law=rom.Tanh(limit=2.0, alpha=0.1))


def coulomb() -> Case:
    """Exact Coulomb friction."""
    return replace(two_mode(), name="Coulomb friction", law=rom.Coulomb(limit=2.0))


def general_damping() -> Case:
    """Dashpots that couple the modes."""
    return replace(two_mode(), name="general damping", structure=damped_between_modes())


def shared_forces() -> Case:
    """Each force acts on both modes."""
    return replace(
        two_mode(), name="forces on both modes", force=({0: 0.15, 1: 0.1}, {1: 0.25, 0: -0.1})
    )


def six_dofs_three_contacts() -> Case:
    """Three elastic masses on three coupled contacts; the third mode is not retained."""
    return replace(
        two_mode(),
        name="6 DOFs, 3 contacts",
        structure=six_dofs(),
        law=rom.Tanh(limit=[2.0, 2.0, 1.0], alpha=0.02),
    )


def chain(masses: int, *, modal_damping: bool = True) -> Case:
    """A chain with three contacts between neighbours, forced in the shape of its modes."""
    built = Chain(masses)
    damping = "" if modal_damping else ", general damping"
    return Case(
        f"chain of {masses}{damping}",
        built.structure(modal_damping),
        rom.Tanh(limit=built.limit, alpha=built.alpha),
        force=built.modal_forces((0.12, 0.2)),
        frequency=built.frequencies((0.98, 0.97)),
        observed=built.observed,
    )


def point_forced_chain(masses: int) -> Case:
    """The chain with each force on one mass: it acts on every mode."""
    return replace(
        chain(masses),
        name=f"chain of {masses}, point forces",
        force=Chain(masses).point_forces((0.12, 0.2)),
    )


# F_A, F_B [N], detuning of A and of B from the natural frequencies 1 and 1.7 [rad/s]
STEADY_CASES = (
    (0.15, 0.0, -0.0175, 0.0),
    (0.15, 0.0, -0.03, 0.0),
    (0.0, 0.25, 0.0, -0.046),
    (0.0, 0.25, 0.0, -0.07),
    (0.15, 0.25, -0.0175, -0.046),
    (0.15, 0.25, -0.03, -0.06),
    (0.15, 0.25, -0.005, -0.02),
)


def steady_cases() -> list[Case]:
    """Each mode alone and both together, at and beside their peaks."""
    return [
        replace(
            two_mode(),
            name=f"F {force_a:g}, {force_b:g} at {1.0 + d_a:g}, {1.7 + d_b:g}",
            force=({0: force_a}, {1: force_b}),
            frequency=(1.0 + d_a, 1.7 + d_b),
        )
        for force_a, force_b, d_a, d_b in STEADY_CASES
    ]
