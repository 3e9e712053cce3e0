"""Whether the contacts are stiff enough against the modes that respond to them.

Modes that respond to a harmonic of the contact motion with H make a contact softer than its
stiffness K where H acts along with its motion. At H = K the structure, the resonant modes held,
would resonate with free contacts at that harmonic: nothing but friction holds them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import CombinationResonance, Order, harmonic_orders
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.representable import round_up

# Measured on two_mass with its contact springs divided by 10, 15, 30 and 100, which gives 0.64,
# 0.79, 1.03 and 1.32: tables to 3e-3 take 10 times as long at 0.64 and do not converge at 0.79;
# to 2e-2 they still do at 1.03, and amplitudes are as exact as that.
STRAINED = 0.5
_LARGEST = 0.75
_LARGEST_COARSE = 1.1
_COARSE = 0.01  # tolerance of the table from which the latter holds, mostly
_ADVISED = 0.02  # and at which it was tried up to there


def stiffness_loss(
    reduced: Reduced, combinations: Sequence[CombinationResonance] = ()
) -> tuple[float, Order]:
    """Largest share of a contact's stiffness that responding modes take away, and the harmonic."""
    shares = []
    for order in harmonic_orders(RESPONSE_ORDER, len(reduced.modes)):
        reaction = reaction_stiffness(reduced, order, combinations).real
        shares.append(
            (scipy.linalg.eigh(reaction, reduced.stiffness, eigvals_only=True)[-1], order)
        )
    share, order = max(shares)
    return float(share), order


def missing_stiffness(
    reduced: Reduced, share: float, combinations: Sequence[CombinationResonance] = ()
) -> float:
    """Springs [N/m] from each contact to the ground that would lower the loss to a share.

    They add to the stiffness K of the contacts and change nothing else: H <= share (K + springs).
    """
    return max(
        float(np.linalg.eigvalsh(reaction.real / share - reduced.stiffness)[-1])
        for reaction in (
            reaction_stiffness(reduced, order, combinations)
            for order in harmonic_orders(RESPONSE_ORDER, len(reduced.modes))
        )
    )


def check_stiffness_margin(
    reduced: Reduced, tolerance: float, combinations: Sequence[CombinationResonance] = ()
) -> None:
    """Refuse contacts that are too soft for a table of that tolerance.

    Raises
    ------
    SlipmodeError
    """
    share, (n, m) = stiffness_loss(reduced, combinations)
    largest = _LARGEST if tolerance < _COARSE else _LARGEST_COARSE
    if share <= largest:
        return
    nu = abs(float(np.dot((n, m)[: len(reduced.modes)], reduced.carrier)))
    coarser = f"a tolerance of {_ADVISED:g}, " if share <= _LARGEST_COARSE else ""
    springs = round_up(missing_stiffness(reduced, largest, combinations))
    raise SlipmodeError(
        f"stiffness: the contacts are too soft against the modes: at {nu:.3g} rad/s modes take "
        f"away {share:.0%} of their stiffness, allowed: {largest:.0%}; use {coarser}"
        f"contacts that are stiffer by {springs:g} N/m each, or time integration (rom.full)"
    )
