"""Structural damping i K'' of a reduced model.

Harmonics respond with K + i K'' at each frequency. The slow flow, rigid contacts and
time integration have the equivalent viscous damping K'' / nu, which dissipates as much per cycle
at the frequency nu. This is the carrier for a retained mode and what it moves, and the natural
frequency for another mode.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.matrices import projection
from slipmode.rom.structure.structure import Structure

if TYPE_CHECKING:
    from slipmode.rom.reduction.reduced import Reduced


def with_structural_damping(reduced: Reduced, structure: Structure) -> Reduced:
    """Return a model with the structural damping of its structure."""
    if structure.loss is None:
        return reduced
    if reduced.formulation == "paper":
        raise SlipmodeError(
            "formulation: must be 'consistent' for structural damping (complex stiffness or a "
            "loss factor); or use rom.Rayleigh.from_loss_factor"
        )
    shapes = np.hstack((reduced.all_shapes, reduced.contact_shapes))
    loss = projection(shapes, structure.loss, shapes)
    loss = 0.5 * (loss + loss.T)
    size = np.sqrt(np.abs(np.outer(np.diag(loss), np.diag(loss))))
    loss[np.abs(loss) <= 1e-11 * size] = 0.0  # rounding
    dampers = _equivalent(loss, reduced, reduced.carrier)
    return replace(reduced, loss=loss, **_added(reduced, dampers))


def dampers_at(reduced: Reduced, carrier: Floats) -> dict[str, Any]:
    """Return the damping arrays of a model at other carriers, (modes,) [rad/s]."""
    if reduced.loss is None:
        return {}
    now = _equivalent(reduced.loss, reduced, reduced.carrier)
    return _added(reduced, _equivalent(reduced.loss, reduced, carrier) - now)


def without_loss(reduced: Reduced) -> tuple[Reduced, Floats]:
    """Return a model with its viscous damping alone, and the structural damping."""
    if reduced.loss is None:
        size = reduced.all_shapes.shape[1] + reduced.n_contacts
        return reduced, np.zeros((size, size))
    dampers = _equivalent(reduced.loss, reduced, reduced.carrier)
    return replace(reduced, loss=None, **_added(reduced, -dampers)), reduced.loss


def beside_equivalent(reduced: Reduced, nu: Floats) -> tuple[Complexes, Complexes, Complexes]:
    """Return what i K'' is beside its equivalent damping: on modes, with contacts, on contacts.

    `nu` (..., 1, 1) are frequencies [rad/s].
    """
    modes = reduced.all_shapes.shape[1]
    if reduced.loss is None:
        zero = np.zeros((1, 1), dtype=complex)
        return zero, zero, zero
    equivalent = _equivalent(reduced.loss, reduced, reduced.carrier)
    rest = np.asarray(1j * (np.sign(nu) * reduced.loss - nu * equivalent), dtype=complex)
    return rest[..., :modes, :modes], rest[..., :modes, modes:], rest[..., modes:, modes:]


def _equivalent(loss: Floats, reduced: Reduced, carrier: Floats) -> Floats:
    """Return viscous damping for `loss`, on all modes and contact shapes."""
    count, mean = carrier.size, float(np.exp(np.log(carrier).mean()))
    others = reduced.nonresonant_frequency
    others = np.where(others > 0.0, others, mean)  # rigid-body modes
    nu = np.concatenate((carrier, others, np.full(reduced.n_contacts, mean)))
    between = np.sqrt(np.outer(nu, nu))
    between[:count, count:] = carrier[:, np.newaxis]
    between[count:, :count] = carrier
    return np.asarray(loss / between)


def _added(reduced: Reduced, dampers: Floats) -> dict[str, Any]:
    """Return the damping arrays with additional `dampers` on all modes and contact shapes."""
    modes, count = reduced.all_shapes.shape[1], len(reduced.modes)
    between, to_contacts = dampers[:modes, :modes], dampers[:modes, modes:]
    own = np.diag(between)
    return {
        "modal_damping": reduced.modal_damping + own[:count],
        "nonresonant_damping": reduced.nonresonant_damping + own[count:],
        "damping_coupling": reduced.damping_coupling + between - np.diag(own),
        "damper": reduced.damper + to_contacts[:count],
        "nonresonant_damper": reduced.nonresonant_damper + to_contacts[count:],
        "damping": reduced.damping + dampers[modes:, modes:],
    }
