"""The nonresonant response of the modes to harmonics of the contact motion, and to the forces.

q_nm = D(nu)^-1 (f_nm - B(nu) P_nm),  nu = n Omega_A + m Omega_B
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import CARRIERS, Order, resonant_modes
from slipmode.rom.reduction.force_response import steady_force
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model

_BLOCK = 8192  # harmonics at a time: memory
_STUCK = 1e-9  # carrier of a contact that is rounding, relative to the largest


@dataclass(frozen=True, eq=False)
class ModalResponse:
    """Harmonics of the contacts, and what the modes make of them, along a slow trajectory.

    A harmonic c_nm stands for 2 Re(c_nm exp(i (n theta_A + m theta_B))).
    """

    orders: tuple[Order, ...]
    frequency: Floats  # (points, orders), nu [rad/s]
    contact: Complexes  # (points, orders, N_c), contact displacement [m]
    modal: Complexes  # (points, orders, modes), modal displacement besides the carriers [kg^1/2 m]
    reaction: Complexes  # (points, orders, N_c), force on the contacts that comes with it [N]

    __repr__ = short_repr


def modal_response(model: Model, trajectory: SlowTrajectory) -> ModalResponse:
    """Response of the modes along a trajectory; empty where the model keeps no harmonics."""
    points, reduced = trajectory.time.size, model.reduced
    all_modes = reduced.all_shapes.shape[1]
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
    """Return the response of the modes to harmonics of the contacts along a trajectory.

    Parameters
    ----------
    model : Model
    trajectory : SlowTrajectory
    orders : tuple of (n, m)
        The carriers among them.
    P : (points, orders, N_c) complex ndarray
        As the table's contact problem has them; the carriers change by what the forces do to the
        contacts besides.
    """
    points, reduced = trajectory.time.size, model.reduced
    all_modes, effective = reduced.all_shapes.shape[1], trajectory.effective(model)
    nu = trajectory.point_frequency @ np.array(orders, dtype=float)[:, : model.modes].T
    modal, reaction = np.zeros((*P.shape[:2], all_modes), dtype=complex), np.zeros_like(P)
    if reduced.formulation == "paper":
        return ModalResponse(orders, nu, P, modal, reaction)
    groups: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for q, order in enumerate(orders):
        if order not in CARRIERS:
            groups[resonant_modes(model.modes, order, model.combinations)].append(q)
    block = max(1, _BLOCK // len(orders))
    for rows in (np.arange(k, min(k + block, points)) for k in range(0, points, block)):
        for excluded, members in groups.items():
            group = np.array(members)
            here = np.ix_(rows, group)
            others = _Others.of(reduced, excluded, nu[here])
            responded, reaction[here] = others.response(P[here])
            modal[np.ix_(rows, group, others.numbers)] = responded
        for mode, order in enumerate(CARRIERS[: model.modes]):
            q = orders.index(order)
            excluded = resonant_modes(model.modes, order, model.combinations)
            others = _Others.of(reduced, excluded, nu[rows, q, np.newaxis])
            carried = _at_carrier(model, trajectory, effective, rows, others, mode, P[rows, q])
            P[rows, q], responded, reaction[rows, q] = carried
            modal[rows[:, np.newaxis], q, others.numbers] = responded
    return ModalResponse(orders, nu, P, modal, reaction)


@dataclass(frozen=True, eq=False)
class _Others:
    """The modes that respond to harmonics: all but those whose slow flow has them.

    Matrices are those of `distinct` frequencies: one for each harmonic where the forcing stands
    still, else one for each harmonic at each point.
    """

    reduced: Reduced
    numbers: NDArray[np.intp]  # (others,), of these modes
    steady: bool  # Whether the frequencies of all points are the same
    distinct: Floats  # (distinct, 1, 1), nu [rad/s]
    coupling: Complexes  # (distinct, others, N_c), B
    all_rows: Complexes  # (distinct, others, modes + nonresonant), their rows of D

    @classmethod
    def of(cls, reduced: Reduced, excluded: Sequence[int], nu: Floats) -> Self:
        """At the frequencies nu (points, harmonics)."""
        numbers = np.delete(np.arange(reduced.all_shapes.shape[1]), list(excluded))
        steady = bool(np.all(nu == nu[0]))
        distinct = nu[0] if steady else nu.ravel()
        return cls(
            reduced,
            numbers,
            steady,
            distinct[:, np.newaxis, np.newaxis],
            reduced.modal_coupling(distinct)[:, numbers],
            reduced.modal_stiffness(distinct)[:, numbers],
        )

    def displacement(self, force: Complexes) -> Complexes:
        """Displacement by forces on them (distinct, others, forces)."""
        return np.asarray(np.linalg.solve(self.all_rows[:, :, self.numbers], force))

    def response(
        self, P: Complexes, force: Complexes | float = 0.0
    ) -> tuple[Complexes, Complexes]:
        """Displacement (points, harmonics, others) by contacts P (points, harmonics, N_c).

        And by forces; then its reaction on the contacts.
        """
        moved = self._side_by_side(P)
        on_them = -self.coupling @ moved
        if isinstance(force, np.ndarray):
            on_them += self._side_by_side(force)
        q = self.displacement(on_them)
        follows = self.distinct**2 * (self.reduced.carried_mass.T @ moved)
        if self.reduced.contacts is not None:
            follows = follows - 1j * self.distinct * (self.reduced.damping.T @ moved)
        reaction = follows - self.coupling.transpose(0, 2, 1) @ q
        return self._by_point(q, P.shape[:2]), self._by_point(reaction, P.shape[:2])

    def contact_stiffness(self) -> Complexes:
        """Of the contacts without friction, these modes responding, (distinct, N_c, N_c)."""
        reduced, nu = self.reduced, self.distinct
        inertia = reduced.mass + reduced.carried_mass
        own = reduced.stiffness + 1j * nu * reduced.damping - nu**2 * inertia
        reacting = self.coupling.transpose(0, 2, 1) @ self.displacement(self.coupling)
        return np.asarray(own - reacting)

    def _side_by_side(self, values: Complexes) -> Complexes:
        """Values (points, harmonics, k) of the same frequency, (distinct, k, values)."""
        if self.steady:
            return values.transpose(1, 2, 0)
        return values.reshape(-1, values.shape[2], 1)

    def _by_point(self, values: Complexes, shape: tuple[int, ...]) -> Complexes:
        """Back from `_side_by_side`."""
        if self.steady:
            return values.transpose(2, 0, 1)
        return values.reshape(*shape, -1)


def _at_carrier(
    model: Model,
    trajectory: SlowTrajectory,
    effective: Complexes,
    points: NDArray[np.intp],
    others: _Others,
    mode: int,
    P: Complexes,
) -> tuple[Complexes, Complexes, Complexes]:
    """Contacts, response and reaction where a force acts; P as its mode alone makes it."""
    force_response = trajectory.force_response
    on_modes: Complexes | float = 0.0
    on_contacts: Complexes | float = 0.0

    def response(P: Complexes) -> tuple[Complexes, Complexes]:
        q, reaction = others.response(P[:, np.newaxis], on_modes)
        return q[:, 0], reaction[:, 0]

    if force_response is not None:
        half = 0.5 * trajectory.point_force[points, mode, np.newaxis]
        on_modes = (half * force_response.modal[mode, others.numbers])[:, np.newaxis]
        on_contacts = half * force_response.residual_force(model.reduced)[mode]
        further = on_contacts + response(np.zeros_like(P))[1]
        effective_here = effective[points, mode, np.newaxis]
        tabulated = _tabulated_force(model.reduced, mode, effective_here, P)
        coupled = effective_here * model.reduced.coupling[mode]
        P = P + _displacement_by(
            further - tabulated, others.contact_stiffness(), P, tabulated - coupled
        )
    q, reaction = response(P)
    by_dampers = others.displacement(others.all_rows[:, :, [mode]])[..., 0]  # per a_j
    return (
        P,
        q - by_dampers * trajectory.amplitude[points, mode, np.newaxis],
        reaction + on_contacts,
    )


def _tabulated_force(reduced: Reduced, mode: int, effective: Complexes, P: Complexes) -> Complexes:
    """The part of a force on the contacts that carriers P (points, N_c) have from the table."""
    force, D = steady_force(reduced)
    held = D[mode] * effective + (P @ reduced.coupling[mode])[:, np.newaxis]
    return np.asarray(held * force[mode])


def _displacement_by(
    further: Complexes, stiffness: Complexes, P: Complexes, force: Complexes
) -> Complexes:
    """What a small further force adds to a carrier P of the contacts, (points, N_c).

    `stiffness` (points, N_c, N_c), or (1, N_c, N_c) of all points. Friction resists it with its
    secant stiffness, friction_i / P_i, which `force` and P tell; a contact that sticks does not
    move.
    """
    friction = force - (stiffness @ P[..., np.newaxis])[..., 0]
    elastic = np.abs(np.einsum("pcc->pc", stiffness) * P)
    reach = np.abs(force).max(axis=1, keepdims=True)
    sticks = (elastic <= _STUCK * reach) | (reach == 0.0)
    moving = np.where(sticks, 0.0, P)
    system = stiffness * moving[:, np.newaxis, :]
    contacts = np.arange(P.shape[1])
    system[:, contacts, contacts] += np.where(sticks, 1.0, friction)
    return np.asarray(moving * np.linalg.solve(system, further[..., np.newaxis])[..., 0])
