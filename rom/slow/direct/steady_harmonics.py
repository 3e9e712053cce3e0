"""Harmonics of a steady state, and the response of all modes: D(nu) q = f / 2 - B(nu) P."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
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
    def of(cls, reduced: Reduced, orders: Sequence[Order], half: Floats) -> Self:
        """Return the matrices under forces 2 half cos(Omega_j t), half (modes, n) [N]."""
        own = np.arange(len(half))
        nu = np.array(orders, dtype=float)[:, : own.size] @ reduced.carrier
        B = reduced.modal_coupling(nu)
        loads = np.zeros(B.shape[:2], dtype=complex)
        loads[own] = half @ reduced.all_shapes
        return cls(tuple(orders), nu, reduced.modal_stiffness(nu), B, reduced.following(nu), loads)

    def modal(self, P: Complexes) -> Complexes:
        """Return the displacement of all modes due to the forces and contact harmonics P."""
        loads = self.loads - np.einsum("qkc,qc->qk", self.B, P)
        return np.asarray(np.linalg.solve(self.D, loads[..., np.newaxis])[..., 0])
