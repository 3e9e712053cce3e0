"""The non-resonant answer of the retained modes to the harmonics of the contact motion.

q_j,nm = -L_j(nu)^T P_nm / (omega_j^2 - nu^2 + i gamma_j nu),  nu = n Omega_A + m Omega_B
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rom.amplitude import Complexes
from rom.matrices import Floats
from rom.model import Model
from rom.near import Order, is_resonant
from rom.slow_trajectory import SlowTrajectory


@dataclass(frozen=True, eq=False)
class ModalAnswer:
    """Harmonics of the contacts, and what the modes make of them, along a slow trajectory.

    A harmonic c_nm stands for 2 Re(c_nm exp(i (n theta_A + m theta_B))).

    Attributes
    ----------
    orders : tuple of (n, m)
    frequency : (points, orders) ndarray
        nu [rad/s]
    contact : (points, orders, N_c) complex ndarray
        Contact displacement [m].
    modal : (points, orders, modes) complex ndarray
        Modal displacement besides the carriers [kg^1/2 m].
    pull : (points, orders, N_c) complex ndarray
        Force on the contacts that comes with it [N].
    """

    orders: tuple[Order, ...]
    frequency: Floats
    contact: Complexes
    modal: Complexes
    pull: Complexes


def modal_answer(model: Model, trajectory: SlowTrajectory) -> ModalAnswer:
    """Answer of the modes along a trajectory; empty where the model keeps no harmonics."""
    points, reduced = trajectory.time.size, model.reduced
    if model.harmonics is None:
        nothing = np.zeros((points, 0, 0), dtype=complex)
        return ModalAnswer((), np.zeros((points, 0)), nothing, nothing, nothing)
    orders = model.harmonics.orders
    P = model.harmonics.at(trajectory.felt(model))
    nu = trajectory.point_frequency @ np.array(orders, dtype=float)[:, : model.modes].T
    modal = np.zeros((points, len(orders), model.modes), dtype=complex)
    pull = np.zeros_like(P)
    answering = reduced.formulation == "consistent"
    for q, order in enumerate(orders):
        stiffness = reduced.modal_stiffness(nu[:, q])
        for j in range(model.modes):
            if not answering or is_resonant(j, order, model.near):
                continue
            L = reduced.spring[j] + 1j * nu[:, q, np.newaxis] * reduced.damper[j]
            modal[:, q, j] = -np.sum(L * P[:, q], axis=1) / stiffness[:, j]
            pull[:, q] -= L * modal[:, q, j, np.newaxis]
    return ModalAnswer(orders, nu, P, modal, pull)
