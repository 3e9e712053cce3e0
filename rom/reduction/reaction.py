"""Response of the modes to contact motion, as a force back on the contacts."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.combination import (
    CombinationResonance,
    Order,
    harmonic_orders,
    resonant_modes,
)
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reduced import Reduced

# Largest share of the contact stiffness that modes may take away without a finding. Measured on
# two_mass with its contact springs divided by 10, 15, 30 and 100 (shares 0.64, 0.79, 1.03, 1.32):
# tables to 3e-3 take 10 times as long at 0.64, 100 times at 1.03, and are as exact.
STRAINED = 0.5


@lru_cache(maxsize=8)
def reaction_stiffness(
    reduced: Reduced,
    orders: tuple[Order, ...],
    combinations: tuple[CombinationResonance, ...] = (),
) -> Complexes:
    """Return H_nm (orders, N_c, N_c): force on the contacts per harmonic of their motion.

    It is due to the response of the modes to x_c exp(i nu t), nu = n Omega_A + m Omega_B. A mode
    in resonance with the harmonic has its slow flow instead. 0 in the paper's formulation.
    """
    modes = len(reduced.modes)
    reaction = np.zeros((len(orders), *reduced.stiffness.shape), dtype=complex)
    if reduced.formulation == "consistent":
        held = resonant_modes(modes, orders, combinations)
        reaction = reduced.reaction(np.array(orders)[:, :modes] @ reduced.carrier, held)
    reaction.flags.writeable = False  # the cache returns it again
    return reaction


def stiffness_loss(
    reduced: Reduced, combinations: Sequence[CombinationResonance] = ()
) -> tuple[float, Order]:
    """Return the largest share of a contact's stiffness that modes take away, and the harmonic.

    Modes that respond to a harmonic with H soften contacts of stiffness K if H acts along with the
    contact motion. At H = K the structure, its resonant modes held, resonates with free contacts.
    """
    orders = harmonic_orders(RESPONSE_ORDER, len(reduced.modes))
    reaction = reaction_stiffness(reduced, tuple(orders), tuple(combinations)).real
    inverse = np.linalg.inv(np.linalg.cholesky(reduced.stiffness))
    shares = np.linalg.eigvalsh(inverse @ reaction @ inverse.T)[:, -1]
    return float(shares.max()), orders[int(shares.argmax())]
