"""The modal response to contact motion, as a force back on the contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.combination import CombinationResonance, Order, resonant_modes
from slipmode.rom.reduction.reduced import Reduced


def reaction_stiffness(
    reduced: Reduced, orders: Sequence[Order], combinations: Sequence[CombinationResonance] = ()
) -> Complexes:
    """H_nm of harmonics (orders, N_c, N_c): what the modes respond, as a force on the contacts.

    To x_c exp(i nu t), nu = n Omega_A + m Omega_B; a mode in resonance with the harmonic has its
    slow flow instead. Nothing in the paper's formulation.
    """
    if reduced.formulation == "paper":
        return np.zeros((len(orders), *reduced.stiffness.shape), dtype=complex)
    modes = len(reduced.modes)
    held = np.zeros((len(orders), modes), dtype=bool)
    for of_order, order in zip(held, orders, strict=True):
        of_order[list(resonant_modes(modes, order, combinations))] = True
    return reduced.reaction(np.array(orders)[:, :modes] @ reduced.carrier, held)
