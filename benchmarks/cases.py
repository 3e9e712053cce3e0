"""Cases: a structure with rigid friction under a steady force of one or two frequencies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from slipmode import rom
from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.full import Excitation

Force = Mapping[int, float] | ArrayLike

SAMPLING = 0.5  # [s], of every signal
_WINDOW = 100.0  # [s], at the end of a run: there contact displacements are compared
_BETA = 0.01  # stiffness-proportional damping [s]
_JOINT = 150.0  # stiffness of a joint with friction over that of a chain of springs


@dataclass(frozen=True, eq=False)
class Case:
    """A structure, its friction law and its excitation from rest."""

    name: str
    structure: rom.Structure
    law: rom.Friction
    force: tuple[Force, ...]  # amplitudes [N], one per mode
    frequency: tuple[float, ...]  # of the forces [rad/s]
    observed: tuple[int, ...] = (0, 1)  # DOFs whose displacement is compared, one per mode
    duration: float = 600.0  # [s]

    @property
    def times(self) -> Floats:
        """Times at which signals are compared, (samples,) [s]."""
        return np.asarray(SAMPLING * np.arange(1.0, round(self.duration / SAMPLING) + 1.0))

    @property
    def in_window(self) -> Flags:
        """True for samples at which contact displacements are compared, (samples,)."""
        return np.asarray(self.times > self.duration - _WINDOW)

    @property
    def excitation(self) -> Excitation:
        """The excitation for full-order integration."""
        return Excitation.harmonic(self.structure, self.force, self.frequency)


def two_mode() -> Case:
    """Return the source paper's structure with both modes near resonance."""
    return Case(
        "two-mode",
        rom.two_mass(beta=_BETA),
        rom.Tanh(limit=2.0, alpha=0.02),
        force=({0: 0.15}, {1: 0.25}),
        frequency=(0.98, 1.65),
    )


def forced(name: str, A: float, B: float, law: rom.Friction | None = None) -> Case:
    """Return the two-mode case with other force amplitudes [N], and another law if given."""
    case = two_mode()
    return replace(case, name=name, force=({0: A}, {1: B}), law=law or case.law)


def near_commensurate() -> Case:
    """Return a case in which -4 Omega_A + 3 Omega_B = 0.98 rad/s drives mode A."""
    return replace(forced("near-commensurate", 0.1, 0.3), frequency=(1.0, 1.66))


def with_alpha(alpha: float) -> Case:
    """Return the two-mode case with another regularisation velocity [m/s]."""
    return replace(two_mode(), name=f"alpha {alpha:g}", law=rom.Tanh(limit=2.0, alpha=alpha))


def coulomb() -> Case:
    """Return the two-mode case with Coulomb friction."""
    return replace(two_mode(), name="Coulomb friction", law=rom.Coulomb(limit=2.0))


def general_damping() -> Case:
    """Return the two-mode case with dashpots that couple the modes."""
    base = rom.two_mass(beta=_BETA)
    dashpots = np.zeros((4, 4))
    dashpots[:2, :2] = [[0.012, -0.008], [-0.008, 0.02]]
    dashpots[2, 2] = 0.1
    damping = np.asarray(base.damping) + dashpots
    structure = rom.Structure(base.mass, base.stiffness, damping, contact=(2, 3))
    return replace(two_mode(), name="general damping", structure=structure)


def shared_forces() -> Case:
    """Return the two-mode case with forces that act on both modes."""
    return replace(
        two_mode(), name="forces on both modes", force=({0: 0.15, 1: 0.1}, {1: 0.25, 0: -0.1})
    )


