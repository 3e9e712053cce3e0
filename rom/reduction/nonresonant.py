"""Which modes, beyond the retained ones, need more than their static flexibility.

A mode that is not retained follows the contacts with its static flexibility and its inertia. At
the harmonic nu of the contact motion, what is left of its response is a force on the contacts of
nu^4 m m^T / (omega^2 - nu^2 + i gamma nu) per displacement, m = phi^T M X.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.fixed_interface import modes_below
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.structure.matrices import as_dense, projection
from slipmode.rom.structure.structure import Structure

RESPONSE_ORDER = 5  # |n| + |m| of the harmonics that modes respond to
_FAR = 2.0  # times the highest harmonic: above, every mode follows statically
# Highest |n| + |m|, by modes, of the harmonics that decide which modes are kept, as high as in a
# direct steady state. A lightly damped mode at the 27th harmonic changed one by 0.1 %
# (tests/rom/test_stated_by_default.py, member 2).
HIGHEST_HARMONIC = {1: 31, 2: 17}
_DRIFT = 0.1  # how far the forcing may be from the carriers, relative to them


def nonresonant_modes(
    structure: Structure,
    retained: Sequence[int],
    carrier: Floats,
    contact_shapes: Floats,
    stiffness: Floats,
    smallest_response: float,
) -> tuple[Floats, Floats]:
    """Frequencies (nonresonant,) and shapes (n, nonresonant): modes that do not follow statically.

    Parameters
    ----------
    retained : sequence of int
        Bonded modes that are not asked about.
    carrier : (modes,) ndarray
        Their frequencies [rad/s].
    contact_shapes : (n, N_c) ndarray
        X, with static flexibility [-].
    stiffness : (N_c, N_c) ndarray
        Of the contact problem [N/m].
    smallest_response : float
        Largest force, see `response`, of the modes that are left out.
    """
    highest = highest_response(float(carrier.max()))
    omega, shapes = modes_below(structure, highest, max(retained) + 1)
    others = np.delete(np.arange(omega.size), list(retained))
    omega, shapes = omega[others], shapes[:, others]
    inertia = projection(shapes, structure.mass, contact_shapes)
    damping = np.einsum("nk,nk->k", shapes, as_dense(structure.damping @ shapes))
    chosen = response(omega, damping, inertia, stiffness, carrier) > smallest_response
    return omega[chosen], shapes[:, chosen]


def highest_response(carrier: float) -> float:
    """Frequency [rad/s] above which every mode follows the contacts statically."""
    return _FAR * RESPONSE_ORDER * carrier


def no_nonresonant_modes(modes: int, n_dofs: int, n_contacts: int) -> dict[str, Any]:
    """The arrays of nonresonant modes where there are none."""
    return {
        "carried_mass": np.zeros((n_contacts, n_contacts)),
        "nonresonant_frequency": np.zeros(0),
        "nonresonant_damping": np.zeros(0),
        "nonresonant_shapes": np.zeros((n_dofs, 0)),
        "nonresonant_spring": np.zeros((0, n_contacts)),
        "nonresonant_inertia": np.zeros((0, n_contacts)),
        "nonresonant_damper": np.zeros((0, n_contacts)),
        "damping_coupling": np.zeros((modes, modes)),
    }


def with_responding(reduced: Reduced, allowed: float) -> tuple[Reduced, float]:
    """Return reduced matrices without the modes that respond least, and what these amount to.

    The modes that are left out follow statically, as the contact stiffness or flexibility has it.
    Modes below the retained ones, which are coupled by springs, stay.

    Parameters
    ----------
    reduced : Reduced
        Of the consistent formulation.
    allowed : float
        Sum of the responses of the modes that are left out, at most; see `response`.
    """
    stiffness = reduced.stiffness
    if reduced.contacts is not None:
        k = reduced.contacts.reference
        soft = np.divide(1.0, k, out=np.zeros_like(k), where=k > 0.0)
        stiffness = np.diag(soft) - stiffness
    force = response(
        reduced.nonresonant_frequency,
        reduced.nonresonant_damping,
        reduced.nonresonant_inertia,
        stiffness,
        reduced.carrier,
    )
    force[np.any(reduced.nonresonant_spring != 0.0, axis=1)] = np.inf
    weakest = np.argsort(force, kind="stable")
    total = np.cumsum(force[weakest])
    dropped = weakest[total <= allowed]
    if not dropped.size:
        return reduced, 0.0
    kept = np.ones(force.size, dtype=bool)
    kept[dropped] = False
    every = np.append(np.ones(len(reduced.modes), dtype=bool), kept)
    few = replace(
        reduced,
        nonresonant_frequency=reduced.nonresonant_frequency[kept],
        nonresonant_damping=reduced.nonresonant_damping[kept],
        nonresonant_shapes=reduced.nonresonant_shapes[:, kept],
        nonresonant_spring=reduced.nonresonant_spring[kept],
        nonresonant_inertia=reduced.nonresonant_inertia[kept],
        nonresonant_damper=reduced.nonresonant_damper[kept],
        damping_coupling=reduced.damping_coupling[np.ix_(every, every)],
    )
    return few, float(total[dropped.size - 1])


def response(
    omega: Floats, damping: Floats, inertia: Floats, stiffness: Floats, carrier: Floats
) -> Floats:
    """Return the largest force of each mode on the contacts, relative to theirs, (modes,).

    Parameters
    ----------
    omega, damping : (modes,) ndarray
        Natural frequencies [rad/s] and modal damping [1/s].
    inertia : (modes, N_c) ndarray
        m_k = phi_k^T M X [kg^1/2].
    stiffness : (N_c, N_c) ndarray
        Of the contact problem [N/m].
    carrier : (retained modes,) ndarray
        [rad/s]

    Notes
    -----
    The force at the harmonic nu is relative to the force of the contact stiffness for this motion,
    nu^4 m^T K^-1 m / |omega^2 - nu^2 + i gamma nu|. Harmonics of order k are weighted by 1 / k^2,
    and taken where, within 10 %, they come closest to the mode.
    """
    orders = np.array(harmonic_orders(HIGHEST_HARMONIC[carrier.size], carrier.size))
    weight = 1.0 / np.abs(orders).sum(axis=1) ** 2
    centre = np.abs(orders[:, : carrier.size] @ carrier)
    nu = np.clip(omega[:, np.newaxis], (1.0 - _DRIFT) * centre, (1.0 + _DRIFT) * centre)
    dynamic = omega[:, np.newaxis] ** 2 - nu**2 + 1j * damping[:, np.newaxis] * nu
    share = np.einsum("kc,ck->k", inertia, np.linalg.solve(stiffness, inertia.T))
    # The response of an undamped mode at a harmonic is limited to a number.
    least = np.finfo(float).eps * omega[:, np.newaxis] ** 2 + np.finfo(float).tiny
    return np.asarray(share * (weight * nu**4 / np.maximum(np.abs(dynamic), least)).max(axis=1))
