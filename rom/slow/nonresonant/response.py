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

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.combination import CARRIERS, Order, resonant_modes
from slipmode.rom.reduction.force_response import steady_force
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model

_BLOCK = 8192  # harmonics at a time, to limit the memory


@frozen
class ModalResponse:
    """Harmonics of the contacts, and the response of the modes, along a slow trajectory.

    A harmonic c_nm stands for 2 Re(c_nm exp(i (n theta_A + m theta_B))).
    """

    orders: tuple[Order, ...]
    frequency: Floats  # (points, orders), nu [rad/s]
    contact: Complexes  # (points, orders, N_c), contact displacement [m]
    modal: Complexes  # (points, orders, modes), modal displacement besides the carriers [kg^1/2 m]
    reaction: Complexes  # (points, orders, N_c), force on the contacts that comes with it [N]


def modal_response(model: Model, trajectory: SlowTrajectory) -> ModalResponse:
    """Return the response of the modes along a trajectory; empty if the model has no harmonics."""
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
    """Return the response of the modes to harmonics P (points, orders, N_c) of the contacts.

    The carriers are among the orders. P are the harmonics of the contact problem of the table; the
    other effects of the forces change the carriers.
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
        for held, members in groups.items():
            here = np.ix_(rows, np.array(members))
            others = _Others.of(reduced, held, nu[here])
            modal[here], reaction[here] = others.response(P[here])
        for mode, order in enumerate(CARRIERS[: model.modes]):
            here = np.ix_(rows, np.array([orders.index(order)]))
            held = resonant_modes(model.modes, order, model.combinations)
            others = _Others.of(reduced, held, nu[here])
            carried = _at_carrier(trajectory, others, mode, rows, effective[rows, mode], P[here])
            P[here], modal[here], reaction[here] = carried
    return ModalResponse(orders, nu, P, modal, reaction)


@dataclass(frozen=True, eq=False)
class _Others:
    """The modes that respond to harmonics: all but those whose slow flow has them."""

    reduced: Reduced
    held: Flags  # (modes,), retained modes whose slow flow has the harmonics
    # nu [rad/s]: (harmonics,) if the frequencies of all points are equal, else of every harmonic
    # at every point
    frequency: Floats
    steady: bool  # whether the frequencies of all points are equal

    @classmethod
    def of(cls, reduced: Reduced, held: Sequence[int], nu: Floats) -> Self:
        """Return the modes but the held ones at frequencies nu (points, harmonics)."""
        steady = bool(np.all(nu == nu[0]))
        flags = np.isin(np.arange(len(reduced.modes)), list(held))
        return cls(reduced, flags, nu[0] if steady else nu.ravel(), steady)

    def displacement(self, force: Complexes) -> Complexes:
        """Return displacements due to modal forces, both (frequencies, all modes, forces)."""
        return self.reduced.response(self.frequency, force, self.held)

    def response(
        self, P: Complexes, force: Complexes | None = None
    ) -> tuple[Complexes, Complexes]:
        """Return displacements and reaction on the contacts due to contacts and modal forces.

        P (points, harmonics, N_c), force and displacements (points, harmonics, all modes).
        """
        moved, B = self._columns(P), self.reduced.modal_coupling(self.frequency)
        on_modes = -B @ moved
        if force is not None:
            on_modes += self._columns(force)
        q = self.displacement(on_modes)
        reaction = self.reduced.following(self.frequency) @ moved - B.swapaxes(1, 2) @ q
        return self._by_point(q, P.shape[:2]), self._by_point(reaction, P.shape[:2])

    def contact_stiffness(self) -> Complexes:
        """Return the stiffness of the contacts without friction, (frequencies, N_c, N_c)."""
        reduced, nu = self.reduced, self.frequency[:, np.newaxis, np.newaxis]
        own = reduced.stiffness - nu**2 * reduced.mass
        if reduced.contacts is None:  # the reaction has the dampers of elastic contacts
            own = own + 1j * nu * reduced.damping
        return np.asarray(own - reduced.reaction(self.frequency, self.held))

    def _columns(self, values: Complexes) -> Complexes:
        """Return values (points, harmonics, k) of each frequency in columns."""
        if self.steady:
            return values.transpose(1, 2, 0)
        return values.reshape(-1, values.shape[2], 1)

    def _by_point(self, values: Complexes, shape: tuple[int, ...]) -> Complexes:
        """Return values in columns as (points, harmonics, k)."""
        if self.steady:
            return values.transpose(2, 0, 1)
        return values.reshape(*shape, -1)


def _at_carrier(
    trajectory: SlowTrajectory,
    others: _Others,
    mode: int,
    points: NDArray[np.intp],
    effective: Complexes,
    P: Complexes,
) -> tuple[Complexes, Complexes, Complexes]:
    """Return contacts, response and reaction at the carrier of a mode, (points, 1, ...).

    P are the contacts moved by the mode with the `effective` amplitudes (points,); other effects
    of the force are added.
    """
    reduced, response = others.reduced, trajectory.force_response
    force, on_contacts = None, np.zeros_like(P)
    if response is not None:
        half = 0.5 * trajectory.point_force[points, mode, np.newaxis, np.newaxis]
        force = half * response.modal[mode]
        on_contacts = half * response.applied.residual(response.applied.contact)[mode]
        added = on_contacts + others.response(np.zeros_like(P), force)[1]
        at_mode = effective[:, np.newaxis]
        tabulated = _tabulated_force(reduced, mode, at_mode, P[:, 0])
        moving = tabulated - at_mode * reduced.coupling[mode]
        stiffness = others.contact_stiffness()
        P = (
            P
            + _displacement_by(added[:, 0] - tabulated, stiffness, P[:, 0], moving)[:, np.newaxis]
        )
    q, reaction = others.response(P, force)
    coupled = reduced.modal_stiffness(others.frequency)[..., [mode]]
    by_dampers = others.displacement(coupled)[..., 0]  # (frequencies, all modes) per amplitude
    amplitude = trajectory.amplitude[points, mode, np.newaxis]
    return P, q - (by_dampers * amplitude)[:, np.newaxis], reaction + on_contacts


def _tabulated_force(reduced: Reduced, mode: int, effective: Complexes, P: Complexes) -> Complexes:
    """Return the part of a force that carriers P (points, N_c) from the table include."""
    force, D = steady_force(reduced)
    held = D[mode] * effective + (P @ reduced.coupling[mode])[:, np.newaxis]
    return np.asarray(held * force[mode])


def _displacement_by(
    added: Complexes, stiffness: Complexes, P: Complexes, force: Complexes
) -> Complexes:
    """Return the change of a carrier P of the contacts by a small added force, (points, N_c).

    `stiffness` is (points, N_c, N_c), or (1, N_c, N_c) for all points. Friction resists with its
    secant stiffness friction_i / P_i, where `force` balances stiffness and friction. A contact
    that sticks does not move.
    """
    friction = force - (stiffness @ P[..., np.newaxis])[..., 0]
    elastic = np.abs(np.einsum("pcc->pc", stiffness) * P)
    reach = np.abs(force).max(axis=1, keepdims=True)
    rounding = 1e-9
    sticks = (elastic <= rounding * reach) | (reach == 0.0)
    moving = np.where(sticks, 0.0, P)
    system = stiffness * moving[:, np.newaxis, :]
    contacts = np.arange(P.shape[1])
    system[:, contacts, contacts] += np.where(sticks, 1.0, friction)
    return np.asarray(moving * np.linalg.solve(system, added[..., np.newaxis])[..., 0])
