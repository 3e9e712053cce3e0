"""Harmonics of the contact forces that come close to modes of a disk: internal resonances."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.errors import Finding
from slipmode.rom.short_repr import frozen

# Gain of a mode at a harmonic from which an internal resonance is a finding. Errors of local
# contacts were up to 0.6 % below, and 0.3 to 11 % beyond
# (tests/rom/cyclic/test_internal_resonance.py).
_MOST = 0.016


@frozen
class InternalResonance:
    """The mode to which a harmonic of the contact forces comes closest.

    Attributes
    ----------
    ratio : float
        `DiameterModes.harmonic_gain` of the mode.
    harmonic, nodal_diameter, family : int
        Of the forces, and of the mode; 0 is the lowest family.
    frequency, mode : float
        Forcing frequency, and natural frequency of the mode [rad/s].
    stuck : bool
        Whether the contacts stick in the mode.
    """

    ratio: float
    harmonic: int
    nodal_diameter: int
    family: int
    frequency: float
    mode: float
    stuck: bool

    def findings(self) -> list[Finding]:
        """Return the resonance as a finding, if local contacts are inexact there."""
        if self.ratio < _MOST:
            return []
        contacts = "stuck" if self.stuck else "open"
        return [
            Finding(
                subject=f"internal resonance 1:{self.harmonic}",
                choice="is neglected by local contacts",
                reason=(
                    f"{self.harmonic} x {self.frequency:.5g} rad/s is close to nodal diameter "
                    f"{self.nodal_diameter} of family {self.family}, {self.mode:.5g} rad/s with "
                    f"{contacts} contacts. Errors of amplitudes may be some per cent. "
                    "MistunedDisk.response without local includes the resonance"
                ),
                level="warning",
            )
        ]


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
            ratio = modes.harmonic_gain(springs, h * frequency, h)
            at, family = np.unravel_index(ratio.argmax(), ratio.shape)
            found.append(
                InternalResonance(
                    ratio=float(ratio[at, family]),
                    harmonic=h,
                    nodal_diameter=min(k, N - k),
                    family=int(family),
                    frequency=float(frequency[at]),
                    mode=float(modes.frequency[family]),
                    stuck=sticks,
                )
            )
    return max(found, key=lambda each: each.ratio)
