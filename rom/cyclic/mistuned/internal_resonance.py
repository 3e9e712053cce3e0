"""Harmonics of the contact forces that come close to modes of a disk: internal resonances."""

from __future__ import annotations

from slipmode.rom.common import Finding
from slipmode.rom.reduction import InternalResonance

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
