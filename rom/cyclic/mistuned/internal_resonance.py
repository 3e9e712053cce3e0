"""Harmonics of the contact forces that come close to modes of a disk: internal resonances."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.errors import Finding
from slipmode.rom.reduction.interaction.internal_resonance import InternalResonance

# Gain of a mode at a harmonic from which an internal resonance is a finding. Errors of local
# contacts were up to 0.6 % below, and 0.3 to 11 % beyond
# (tests/rom/cyclic/test_internal_resonance.py).
_MOST = 0.016


def resonance_findings(met: InternalResonance) -> list[Finding]:
    """Report an internal resonance of a disk, if local contacts are inexact there."""
    if met.gain < _MOST:
        return []
    contacts, (h, _) = "stuck" if met.stuck else "open", met.order
    reason = (
        f"{h} x {met.harmonic / h:.5g} rad/s is close to {met.mode}, {met.frequency:.5g} rad/s "
        f"with {contacts} contacts. Errors of amplitudes may be some per cent. "
        "MistunedDisk.response without local includes the resonance"
    )
    choice = "is neglected by local contacts"
    return [Finding(f"internal resonance 1:{h}", choice, reason, "warning")]


def internal_resonance(
    free: Sequence[DiameterModes],
    stuck: Sequence[DiameterModes],
    springs: Floats,
    engine_order: int,
    frequency: Floats,
    highest: int,
) -> InternalResonance:
    """Return the strongest internal resonance at forcing frequencies [rad/s].

    Parameters
    ----------
    free, stuck : sequence of DiameterModes
        Of the tuned disk with open and with stuck contacts, by nodal diameter.
    springs : (N_c,) ndarray
        k_ref of the contacts of a sector [N/m].
    engine_order : int
        E: harmonic h acts on nodal diameter h E.
    frequency : (frequencies,) ndarray
    highest : int
        The last harmonic.
    """
    found: list[InternalResonance] = []
    N = len(stuck)
    for sticks, by_diameter in ((False, free), (True, stuck)):
        for h in range(3, highest + 1, 2):
            k = h * engine_order % N
            modes = by_diameter[k]
            gain = modes.harmonic_gain(springs, h * frequency, h)
            at, family = np.unravel_index(gain.argmax(), gain.shape)
            name = f"nodal diameter {min(k, N - k)} of family {family}"
            nu, omega = float(h * frequency[at]), float(modes.frequency[family])
            found.append(
                InternalResonance(float(gain[at, family]), (h, 0), nu, omega, name, sticks)
            )
    return max(found, key=lambda each: each.gain)
