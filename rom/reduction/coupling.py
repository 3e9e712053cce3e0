"""How the coupling of modes and contacts depends on the frequency of the motion."""

from __future__ import annotations

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.reduced import Reduced


def coupling_factor(reduced: Reduced, frequency: Floats) -> Complexes:
    """How the coupling at (..., modes) [rad/s] differs from that at the carrier, a factor.

    Exact where the coupling to all contacts changes by one factor, as with damping proportional
    to stiffness.
    """
    c = reduced.coupling_coefficients
    factor: Complexes = 1.0 + c[:, 0] + 1j * frequency * c[:, 1]
    return factor
