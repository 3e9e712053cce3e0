"""The non-resonant answer of the retained modes to the harmonics of the contact motion.

q_j,nm = -L_j(nu)^T P_nm / (omega_j^2 - nu^2 + i gamma_j nu),  nu = n Omega_A + m Omega_B
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from rom.amplitude import Complexes
from rom.matrices import Floats
from rom.model import Model
from rom.near import Order, is_resonant
from rom.torus import contact_orders


@dataclass(frozen=True, eq=False)
class ModalAnswer:
    """Harmonics of the contacts, and what the modes make of them, along a slow trajectory.

    Attributes
    ----------
    orders : list of (n, m)
    modal : (points, orders, modes) complex ndarray
        q_nm exp(-i (n theta_A + m theta_B)) / 2, so that the answer of mode j is
        2 Re sum_nm modal exp(i (n theta_A + m theta_B)).
    pull : (points, orders, N_c) complex ndarray
        G_nm: the force on the contacts is Re sum_nm G_nm exp(i (n theta_A + m theta_B)) [N].
    """

    orders: list[Order]
    modal: Complexes
    pull: Complexes


def modal_answer(model: Model, amplitude: Complexes, frequency: Floats) -> ModalAnswer:
    """Answer of the modes at amplitudes and forcing frequencies (points, modes).

    The model must hold harmonics; without them (the paper's formulation) the answer is empty.
    """
    if model.harmonics.shape[2] == 0:
        nothing = np.zeros((len(amplitude), 0, 0), dtype=complex)
        return ModalAnswer([], nothing, nothing)
    orders = contact_orders(model.reduced, model.near)
    P = _harmonics(model, orders, amplitude)
    reduced = model.reduced
    modal = np.zeros((*P.shape[:2], reduced.all_shapes.shape[1]), dtype=complex)
    pull = np.zeros_like(P)
    for q, order in enumerate(orders):
        nu = frequency @ np.array(order[: model.modes], dtype=float)
        silent = [j for j in range(model.modes) if is_resonant(j, order, model.near)]
        answers = np.delete(np.arange(modal.shape[2]), silent)
        B, D = reduced.modal_coupling(nu)[:, answers], reduced.modal_stiffness(nu)
        right = -np.einsum("pjc,pc->pj", B, P[:, q])
        D_own = D[:, answers][:, :, answers]
        answered = np.linalg.solve(D_own, right[..., np.newaxis])[..., 0]
        inertia = (nu**2)[:, np.newaxis] * (P[:, q] @ reduced.carried_mass)
        pull[:, q] = 2.0 * (inertia - np.einsum("pjc,pj->pc", B, answered))
        for j, carrier in enumerate(((1, 0), (0, 1))[: model.modes]):
            if order == carrier:  # what dampers between the modes make of a_j
                across = np.linalg.solve(D_own, D[:, answers, j, np.newaxis])[..., 0]
                answered -= across * amplitude[:, j, np.newaxis]
        modal[:, q, answers] = answered
    return ModalAnswer(orders, modal, pull)


def _harmonics(model: Model, orders: list[Order], amplitude: Complexes) -> Complexes:
    """P_nm exp(i (n arg a_A + m arg a_B)) (points, orders, N_c), linear between the nodes."""
    modulus = np.abs(amplitude)
    axes = (model.table.node_a, model.table.node_b)[: model.modes]
    shape = model.harmonics.shape
    nodes = model.harmonics.reshape(*shape[: model.modes], *shape[2:])
    P = RegularGridInterpolator(axes, nodes)(np.minimum(modulus, model.table.limit))
    unit = np.divide(amplitude, modulus, out=np.ones_like(amplitude), where=modulus > 0)
    powers = np.array(orders)[:, : model.modes]
    turned: Complexes = P * np.prod(unit[:, np.newaxis] ** powers, axis=2)[..., np.newaxis]
    return turned
