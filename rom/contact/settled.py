"""Whether the contacts and the modes that respond to them have come to a periodic motion."""

from __future__ import annotations

from collections.abc import Sequence

from slipmode.rom.contact.friction_terms import ContactTerms
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.reaction import strongest_resonance
from slipmode.rom.reduction.reduction import Reduced

UNSETTLED = 0.05  # distance from periodicity above which a solution is worth nothing


def check_settled(
    reduced: Reduced, combinations: Sequence[CombinationResonance], terms: ContactTerms
) -> None:
    """Refuse contact terms that no search has brought to a periodic motion.

    Raises
    ------
    UnsettledError
        Naming the mode that responds most, and to which harmonic.
    """
    off = float(terms.residual.max())
    if off <= UNSETTLED:
        return
    met = strongest_resonance(reduced, terms.orders, combinations)
    n, m = met.order
    part = f"{off:.0%}" if off <= 1.0 else "more than itself"
    rigid = "let contacts be elastic while they stick (rom.Jenkins), " * (reduced.contacts is None)
    raise UnsettledError(
        f"contacts: the modes' response to them does not settle, it is off by {part}; most of "
        f"it is that of the mode at {met.mode:.4g} rad/s to harmonic ({n}, {m}) at "
        f"{met.harmonic:.4g} rad/s: {rigid}retain that mode, move the forcing away from it, give "
        "it damping, lower the largest amplitudes, or integrate in time (rom.full)"
    )
