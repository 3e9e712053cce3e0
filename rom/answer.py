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


CARRIERS: tuple[Order, ...] = ((1, 0), (0, 1))  # harmonics of modes A and B


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
    modal = np.zeros((*P.shape[:2], reduced.all_shapes.shape[1]), dtype=complex)
    pull = np.zeros_like(P)
    for q, order in enumerate(orders):
        if reduced.formulation == "paper":
            continue
        modal[:, q], pull[:, q] = _answer_to(model, order, nu[:, q], P[:, q], trajectory)
    return ModalAnswer(orders, nu, P, modal, pull)


def _answer_to(
    model: Model, order: Order, nu: Floats, P: Complexes, trajectory: SlowTrajectory
) -> tuple[Complexes, Complexes]:
    """Answer of all modes (points, modes) to a harmonic, and its pull on the contacts."""
    reduced = model.reduced
    modal = np.zeros((len(P), reduced.all_shapes.shape[1]), dtype=complex)
    silent = [j for j in range(model.modes) if is_resonant(j, order, model.near)]
    answers = np.delete(np.arange(modal.shape[1]), silent)
    B, D = reduced.modal_coupling(nu)[:, answers], reduced.modal_stiffness(nu)
    D_own = D[:, answers][:, :, answers]
    right = -np.einsum("pjc,pc->pj", B, P)
    pull = (nu**2)[:, np.newaxis] * (P @ reduced.carried_mass)
    own = CARRIERS.index(order) if order in CARRIERS else None
    if own is not None and trajectory.direct is not None:
        half = 0.5 * trajectory.point_force[:, own, np.newaxis]
        right += half * trajectory.direct.modal[own, answers]
        pull += half * trajectory.direct.beyond_shift(reduced)[own]
    answered = np.linalg.solve(D_own, right[..., np.newaxis])[..., 0]
    pull -= np.einsum("pjc,pj->pc", B, answered)
    if own is not None:  # what dampers between the modes make of a_j
        across = np.linalg.solve(D_own, D[:, answers, own, np.newaxis])[..., 0]
        answered -= across * trajectory.amplitude[:, own, np.newaxis]
    modal[:, answers] = answered
    return modal, pull
