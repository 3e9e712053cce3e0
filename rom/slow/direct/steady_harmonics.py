"""Harmonics of a steady state, and relative errors of its amplitudes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import Record

# Contact motion relative to the strongest mode's; errors of weaker modes are relative to it.
_WEAK = 0.1


@dataclass(frozen=True, eq=False, repr=False)
class SteadyHarmonics(Record):
    """Harmonics 2 Re(c_nm exp(i (n t_A + m t_B))) of a steady state, the carriers first."""

    amplitude: Complexes  # (modes,), a_j of the retained modes at their carriers [kg^1/2 m]
    orders: list[Order]
    frequency: Floats  # (orders,), n Omega_A + m Omega_B [rad/s]
    modal: Complexes  # (orders, modes + nonresonant), displacement of all modes [kg^1/2 m]
    P: Complexes  # (orders, N_c), of the contact displacement [m]


def relative_error(reduced: Reduced, error: Complexes | Floats, amplitude: Complexes) -> float:
    """Return the largest error (modes,) of amplitudes, relative to their contact motion."""
    moves = np.linalg.norm(reduced.coupling, axis=1)
    motion = moves * np.abs(amplitude)
    scale = np.maximum(motion, _WEAK * motion.max())
    return float((moves * np.abs(error) / np.maximum(scale, np.finfo(float).tiny)).max())
