"""Harmonics of a steady state, and the response of all modes: D(nu) q = f / 2 - B(nu) P."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.time_budget import WorkLimit
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen


@frozen
class SteadyProblem:
    """A structure under forces F_j cos(Omega_j t) at the carriers of the reduced model."""

    reduced: Reduced
    law: Friction
    force: Floats  # (modes, n), F_j [N]
    tolerance: float  # relative, of the amplitudes
    work: WorkLimit


@frozen
class SteadyHarmonics:
    """Harmonics 2 Re(c_nm exp(i (n t_A + m t_B))) of a steady state, the carriers first."""

    amplitude: Complexes  # (modes,), a_j of the retained modes at their carriers [kg^1/2 m]
    orders: list[Order]
    frequency: Floats  # (orders,), n Omega_A + m Omega_B [rad/s]
    modal: Complexes  # (orders, modes + nonresonant), displacement of all modes [kg^1/2 m]
    P: Complexes  # (orders, N_c), of the contact displacement [m]

    def at(self, orders: Sequence[Order]) -> Complexes:
        """Return P at other harmonics, 0 at unknown ones, (orders, N_c)."""
        rows = dict(zip(self.orders, self.P, strict=True))
        return np.array([rows.get(order, np.zeros_like(self.P[0])) for order in orders])


def relative_error(reduced: Reduced, error: Complexes | Floats, amplitude: Complexes) -> float:
    """Return the largest error (modes,) of amplitudes, relative to their contact motion."""
    moves = np.linalg.norm(reduced.coupling, axis=1)
    motion = moves * np.abs(amplitude)
    # Errors of weak modes are relative to a tenth of the strongest mode's contact motion.
    scale = np.maximum(motion, 0.1 * motion.max())
    return float((moves * np.abs(error) / np.maximum(scale, np.finfo(float).tiny)).max())


def neglected_modes(problem: SteadyProblem, found: SteadyHarmonics) -> Floats:
    """Return the effect of modes that follow statically on the amplitudes, relative, (modes,).

    Their flexibility R_s and inertia are in the contact problem. Beyond, they respond to the force
    deficit P at nu by at most R_s s^4 / (1 - s^2) P, s = nu / omega, with the highest frequency
    omega of the other modes. Contacts resist with the stiffness (1 / k + R)^-1. The sum over the
    harmonics was 1.4 to 9 times the effect in four blades (test_static_modes.py). 0 for rigid
    contacts.
    """
    reduced, modes = problem.reduced, len(problem.force)
    if reduced.contacts is None or not reduced.contacts.reference.all():
        return np.zeros(modes)
    omega = reduced.nonresonant_frequency[:, np.newaxis]
    R, inertia = -reduced.stiffness, omega * reduced.nonresonant_inertia
    part = np.minimum(np.abs(found.frequency) / reduced.highest_frequency, 1.0) ** 2
    beyond = part**2 / np.maximum(1.0 - part, part**2)
    moved = np.abs(beyond[:, np.newaxis] * (found.P @ (R - inertia.T @ inertia))).sum(axis=0)
    stiffness = np.linalg.inv(np.diag(1.0 / reduced.contacts.reference) + R)
    force = 0.5 * np.abs(np.einsum("jn,nj->j", problem.force, reduced.mode_shapes))
    effect = np.abs(reduced.coupling @ stiffness) @ moved
    return np.asarray(np.divide(effect, force, out=np.zeros(modes), where=force > 0.0))


@frozen
class Receptance:
    """Matrices of all modes at the harmonics of forces and contacts."""

    orders: tuple[Order, ...]  # The carriers of the retained modes first
    frequency: Floats  # (orders,), nu = n Omega_A + m Omega_B [rad/s]
    # (orders, modes + nonresonant, modes + nonresonant), dynamic stiffness of the modes
    # [rad^2/s^2]
    D: Complexes
    B: Complexes  # (orders, modes + nonresonant, N_c), coupling to the contacts
    # (orders, N_c, N_c), force on the contacts due to the inertia that follows them
    follows: Complexes
    loads: Complexes  # (orders, modes + nonresonant), half of the modal forces [N kg^-1/2]

    @classmethod
    def of(cls, reduced: Reduced, orders: Sequence[Order], half: Complexes | Floats) -> Self:
        """Return the matrices under forces 2 half cos(Omega_j t), half (modes, n) [N]."""
        own = np.arange(len(half))
        nu = np.array(orders, dtype=float)[:, : own.size] @ reduced.carrier
        B = reduced.modal_coupling(nu)
        loads = np.zeros(B.shape[:2], dtype=complex)
        loads[own] = half @ reduced.all_shapes
        return cls(tuple(orders), nu, reduced.modal_stiffness(nu), B, reduced.following(nu), loads)

    @property
    def resonant(self) -> Flags:
        """Which modes are near each harmonic, (orders, modes + nonresonant).

        The others respond with less than twice the force of their inertia.
        """
        own = np.abs(np.einsum("qkk->qk", self.D))
        return np.asarray(own < 0.5 * self.frequency[:, np.newaxis] ** 2)

    def modal(self, P: Complexes) -> Complexes:
        """Return the displacement of all modes due to the forces and contact harmonics P."""
        loads = self.loads - np.einsum("qkc,qc->qk", self.B, P)
        return np.asarray(np.linalg.solve(self.D, loads[..., np.newaxis])[..., 0])
