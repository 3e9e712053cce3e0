"""Whether a transient is slow: how much the amplitudes change within a cycle.

The slow flow takes friction from steady motion. That holds as long as amplitudes hardly change
from one cycle to the next; where they change by more than `LARGEST_CHANGE` of themselves in one,
it is an extrapolation. Steady states are not touched by that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.reduction.reduced import Reduced

LARGEST_CHANGE = 0.05  # within a cycle, relative


def friction_threshold(reduced: Reduced, law: Friction) -> Floats:
    """Amplitude (modes,) at which a mode alone makes its first contact slip, or open.

    Infinite for a mode that moves no contact.
    """
    on_contacts = 2.0 * np.abs(reduced.coupling)
    if reduced.contacts is not None:
        on_contacts = on_contacts * reduced.contacts.reference
    hold = np.broadcast_to(limits(law, reduced.n_contacts), on_contacts.shape)
    threshold = np.full(on_contacts.shape, np.inf)
    np.divide(hold, on_contacts, out=threshold, where=on_contacts > 0)
    return np.asarray(threshold.min(axis=1))


def change_per_cycle(
    rate: Complexes, frequency: Floats, amplitude: Complexes, threshold: Floats
) -> Floats:
    """How much amplitudes change within a cycle of their carrier, relative, at most 1.

    2 pi |da/dt| / Omega, relative to |a| or to the amplitude at which friction begins to act,
    whichever is larger: below that the slow flow is linear, and right at any rate. What would
    more than double from nothing counts as 1. Turning against the forcing is a change too.

    Parameters
    ----------
    rate, amplitude : (..., modes) complex ndarray
        da/dt and a.
    frequency : (..., modes) ndarray
        Of the carriers [rad/s].
    threshold : (..., modes) ndarray
        `friction_threshold`, times the scale of the limits where they are scripted.
    """
    change = 2.0 * np.pi * np.abs(rate) / frequency
    scale = np.maximum(np.maximum(np.abs(amplitude), threshold), change)
    return np.divide(change, scale, out=np.zeros_like(change), where=scale > 0.0)


def said_change(modes: Sequence[str], change: Floats) -> str:
    """The largest changes (modes,) in words."""
    each = ", ".join(f"|{m}| {part:.2g}" for m, part in zip(modes, 100 * change, strict=True))
    return f"amplitudes change by up to {each} % a cycle"
