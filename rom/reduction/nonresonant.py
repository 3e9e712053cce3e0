"""Modes, besides the retained ones, whose response to the contacts is not static.

A mode that is not retained follows the contacts with its static flexibility and its inertia. The
rest of its response to contact motion at a harmonic nu is a force on the contacts of
nu^4 m m^T / (omega^2 - nu^2 + i gamma nu) per displacement, m = phi^T M X.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import projection
from slipmode.rom.structure.structure import Structure

RESPONSE_ORDER = 5  # |n| + |m| of the harmonics that modes respond to
# Modes above twice the highest of these harmonics of the carrier may follow statically.
STATIC_FROM = 2.0 * RESPONSE_ORDER
MOST_MODES = 128  # to compute, up to that frequency
# Highest |n| + |m|, by modes, of the harmonics that decide which modes are kept, as high as those
# of a direct steady state. A light mode at the 27th harmonic changed one by 0.1 %
# (drawn structures of `make bench-errors`).
HIGHEST_HARMONIC = {1: 31, 2: 17}
_DRIFT = 0.1  # distance of the forcing from the carriers, relative to them


def static_from(smallest_response: float) -> float:
    """Return the frequency from which modes follow statically, relative to the highest retained.

    Harmonics of order k of slipping contacts fall with k^-2, and with k^-2 the response of a mode
    at k times the carrier beyond its static flexibility. For a smallest response of 1e-3, modes up
    to twice the harmonics of a table are enough.
    """
    further = 1e-3 / max(smallest_response, np.finfo(float).tiny)
    return STATIC_FROM * float(max(further, 1.0) ** 0.25)


@frozen
class StuckModes:
    """Modes of a structure with stuck contacts, from which those of a reduced model are chosen."""

    structure: Structure
    frequency: Floats  # (k,) [rad/s]
    shapes: Floats  # (n, k), mass-normalised [kg^-1/2]
    retained: tuple[int, ...]  # modes with a slow flow

    def arrays(self, X: Floats, nonresonant: Flags) -> dict[str, Any]:
        """Return the fields of `Reduced` that follow from modes and contact shapes X (n, N_c).

        `nonresonant` (k,) selects the modes without a slow flow that respond.
        """
        M, C, count = self.structure.mass, self.structure.damping, len(self.retained)
        chosen = [*self.retained, *np.flatnonzero(nonresonant).tolist()]
        omega, shapes = self.frequency[chosen], self.shapes[:, chosen]
        damping, damper = projection(shapes, C, shapes), projection(shapes, C, X)
        own = np.diag(damping)
        return {
            "formulation": "consistent",
            "modes": self.retained,
            "frequency": omega[:count],
            "carrier": omega[:count],
            "modal_damping": own[:count].copy(),
            "mode_shapes": shapes[:, :count],
            "contact_shapes": X,
            "damping": symmetric(projection(X, C, X)),
            "damper": damper[:count],
            "nonresonant_frequency": omega[count:],
            "nonresonant_damping": own[count:].copy(),
            "nonresonant_shapes": shapes[:, count:],
            "nonresonant_inertia": projection(shapes[:, count:], M, X),
            "nonresonant_damper": damper[count:],
            "damping_coupling": without_rounding(symmetric(damping) - np.diag(own), own),
        }


def with_responding(
    reduced: Reduced, allowed: float, highest: int = RESPONSE_ORDER
) -> tuple[Reduced, float]:
    """Return the model without the modes that respond least, and the sum of their responses.

    The modes that are left out follow statically, with the contact stiffness or flexibility. Modes
    below the retained ones, which are coupled by springs, stay. `allowed` is the upper bound of
    the sum, of responses to harmonics up to the order `highest`, see `response`, and to the force
    patterns.
    """
    stiffness = reduced.stiffness
    if reduced.contacts is not None:
        stiffness = reduced.contacts.flexibility - stiffness
    force = response(
        reduced.nonresonant_frequency,
        reduced.nonresonant_damping,
        reduced.nonresonant_inertia,
        stiffness,
        reduced.carrier,
        highest,
    )
    force += _response_to_forces(reduced)
    force[np.any(reduced.nonresonant_spring != 0.0, axis=1)] = np.inf
    weakest = np.argsort(force, kind="stable")
    total = np.cumsum(force[weakest])
    dropped = weakest[total <= allowed]
    if not dropped.size:
        return reduced, 0.0
    kept = np.ones(force.size, dtype=bool)
    kept[dropped] = False
    every = np.append(np.ones(len(reduced.modes), dtype=bool), kept)
    loss = reduced.loss
    if loss is not None:
        rows = np.append(every, np.ones(reduced.n_contacts, dtype=bool))
        loss = loss[np.ix_(rows, rows)]
    few = replace(
        reduced,
        nonresonant_frequency=reduced.nonresonant_frequency[kept],
        nonresonant_damping=reduced.nonresonant_damping[kept],
        nonresonant_shapes=reduced.nonresonant_shapes[:, kept],
        nonresonant_spring=reduced.nonresonant_spring[kept],
        nonresonant_inertia=reduced.nonresonant_inertia[kept],
        nonresonant_damper=reduced.nonresonant_damper[kept],
        damping_coupling=reduced.damping_coupling[np.ix_(every, every)],
        loss=loss,
    )
    return few, float(total[dropped.size - 1])


def response(
    omega: Floats,
    damping: Floats,
    inertia: Floats,
    stiffness: Floats,
    carrier: Floats,
    highest: int,
) -> Floats:
    """Return the largest force of each mode on the contacts, relative to theirs, (modes,).

    The force at the harmonic nu is relative to the force of the contact stiffness for this motion,
    nu^4 m^T K^-1 m / |omega^2 - nu^2 + i gamma nu|. Harmonics of order k are weighted by 1 / k^2,
    at the frequency within 10 % that is nearest to the mode, up to the order `highest`.

    Natural frequencies [rad/s] and modal damping [1/s] are (modes,), inertia m = phi^T M X is
    (modes, N_c) [kg^1/2]; the stiffness (N_c, N_c) is that of the contact problem [N/m].
    """
    orders = np.array(harmonic_orders(highest, carrier.size))
    weight = 1.0 / np.abs(orders).sum(axis=1) ** 2
    centre = np.abs(orders[:, : carrier.size] @ carrier)
    nu = np.clip(omega[:, np.newaxis], (1.0 - _DRIFT) * centre, (1.0 + _DRIFT) * centre)
    dynamic = np.abs(omega[:, np.newaxis] ** 2 - nu**2 + 1j * damping[:, np.newaxis] * nu)
    share = np.einsum("kc,ck->k", inertia, np.linalg.solve(stiffness, inertia.T))
    # The response of an undamped mode at a harmonic is limited to a number.
    least = np.finfo(float).eps * omega[:, np.newaxis] ** 2 + np.finfo(float).tiny
    return np.asarray(share * (weight * nu**4 / np.maximum(dynamic, least)).max(axis=1))


def frictionless_force(reduced: Reduced) -> Floats:
    """Return |S_j| / |a_j| of contacts without friction, (modes,) [rad^2/s^2]."""
    if reduced.contacts is None:
        moved = np.linalg.solve(reduced.stiffness, reduced.coupling.T)
    else:
        moved = reduced.contacts.reference[:, np.newaxis] * reduced.coupling.T
    return np.asarray(np.abs(np.einsum("jc,cj->j", reduced.coupling, moved)))


def _response_to_forces(reduced: Reduced) -> Floats:
    """Return the largest force of each nonresonant mode on the contacts due to the force patterns.

    It is relative to the force of the retained mode, (nonresonant,), at its carrier. The forces
    are as large as the contacts without friction need.
    """
    found = np.zeros(reduced.nonresonant_frequency.size)
    if reduced.force_patterns is None or not reduced.n_contacts:
        return found
    applied = AppliedForces(reduced, reduced.force_patterns).on_modes
    D, B = reduced.modal_stiffness(reduced.carrier), reduced.modal_coupling(reduced.carrier)
    for j, largest in enumerate(frictionless_force(reduced)):
        own, modes = np.linalg.norm(reduced.coupling[j]), slice(len(reduced.modes), None)
        moved = np.abs(applied[j, modes] / np.diag(D[j])[modes]) * largest
        force = moved * np.linalg.norm(B[j, modes], axis=1)
        found = np.maximum(found, np.divide(force, own, out=0.0 * force, where=own > 0.0))
    return found


def symmetric(matrix: Floats) -> Floats:
    """Return the symmetric part of a matrix."""
    return 0.5 * (matrix + matrix.T)


def without_rounding(matrix: Floats, scale: Floats) -> Floats:
    """Return the matrix with 0 for entries that are rounding against diagonal entries (n,)."""
    size = np.sqrt(np.abs(np.outer(scale, scale)))
    return np.where(np.abs(matrix) <= 1e-9 * size, 0.0, matrix)
