"""Modes whose contacts, if any, are known by their response alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import Elements
from slipmode.rom.reduction.reduced import REDUCED_ARRAYS, Reduced


def modes_alone(
    frequency: Floats, damping: Floats, mode_shapes: Floats, contacts: Elements, **given: Any
) -> Reduced:
    """Return modes that respond to nothing but the forces on them and what is `given`.

    Parameters
    ----------
    frequency, damping : (modes,) ndarray
        Natural frequencies [rad/s] and modal damping [1/s].
    mode_shapes : (n, modes) ndarray
        [kg^-1/2]
    contacts : Elements
        Elastic contacts.
    **given : ndarray
        Other arrays of `Reduced`, 0 by default; the carriers are the natural frequencies.
    """
    modes, size = frequency.size, contacts.reference.size
    further = len(given.get("nonresonant_frequency", ()))
    sizes = {"m": modes, "q": modes + further, "n": len(mode_shapes), "c": size, "p": further}
    arrays: dict[str, Any] = {
        name: np.zeros([sizes[axis] for axis in axes]) for name, axes in REDUCED_ARRAYS.items()
    }
    arrays |= {"frequency": frequency, "carrier": frequency, "modal_damping": damping}
    arrays |= {"mode_shapes": mode_shapes.copy()} | given
    arrays["contact_motion"] = arrays["contact_motion"].astype(complex)
    return Reduced("consistent", tuple(range(modes)), contacts=contacts, **arrays)