def six_dofs() -> rom.Structure:
    """Return three masses, each on a contact; neighbouring contacts are coupled."""
    mass = np.diag([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
    springs = np.array([1.0, 1.7**2, 2.6**2])
    to_ground, between = np.array([20.0, 40.0, 60.0]), 5.0
    contacts = np.diag(springs + to_ground) + between * (
        np.diag([1.0, 2.0, 1.0]) - np.eye(3, k=1) - np.eye(3, k=-1)
    )
    stiffness = np.block([[np.diag(springs), -np.diag(springs)], [-np.diag(springs), contacts]])
    return rom.Structure(mass, stiffness, _BETA, contact=(3, 4, 5))


def six_dofs_three_contacts() -> Case:
    """Return a case on `six_dofs`, whose third mode is not retained."""
    law = rom.Tanh(limit=[2.0, 2.0, 1.0], alpha=0.02)
    return replace(two_mode(), name="6 DOFs, 3 contacts", structure=six_dofs(), law=law)


class Chain:
    """Masses on an elastic foundation, joined by springs, with friction in three of the joints.

    Stuck, its first two natural frequencies are about 1 and 1.7 rad/s. A joint that slips is
    still held by its own spring, so that contacts move little against the modes.

    Parameters
    ----------
    masses : int
    """

    def __init__(self, masses: int) -> None:
        self.masses = masses
        self.joints = [round(masses * share) for share in (0.15, 0.45, 0.8)]

    @cached_property
    def _matrices(self) -> tuple[Floats, Floats, Floats]:
        """Mass, stiffness and contact directions; each modal mass is about 1."""
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

    def structure(self, modal_damping: bool = True) -> rom.Structure:
        """Return the structure with damping proportional to stiffness, or with uneven dashpots."""
        mass, stiffness, directions = self._matrices
        if modal_damping:
            return rom.Structure(mass, stiffness, _BETA, contact=directions)
        uneven = np.linspace(0.0, 0.02, self.masses)
        damping = _BETA * stiffness + np.asarray(mass) * uneven
        return rom.Structure(mass, stiffness, damping, contact=directions)

    def case(self, *, modal_damping: bool = True, point_forces: bool = False) -> Case:
        """Return the chain forced in the shapes of its modes, or each force on one mass.

        Each contact begins to slip at amplitude 1 of the mode that acts on it with the larger
        force; alpha is a fifth of the sliding speed of the weakest contact.
        """
        reduced = rom.reduce(self.structure())
        shapes = reduced.mode_shapes
        limit = 2.0 * np.abs(reduced.spring).max(axis=0)
        observed = [int(dof) for dof in np.abs(shapes).argmax(axis=0)]
        amplitudes = (0.12, 0.2)
        force: tuple[Force, ...]
        if point_forces:
            force = tuple(
                {dof: float(size / abs(shapes[dof, mode]))}
                for mode, (dof, size) in enumerate(zip(observed, amplitudes, strict=True))
            )
        else:
            force = tuple((self._matrices[0] @ shapes * amplitudes).T)
        name = f"chain of {self.masses}" + ("" if modal_damping else ", general damping")
        return Case(
            name + (", point forces" if point_forces else ""),
            self.structure(modal_damping),
            rom.Tanh(limit.tolist(), 0.2 * float((limit / np.diag(reduced.stiffness)).min())),
            force=force,
            frequency=tuple((reduced.frequency * (0.98, 0.97)).tolist()),
            observed=tuple(observed),
        )


def many_contacts(contacts: int, joint: float = 0.25) -> Case:
    """Return one mass on many contacts that share the stiffness of the paper's first contact.

    Contacts are joined to their neighbours `joint` times as stiffly as to the ground. Their
    limits range from half to one and a half of the mean, so that they slip one after the other.
    """
    own, ground = 1.0 / contacts, 20.0 / contacts
    joined = 2.0 * np.eye(contacts) - np.eye(contacts, k=1) - np.eye(contacts, k=-1)
    joined[0, 0] = joined[-1, -1] = 1.0
    if contacts == 1:
        joined[:] = 0.0
    mass = np.diag([1.0, *(contacts * [0.01 / contacts])])
    stiffness = np.zeros((contacts + 1, contacts + 1))
    stiffness[0, 0] = 1.0
    stiffness[0, 1:] = stiffness[1:, 0] = -own
    stiffness[1:, 1:] = (own + ground) * np.eye(contacts) + joint * ground * joined
    spread = np.linspace(0.5, 1.5, contacts) if contacts > 1 else np.ones(1)
    return Case(
        f"{contacts} contact{'s' if contacts > 1 else ''}",
        rom.Structure(mass, stiffness, _BETA, contact=range(1, contacts + 1)),
        rom.Coulomb((2.0 / contacts * spread).tolist()),
        force=({0: 0.15},),
        frequency=(0.98,),
        observed=(0,),
    )


def steady_cases() -> list[Case]:
    """Return each mode alone and both together, at their peaks and beside them."""
    natural_a, natural_b = 1.0, 1.7  # [rad/s]
    return [
        replace(
            forced(f"F {A:g}, {B:g} at {natural_a + d_a:g}, {natural_b + d_b:g}", A, B),
            frequency=(natural_a + d_a, natural_b + d_b),
        )
        for A, B, d_a, d_b in (
            (0.15, 0.0, -0.0175, 0.0),
            (0.15, 0.0, -0.03, 0.0),
            (0.0, 0.25, 0.0, -0.046),
            (0.0, 0.25, 0.0, -0.07),
            (0.15, 0.25, -0.0175, -0.046),
            (0.15, 0.25, -0.03, -0.06),
            (0.15, 0.25, -0.005, -0.02),
        )
    ]
