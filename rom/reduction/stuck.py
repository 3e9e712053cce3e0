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

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.reduction.nonresonant import highest_response, response
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.structure.held import Held, stuck
from slipmode.rom.structure.matrices import as_dense, projection
from slipmode.rom.structure.structure import Structure

_MOST = 128  # modes computed to reach those that follow statically
_USUAL = 1e-3  # smallest response for which `highest_response` reaches far enough


def reduce_stuck(
    structure: Structure, modes: tuple[int, ...], contacts: Elements, smallest_response: float
) -> Reduced:
    """One or two modes of the structure with its contacts stuck, and the elastic contacts."""
    if not contacts.reference.any():
        raise SlipmodeError(
            "gap: all contacts are open at rest; at least one must touch, or a static force "
            "press it (rom.preload, in scenes [preload])"
        )
    M, C, W = structure.mass, structure.damping, structure.directions
    if not all(0 <= mode < structure.n_dofs for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {structure.n_dofs - 1}, got {modes}")
    held = stuck(structure, contacts.reference)
    omega, shapes = _modes_in_reach(held, modes, smallest_response)
    rigid = omega == 0.0
    retained = np.isin(np.arange(omega.size), modes)
    if np.any(rigid & retained):
        raise SlipmodeError(
            f"modes: the first {rigid.sum()} are rigid-body modes of the stuck structure, and do "
            f"not resonate; retain others, from {rigid.sum()} on"
        )
    carrier = omega[list(modes)]
    below = (omega < carrier.min()) & ~retained
    drawn = as_dense(W.T @ shapes).T
    removed = (retained | below) & ~rigid
    X = held.solve(W)
    X -= (shapes[:, removed] / omega[removed] ** 2) @ drawn[removed]
    R = as_dense(W.T @ X)
    R = 0.5 * (R + R.T)
    inertia = projection(shapes, M, X)
    damping = np.einsum("nk,nk->k", shapes, as_dense(C @ shapes))
    soft = np.divide(1.0, contacts.reference, out=np.zeros(len(R)), where=contacts.reference > 0)
    follows = response(omega, damping, inertia, R + np.diag(soft), carrier) > smallest_response
    chosen = ~retained & (below | follows)
    every = np.hstack((shapes[:, list(modes)], shapes[:, chosen]))
    modal_damping = projection(every, C, every)
    dampers = projection(every, C, X)
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
        damping=projection(X, C, X),
        stiffness=-R,
        spring=spring,
        damper=dampers[: len(modes)],
        contact_motion=np.asarray(-contacts.reference * spring, dtype=complex),
        carried_mass=projection(X, M, X),
        nonresonant_frequency=omega[chosen],
        nonresonant_damping=own[len(modes) :].copy(),
        nonresonant_shapes=shapes[:, chosen],
        nonresonant_spring=np.where(below[chosen, np.newaxis], -drawn[chosen], 0.0),
        nonresonant_inertia=inertia[chosen],
        nonresonant_damper=dampers[len(modes) :],
        damping_coupling=0.5 * (modal_damping + modal_damping.T) - np.diag(own),
        contacts=contacts,
    )


def _modes_in_reach(
    held: Held, modes: tuple[int, ...], smallest_response: float
) -> tuple[Floats, Floats]:
    """Frequencies and modes up to the retained ones, and to where others follow statically.

    Contacts that slip have harmonics of order k that fall with k^-2, and so does what a mode at k
    times the carrier does to them beyond its static flexibility.
    """
    further = max(_USUAL / max(smallest_response, np.finfo(float).tiny), 1.0) ** 0.25
    return held.modes(max(modes) + 1, 0.0, _MOST, highest_response(1.0) * further)
