"""How the coupling of modes and contacts depends on the frequency of the motion."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.reduced import Reduced


def coupling_factor(reduced: Reduced, frequency: Floats) -> Complexes:
    """How the coupling at (..., modes) [rad/s] differs from that at the carrier, a factor.

    Exact where the coupling to all contacts changes by one factor, as with damping proportional
    to stiffness.
    """
    c = coupling_coefficients(reduced)
    factor: Complexes = 1.0 + c[:, 0] + 1j * frequency * c[:, 1]
    return factor


@lru_cache(maxsize=8)
def coupling_coefficients(reduced: Reduced) -> Complexes:
    """c_k, (modes, 2): L(nu) is nearest to (1 + c_0 + i nu c_1) L(carrier)."""
    L = reduced.coupling
    rotated = 1j * reduced.carrier[:, np.newaxis] * reduced.damper
    parts = np.stack((-rotated, reduced.damper), axis=1)
    norm = np.sum(np.abs(L) ** 2, axis=1)[:, np.newaxis]
    c = np.asarray(np.einsum("jkc,jc->jk", parts, L.conj()) / np.where(norm > 0, norm, 1.0))
    c.flags.writeable = False
    return c
