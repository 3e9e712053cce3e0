"""Reduction about the stuck structure, whose elastic contacts are springs.

With K_s = K + W diag(k_ref) W^T, modes phi_j of (K_s, M) and the force deficit of the contacts
against these springs, y = k_ref x_c - f,

    x = sum_j phi_j q_j + X y,   X = (K_s^-1 - sum phi phi^T / omega^2) W,
    x_c = W^T x = sum_j W^T phi_j q_j + R y + ...,   R = W^T X,

with the sum over the retained modes. This is the dual of the bonded problem: y replaces the
contact displacement, -R the contact stiffness and -W^T phi_j the coupling, and the harmonics obey
the same equations. Bonded contacts are its limit.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.reduction.nonresonant import MOST_MODES, StuckModes, static_from, symmetric
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.structure.held import stuck
from slipmode.rom.structure.matrices import as_dense, projection
from slipmode.rom.structure.structure import Structure

# Residual flexibility that is rounding, relative to the static flexibility: it is a difference of
# the latter. The matrix is positive semidefinite, so its other entries in that row are at most
# 1e-6 of the static ones.
_ROUNDING = 1e-12


def reduce_stuck(
    structure: Structure, modes: tuple[int, ...], contacts: Elements, smallest_response: float
) -> Reduced:
    """Return one or two modes of the structure with stuck contacts, and the elastic contacts."""
    if not contacts.reference.any():
        raise SlipmodeError(
            "gap: all contacts are open at rest, and at least one must touch; reduce a gap, or "
            "close it by a static force (rom.preload, in scenes [preload])"
        )
    if not all(0 <= mode < structure.n_modes for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {structure.n_modes - 1}, got {modes}")
    held, W = stuck(structure, contacts.reference), structure.directions
    omega, shapes = held.modes(max(modes) + 1, MOST_MODES, static_from(smallest_response))
    rigid = omega == 0.0
    retained = np.isin(np.arange(omega.size), modes)
    if np.any(rigid & retained):
        raise SlipmodeError(
            f"modes: the first {rigid.sum()} are rigid-body modes of the stuck structure, which "
            f"have no resonance; retain modes from {rigid.sum()} on"
        )
    below = (omega < omega[retained].min()) & ~retained
    contact_motion = as_dense(W.T @ shapes).T  # (k, N_c) per modal amplitude
    removed = (retained | below) & ~rigid
    X = held.solve(W)
    static = np.diag(as_dense(W.T @ X))
    X -= (shapes[:, removed] / omega[removed] ** 2) @ contact_motion[removed]
    # Contacts that the removed modes alone move have no residual flexibility.
    X[:, np.diag(as_dense(W.T @ X)) <= _ROUNDING * static] = 0.0
    R = symmetric(as_dense(W.T @ X))
    found = StuckModes(structure, omega, shapes, modes)
    nonresonant = ~retained & ~rigid | below
    spring = -contact_motion[list(modes)]
    return Reduced(
        **found.arrays(X, nonresonant),
        mass=np.zeros_like(R),
        stiffness=-R,
        spring=spring,
        contact_motion=np.asarray(-contacts.reference * spring, dtype=complex),
        carried_mass=projection(X, structure.mass, X),
        nonresonant_spring=np.where(
            below[nonresonant, np.newaxis], -contact_motion[nonresonant], 0.0
        ),
        contacts=contacts,
    )
