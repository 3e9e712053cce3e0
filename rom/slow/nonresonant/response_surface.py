"""Response of the modes to the harmonics of the contacts, at the nodes of a friction table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import CARRIERS, resonant_modes
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model

NEGLIGIBLE = 1e-4  # relative to the largest force or displacement of the modes


@frozen
class ResponseSurface:
    """Harmonics (n, m) of the modal response over the amplitude plane, in a steady motion.

    A coefficient c_nm stands for Re(c_nm exp(i (n theta_A + m theta_B))).
    """

    orders: NDArray[np.int32]  # (orders, 2), without those that are negligible at every node
    reaction: Complexes  # (n_a, n_b, orders, N_c), force on the contacts [N]
    elastic: (
        Complexes  # (n_a, n_b, orders, DOFs), displacement by the modes off their carriers [m]
    )
    modes_out: Complexes  # (DOFs, modes), displacement per amplitude [kg^-1/2]


def response_surface(model: Model, dofs: Sequence[int] = ()) -> ResponseSurface:
    """Return the response for contact motion and displacements of DOFs, at the model's carriers.

    A model without harmonics is refused if modes respond to them.
    """
    reduced, rows = model.reduced, list(dofs)
    nodes = model.table.node_a.size, model.table.node_b.size
    contacts = reduced.n_contacts
    if reduced.formulation == "paper":
        return no_response(model, rows)
    if model.harmonics is None:
        raise SlipmodeError(
            "contact: this model has no harmonics of the contacts, which its modes respond to; "
            f"tabulate it with harmonics={RESPONSE_ORDER}"
        )
    orders = model.harmonics.orders
    P = model.harmonics.P.reshape(*nodes, len(orders), contacts)
    nu = np.array(orders, dtype=float)[:, : model.modes] @ reduced.carrier
    held = resonant_modes(model.modes, orders, model.combinations)
    q = -reduced.response(nu, reduced.modal_coupling(nu), held)
    force = reaction_stiffness(reduced, tuple(orders), model.combinations)
    reaction = 2.0 * np.einsum("abqc,qce->abqe", P, force)
    elastic = 2.0 * np.einsum("abqc,dk,qkc->abqd", P, reduced.all_shapes[rows], q, optimize=True)
    if (of_dofs := model.dof_response) is not None:
        moved = of_dofs.coordinates.P @ of_dofs.shapes[:, rows]
        elastic += 2.0 * moved.reshape(elastic.shape)
    modes_out = _modes_out(model, rows)
    kept = _counts(reaction, reduced.coupling, model) | _counts(elastic, modes_out.T, model)
    return ResponseSurface(
        np.array(orders, dtype=np.int32)[kept],
        np.ascontiguousarray(reaction[:, :, kept]),
        np.ascontiguousarray(elastic[:, :, kept]),
        modes_out,
    )


def no_response(model: Model, dofs: Sequence[int] = ()) -> ResponseSurface:
    """Return the response of modes that move at their carriers alone."""
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
    """Return h (DOFs, modes) of x = 2 Re(h F_j exp(i (theta_j + phase_j))) [m kg^1/2/N].

    It is the displacement of DOFs by all modes but the own one of each modal force F_j, off
    resonance, at the model's carriers; 0 without patterns, and in the paper's formulation.
    """
    reduced = model.reduced
    if force_patterns is None or reduced.formulation == "paper":
        return np.zeros((len(dofs), model.modes), dtype=complex)
    if model.dof_response is not None:
        by_force = model.dof_response.by_force @ model.dof_response.shapes[:, list(dofs)]
        return np.ascontiguousarray(by_force.T)
    moved = AppliedForces.of(reduced, force_patterns).off_resonance
    return np.ascontiguousarray(reduced.all_shapes[list(dofs)] @ moved.T)


def _modes_out(model: Model, rows: Sequence[int]) -> Complexes:
    """Return the displacement of DOFs per amplitude, (DOFs, modes)."""
    reduced, own = model.reduced, np.arange(model.modes)
    by_dampers = reduced.modal_stiffness(reduced.carrier)[own, :, own, np.newaxis]
    held = resonant_modes(model.modes, CARRIERS[: model.modes], model.combinations)
    moved = reduced.response(reduced.carrier, by_dampers, held)[..., 0]
    moved[own, own] -= 1.0
    return np.asarray(-reduced.all_shapes[rows] @ moved.T)


def _counts(response: Complexes, per_amplitude: Complexes, model: Model) -> Flags:
    """Return which orders of a response (n_a, n_b, orders, signals) are not negligible, (orders,).

    It is relative to the largest response of the modes, `per_amplitude` (modes, signals).
    """
    largest = 2.0 * model.table.amplitude_range @ np.abs(per_amplitude)
    part = np.abs(response).max(axis=(0, 1), initial=0.0)
    return np.asarray((part > NEGLIGIBLE * largest).any(axis=1))
