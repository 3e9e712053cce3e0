"""Whether the contacts are stiff enough against the modes that respond to them.

Modes that respond to a harmonic of the contact motion with H make a contact softer than its
stiffness K where H acts along with its motion. At H = K the structure, the resonant modes held,
would resonate with free contacts at that harmonic: nothing but friction holds them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.reduction.combination import CombinationResonance, Order, harmonic_orders
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.reduction.reduction import Reduced

# Measured on two_mass with its contact springs divided by 10, 15, 30 and 100, which gives 0.64,
# 0.79, 1.03 and 1.32: tables to 3e-3 take 10 times as long at 0.64, 100 times at 1.03; amplitudes
# are as exact as ever. On meshes, tables of 1.4 and of 3.2 were found, few of more than 10.
STRAINED = 0.5


def stiffness_loss(
    reduced: Reduced, combinations: Sequence[CombinationResonance] = ()
) -> tuple[float, Order]:
    """Largest share of a contact's stiffness that responding modes take away, and the harmonic."""
    orders = harmonic_orders(RESPONSE_ORDER, len(reduced.modes))
    reaction = reaction_stiffness(reduced, tuple(orders), tuple(combinations)).real
    inverse = np.linalg.inv(np.linalg.cholesky(reduced.stiffness))
    shares = np.linalg.eigvalsh(inverse @ reaction @ inverse.T)[:, -1]
    return float(shares.max()), orders[int(shares.argmax())]
