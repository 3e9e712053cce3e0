"""What the modes respond to the harmonics of the contacts, at the nodes of a friction table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import CARRIERS, Order, resonant_modes
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.short_repr import short_repr
from slipmode.rom.table.model import Model

NEGLIGIBLE = 1e-4  # relative to the largest force of the modes on the contacts, or displacement


@dataclass(frozen=True, eq=False)
class ResponseSurface:
    """Harmonics (n, m) of the modal response over the amplitude plane, in a steady motion.

    A coefficient c_nm stands for Re(c_nm exp(i (n theta_A + m theta_B))).
    """

    orders: NDArray[np.int32]  # (orders, 2), without those that are negligible at every node
    reaction: Complexes  # (n_a, n_b, orders, N_c), force on the contacts [N]
    # (n_a, n_b, orders, DOFs), displacement of DOFs of the structure [m], besides the carriers and
    # the contacts' part
    elastic: Complexes
    # (DOFs, modes), displacement per amplitude of the modes, with what dampers make the others do
    # [kg^-1/2]
    modes_out: Complexes

    __repr__ = short_repr


def response_surface(model: Model, dofs: Sequence[int] = ()) -> ResponseSurface:
    """The response for contact motion and the displacement of some DOFs, at the model's carriers.

    Parameters
    ----------
    model : Model
    dofs : sequence of int

    Raises
    ------
    SlipmodeError
        If the modes respond, but the model keeps no harmonics.
    """
    reduced, rows = model.reduced, list(dofs)
    nodes = model.table.node_a.size, model.table.node_b.size
    contacts = reduced.n_contacts
    if reduced.formulation == "paper":
        return no_response(model, rows)
    if model.harmonics is None:
        raise SlipmodeError(
            "contact: this model keeps no harmonics, to which its modes respond; tabulate it "
            f"with harmonics={RESPONSE_ORDER}"
        )
    orders = model.harmonics.orders
    P = model.harmonics.P.reshape(*nodes, len(orders), contacts)
    force = reaction_stiffness(reduced, tuple(orders), model.combinations)
    moved = [_displacement(model, order, rows) for order in orders]
    reaction = 2.0 * np.einsum("abqc,qce->abqe", P, force)
    elastic = 2.0 * np.einsum("abqc,qce->abqe", P, np.array(moved))
    modes_out = _modes_out(model, rows)
    kept = _counts(reaction, reduced.coupling, model) | _counts(elastic, modes_out.T, model)
    return ResponseSurface(
        np.array(orders, dtype=np.int32)[kept],
        np.ascontiguousarray(reaction[:, :, kept]),
        np.ascontiguousarray(elastic[:, :, kept]),
        modes_out,
    )


def no_response(model: Model, dofs: Sequence[int] = ()) -> ResponseSurface:
    """Modes that move at their carriers alone."""
    nodes = model.table.node_a.size, model.table.node_b.size
    return ResponseSurface(
        np.zeros((0, 2), dtype=np.int32),
        np.zeros((*nodes, 0, model.reduced.n_contacts), dtype=complex),
        np.zeros((*nodes, 0, len(dofs)), dtype=complex),
        model.reduced.mode_shapes[list(dofs)].astype(complex),
    )


def forces_out(
    model: Model, force_patterns: ForcePatterns | None, dofs: Sequence[int]
) -> Complexes:
    """Return the displacement of DOFs by all modes but the own one of each force, off resonance.

    Returns
    -------
    (DOFs, modes) complex ndarray
        h of x = 2 Re(h F_j exp(i (theta_j + phase_j))), F_j modal [m kg^1/2/N]; 0 where the inputs
        are modal forces, and in the paper's formulation. At the model's carriers.
    """
    reduced = model.reduced
    if force_patterns is None or reduced.formulation == "paper":
        return np.zeros((len(dofs), model.modes), dtype=complex)
    half = 0.5 * AppliedForces.of(reduced, force_patterns).on_modes[..., np.newaxis]
    moved = reduced.others_response(np.arange(model.modes), reduced.carrier, half)[..., 0]
    return np.ascontiguousarray(reduced.all_shapes[list(dofs)] @ moved.T)


def _responding(model: Model, order: Order) -> tuple[NDArray[np.intp], Complexes, float]:
    """Modes that respond to a harmonic, their D(nu), and nu."""
    reduced = model.reduced
    nu = float(np.dot(order[: model.modes], reduced.carrier))
    excluded = resonant_modes(model.modes, order, model.combinations)
    responding = np.delete(np.arange(reduced.all_shapes.shape[1]), excluded)
    return responding, reduced.modal_stiffness(nu)[:, responding], nu


def _displacement(model: Model, order: Order, rows: Sequence[int]) -> Complexes:
    """Displacement of DOFs per x_c exp(i nu t) of the contacts, (N_c, DOFs)."""
    responding, D, nu = _responding(model, order)
    B = model.reduced.modal_coupling(nu)[responding]
    shapes = model.reduced.all_shapes[rows][:, responding]
    return np.asarray(-(shapes @ np.linalg.solve(D[responding], B)).T)


def _modes_out(model: Model, rows: Sequence[int]) -> Complexes:
    """Displacement of DOFs per amplitude, (DOFs, modes)."""
    shapes = model.reduced.all_shapes[rows].astype(complex)
    moved = shapes[:, : model.modes].copy()
    for j, carrier in enumerate(CARRIERS[: model.modes]):
        responding, _, nu = _responding(model, carrier)
        D = model.reduced.modal_stiffness(nu)
        by_dampers = np.linalg.solve(D[np.ix_(responding, responding)], D[responding, j])
        moved[:, j] -= shapes[:, responding] @ by_dampers
    return moved


def _counts(response: Complexes, per_amplitude: Complexes, model: Model) -> Flags:
    """Which orders of a response (n_a, n_b, orders, signals) are not negligible, (orders,).

    Beside what the amplitudes do by themselves, (modes, signals) per unit, at most.
    """
    largest = 2.0 * model.table.amplitude_range @ np.abs(per_amplitude)
    part = np.abs(response).max(axis=(0, 1), initial=0.0)
    return np.asarray((part > NEGLIGIBLE * largest).any(axis=1))
