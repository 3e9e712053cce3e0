"""Reduction about the stuck structure: contacts are the springs that they are while they stick.

With K_s = K + W diag(k_ref) W^T, modes phi_j of (K_s, M) and y = k_ref x_c - f the force that the
contacts fall short of these springs by,

    x = sum_j phi_j q_j + X y,   X = (K_s^-1 - sum phi phi^T / omega^2) W,
    x_c = W^T x = sum_j W^T phi_j q_j + R y + ...,   R = W^T X,

with the sum over the retained modes. It is the dual of the bonded problem: y stands for the
contact displacement, -R for the contact stiffness and -W^T phi_j for the coupling, and all that
holds for the harmonics of one holds for those of the other. Bonded contacts are its limit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.reduction.fixed_interface import lowest_modes
from slipmode.rom.reduction.nonresonant import highest_response, responding
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.structure.matrices import Matrix, as_csc, as_dense, solve
from slipmode.rom.structure.structure import Structure

_RIGID = 1e-9  # omega^2 of a rigid-body mode, relative to the stiffest DOF
_STRAINLESS = 1e-12  # strain energy of a rigid-body mode, relative to that of its DOFs alone


def reduce_stuck(
    structure: Structure, modes: tuple[int, ...], contacts: Elements, smallest_response: float
) -> Reduced:
    """One or two modes of the structure with its contacts stuck, and the elastic contacts."""
    if not contacts.reference.any():
        raise SlipmodeError(
            "gap: all contacts are open at rest; at least one must touch, or a static force "
            "press it (rom.preload, in scenes [preload])"
        )
    M, C = structure.mass, structure.damping
    W = as_dense(structure.directions)
    K = stuck_stiffness(structure, contacts.reference)
    if not all(0 <= mode < structure.n_dofs for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {structure.n_dofs - 1}, got {modes}")
    squares, shapes = _modes_in_reach(K, M, modes)
    rigid = squares <= _RIGID * K.diagonal().max() / M.diagonal().max()
    retained = np.isin(np.arange(squares.size), modes)
    if np.any(rigid & retained):
        raise SlipmodeError(
            f"modes: the first {rigid.sum()} are rigid-body modes of the stuck structure, and do "
            f"not resonate; retain others, from {rigid.sum()} on"
        )
    omega = np.sqrt(np.where(rigid, 0.0, squares))
    carrier = omega[list(modes)]
    below = (omega < carrier.min()) & ~retained
    X = _static(K, M, W, shapes[:, rigid])
    removed = (retained | below) & ~rigid
    X -= (shapes[:, removed] / squares[removed]) @ (shapes[:, removed].T @ W)
    R = W.T @ X
    R = 0.5 * (R + R.T)
    drawn = shapes.T @ W
    inertia = shapes.T @ as_dense(M @ X)
    damping = np.einsum("nk,nk->k", shapes, as_dense(C @ shapes))
    soft = np.divide(1.0, contacts.reference, out=np.zeros(len(R)), where=contacts.reference > 0)
    follows = responding(omega, damping, inertia, np.diag(R) + soft, carrier, smallest_response)
    chosen = ~retained & (below | follows)
    every = np.hstack((shapes[:, list(modes)], shapes[:, chosen]))
    modal_damping = every.T @ as_dense(C @ every)
    on_contacts = as_dense(C @ X)
    dampers = every.T @ on_contacts
    own = np.diag(modal_damping)
    spring = -drawn[list(modes)]
    return Reduced(
        formulation="consistent",
        modes=modes,
        frequency=omega[list(modes)],
        carrier=omega[list(modes)],
        modal_damping=own[: len(modes)].copy(),
        mode_shapes=shapes[:, list(modes)],
        contact_shapes=X,
        mass=np.zeros_like(R),
        damping=X.T @ on_contacts,
        stiffness=-R,
        spring=spring,
        damper=dampers[: len(modes)],
        contact_motion=np.asarray(-contacts.reference * spring, dtype=complex),
        carried_mass=X.T @ as_dense(M @ X),
        nonresonant_frequency=omega[chosen],
        nonresonant_damping=own[len(modes) :].copy(),
        nonresonant_shapes=shapes[:, chosen],
        nonresonant_spring=np.where(below[chosen, np.newaxis], -drawn[chosen], 0.0),
        nonresonant_inertia=inertia[chosen],
        nonresonant_damper=dampers[len(modes) :],
        damping_coupling=0.5 * (modal_damping + modal_damping.T) - np.diag(own),
        contacts=contacts,
    )


def stuck_stiffness(structure: Structure, reference: Floats) -> Matrix:
    """K + W diag(k_ref) W^T, dense or CSC like the structure."""
    W = structure.directions
    if isinstance(structure.stiffness, np.ndarray):
        dense = as_dense(W)
        return np.asarray(structure.stiffness + (dense * reference) @ dense.T)
    return as_csc(structure.stiffness + W @ scipy.sparse.diags_array(reference) @ W.T)


def rigid_body_modes(K: Matrix, M: Matrix) -> Floats:
    """Modes (n, count) that strain nothing beyond rounding, mass-normalised; often none."""
    size, count = K.shape[0], 8
    while True:
        count = min(count, size)
        _, shapes = _lowest(K, M, count)
        strain = np.einsum("nk,nk->k", shapes, as_dense(K @ shapes))
        rigid = np.abs(strain) <= _STRAINLESS * (K.diagonal() @ shapes**2)
        if count == size or not rigid.all():
            return shapes[:, rigid]
        count *= 2


def _modes_in_reach(K: Matrix, M: Matrix, modes: tuple[int, ...]) -> tuple[Floats, Floats]:
    """omega^2 and modes up to the retained ones, and to where others follow statically."""
    size, count = K.shape[0], max(16, max(modes) + 2)
    while True:
        count = min(count, size)
        squares, shapes = _lowest(K, M, count)
        squares = np.maximum(squares, 0.0)
        highest = highest_response(float(np.sqrt(squares[max(modes)])))
        if count == size or squares[-1] >= highest**2 or count >= 128:
            kept = max(int(np.searchsorted(squares, highest**2)), max(modes) + 1)
            return squares[:kept], shapes[:, :kept]
        count *= 2


def _lowest(K: Matrix, M: Matrix, count: int) -> tuple[Floats, Floats]:
    """The lowest omega^2 and modes, rigid-body modes among them."""
    try:
        return lowest_modes(K, M, count)
    except RuntimeError:  # rigid-body modes
        stiffest = K.diagonal().max() / M.diagonal().max()
        return lowest_modes(K, M, count, -_RIGID * stiffest)


def stuck_response(
    structure: Structure, contacts: Elements, force: Floats, rigid: Floats
) -> Floats:
    """Static displacement (n, forces) [m] with stuck contacts, less that of rigid-body modes."""
    K = stuck_stiffness(structure, contacts.reference)
    return _static(K, structure.mass, force, rigid)


def _static(K: Matrix, M: Matrix, W: Floats, rigid: Floats) -> Floats:
    """K^-1 W, (n, loads); of a structure with rigid-body modes, what is orthogonal to them."""
    if rigid.shape[1] == 0:
        return as_dense(solve(K, W))
    border = as_dense(M @ rigid)
    corner = np.zeros((rigid.shape[1], rigid.shape[1]))
    loads = np.vstack((W - border @ (rigid.T @ W), np.zeros((rigid.shape[1], W.shape[1]))))
    if isinstance(K, np.ndarray):
        held = np.block([[K, border], [border.T, corner]])
        return np.asarray(np.linalg.solve(held, loads)[: len(W)])
    edge: Any = as_csc(border)
    rows = (scipy.sparse.hstack((K, edge)), scipy.sparse.hstack((edge.T, as_csc(corner))))
    bordered = as_csc(scipy.sparse.vstack(rows))
    return as_dense(solve(bordered, loads))[: len(W)]
