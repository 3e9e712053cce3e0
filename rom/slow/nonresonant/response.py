"""The nonresonant response of the modes to harmonics of the contact motion, and to the forces.

q_nm = D(nu)^-1 (f_nm - B(nu) P_nm),  nu = n Omega_A + m Omega_B
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import CARRIERS, Order, resonant_modes
from slipmode.rom.reduction.force_response import steady_force
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model


@frozen
class ModalResponse:
    """Harmonics of the contacts, and the response of the modes, along a slow trajectory.

    A harmonic c_nm stands for 2 Re(c_nm exp(i (n theta_A + m theta_B))).
    """

    orders: tuple[Order, ...]
    frequency: Floats  # (points, orders), nu [rad/s]
    contact: Complexes  # (points, orders, N_c), contact displacement [m]
    # (points, orders, modes), modal displacement besides the carriers [kg^1/2 m], then the
    # coordinates of `Model.dof_response`
    modal: Complexes
    reaction: Complexes  # (points, orders, N_c), force on the contacts that comes with it [N]


def modal_response(model: Model, trajectory: SlowTrajectory) -> ModalResponse:
    """Return the response of the modes along a trajectory; empty if the model has no harmonics."""
    points, reduced = trajectory.time.size, model.reduced
    all_modes = model.all_shapes.shape[1]
    if model.harmonics is None:
        contacts = np.zeros((points, 0, reduced.n_contacts), dtype=complex)
        modal = np.zeros((points, 0, all_modes), dtype=complex)
        return ModalResponse((), np.zeros((points, 0)), contacts, modal, contacts)
    effective = trajectory.effective(model)
    scale = trajectory.scale_at(trajectory.time)[:, np.newaxis]
    P = scale[..., np.newaxis] * model.harmonics.at(effective / scale)
    return response_to(model, trajectory, model.harmonics.orders, P)


def response_to(
    model: Model, trajectory: SlowTrajectory, orders: tuple[Order, ...], P: Complexes
) -> ModalResponse:
    """Return the response of the modes to harmonics P (points, orders, N_c) of the contacts.

    The carriers are among the orders. P are the harmonics of the contact problem of the table; the
    other effects of the forces change the carriers.
    """
    points, reduced = trajectory.time.size, model.reduced
    nu = trajectory.point_frequency @ np.array(orders, dtype=float)[:, : model.modes].T
    contact, reaction = P.copy(), np.zeros_like(P)
    modal = np.zeros((*P.shape[:2], model.all_shapes.shape[1]), dtype=complex)
    if model.dof_response is not None:
        scale = trajectory.scale_at(trajectory.time)[:, np.newaxis]
        of_dofs = model.dof_response.at(trajectory.amplitude, trajectory.point_force, scale)
        own = [orders.index(order) for order in CARRIERS[: model.modes]]
        modal[:, own, reduced.all_shapes.shape[1] :] = of_dofs
    elif reduced.formulation == "consistent":
        block = max(1, 8192 // len(orders))  # limits the memory
        for rows in (slice(k, k + block) for k in range(0, points, block)):
            found = _responses(model, trajectory, orders, nu, rows, P[rows])
            contact[rows], modal[rows], reaction[rows] = found
    return ModalResponse(orders, nu, contact, modal, reaction)


def _responses(
    model: Model,
    trajectory: SlowTrajectory,
    orders: Sequence[Order],
    nu: Floats,
    rows: slice,
    P: Complexes,
) -> tuple[Complexes, Complexes, Complexes]:
    """Return contacts, response and reaction at some points, (points, orders, ...) each.

    All modes respond to a harmonic but those whose slow flow has it. P are the contacts moved by
    the modes at their carriers; other effects of the forces are added there.
    """
    reduced, applied = model.reduced, trajectory.force_response
    own = [orders.index(order) for order in CARRIERS[: model.modes]]
    at = nu[rows]
    if np.all(at == at[0]):  # one set of matrices for all points
        at = at[:1]
    B, follows = reduced.modal_coupling(at), reduced.following(at)
    held = resonant_modes(model.modes, orders, model.combinations)
    receptance = reduced.response(at, np.eye(B.shape[-2]), held)
    force, on_contacts = np.zeros((*P.shape[:2], B.shape[-2]), dtype=complex), np.zeros_like(P)
    if applied is not None:
        half = 0.5 * trajectory.point_force[rows][..., np.newaxis]
        force[:, own] = half * applied.on_modes
        on_contacts[:, own] = half * applied.residual(applied.contact)
        moved = _product(receptance[:, own], force[:, own])
        added = on_contacts[:, own] - _product(B[:, own].swapaxes(-1, -2), moved)
        # Without the part that the carriers from the table include
        effective = trajectory.effective(model)[rows]
        per_stiffness, D = steady_force(reduced)
        on_mode = D * effective + np.einsum("pjc,jc->pj", P[:, own], reduced.coupling)
        tabulated = on_mode[..., np.newaxis] * per_stiffness
        moving = tabulated - effective[..., np.newaxis] * reduced.coupling
        omega = at[:, own, np.newaxis, np.newaxis]
        stiffness = reduced.stiffness - omega**2 * reduced.mass - follows[:, own]
        if reduced.contacts is None:  # `following` has the dampers of elastic contacts
            stiffness = stiffness + 1j * omega * reduced.damping
        stiffness = stiffness - B[:, own].swapaxes(-1, -2) @ receptance[:, own] @ B[:, own]
        P = P.copy()
        P[:, own] += _displacement_by(added - tabulated, stiffness, P[:, own], moving)
    q = _product(receptance, force - _product(B, P))
    reaction = on_contacts + _product(follows, P) - _product(B.swapaxes(-1, -2), q)
    modes = np.arange(model.modes)
    coupled = reduced.modal_stiffness(at[:, own])[:, modes, :, modes].swapaxes(0, 1)
    by_dampers = (receptance[:, own] @ coupled[..., np.newaxis])[..., 0]  # per amplitude
    q[:, own] -= by_dampers * trajectory.amplitude[rows][..., np.newaxis]
    return P, q, reaction


def _product(matrix: Complexes, vectors: Complexes) -> Complexes:
    """Return products (points, orders, k) of vectors and matrices (points or 1, orders, k, m)."""
    if len(matrix) == 1:
        return np.asarray((matrix[0] @ vectors.transpose(1, 2, 0)).transpose(2, 0, 1))
    return np.asarray((matrix @ vectors[..., np.newaxis])[..., 0])


def _displacement_by(
    added: Complexes, stiffness: Complexes, P: Complexes, force: Complexes
) -> Complexes:
    """Return the change of carriers P of the contacts by small added forces, (points, modes, N_c).

    `stiffness` is (points or 1, modes, N_c, N_c), without friction. Friction resists with its
    secant stiffness friction_i / P_i, where `force` balances stiffness and friction. A contact
    that sticks does not move, nor does one with hardly any motion, or on which hardly any force
    acts: friction alone may move it (slip by another mode), and its secant stiffness then cancels
    the stiffness.
    """
    friction = force - (stiffness @ P[..., np.newaxis])[..., 0]
    elastic = np.einsum("...cc->...c", stiffness) * P
    driving = friction + elastic  # by the modes and the other contacts
    reach = np.abs(force).max(axis=-1, keepdims=True, initial=0.0)
    sticks = (np.minimum(np.abs(elastic), np.abs(driving)) <= 1e-6 * reach) | (reach == 0.0)
    moving = np.where(sticks, 0.0, P)
    system = stiffness * moving[..., np.newaxis, :]
    contacts = np.arange(P.shape[-1])
    system[..., contacts, contacts] += np.where(sticks, 1.0, friction)
    return np.asarray(moving * np.linalg.solve(system, added[..., np.newaxis])[..., 0])
