"""The modal response to contact motion, as a force back on the contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.combination import CombinationResonance, Order, resonant_modes
from slipmode.rom.reduction.reduced import Reduced


def reaction_stiffness(
    reduced: Reduced, order: Order, combinations: Sequence[CombinationResonance] = ()
) -> Complexes:
    """H_nm (N_c, N_c): what the modes respond, as a force on the contacts, to x_c exp(i nu t).

    nu = n Omega_A + m Omega_B; a mode in resonance with the harmonic has its slow flow instead.
    Nothing in the paper's formulation.
    """
    if reduced.formulation == "paper":
        return np.zeros(reduced.stiffness.shape, dtype=complex)
    nu = float(np.dot(order[: len(reduced.modes)], reduced.carrier))
    return reduced.reaction(nu, resonant_modes(len(reduced.modes), order, combinations))
