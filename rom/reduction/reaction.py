"""The modal response to contact motion, as a force back on the contacts."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.combination import CombinationResonance, Order, resonant_modes
from slipmode.rom.reduction.reduced import Reduced


@lru_cache(maxsize=8)
def reaction_stiffness(
    reduced: Reduced,
    orders: tuple[Order, ...],
    combinations: tuple[CombinationResonance, ...] = (),
) -> Complexes:
    """H_nm of harmonics (orders, N_c, N_c): what the modes respond, as a force on the contacts.

    To x_c exp(i nu t), nu = n Omega_A + m Omega_B; a mode in resonance with the harmonic has its
    slow flow instead. Nothing in the paper's formulation.
    """
    modes = len(reduced.modes)
    reaction = np.zeros((len(orders), *reduced.stiffness.shape), dtype=complex)
    if reduced.formulation == "consistent":
        held = np.zeros((len(orders), modes), dtype=bool)
        for of_order, order in zip(held, orders, strict=True):
            of_order[list(resonant_modes(modes, order, combinations))] = True
        reaction = reduced.reaction(np.array(orders)[:, :modes] @ reduced.carrier, held)
    reaction.flags.writeable = False  # it is given to everybody who asks for the same
    return reaction
