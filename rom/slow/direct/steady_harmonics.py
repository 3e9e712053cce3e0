"""Harmonics of a steady state, and what errors of its amplitudes are relative to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr

_WEAK = 0.1  # contact motion of a mode, of the strongest's: its error is relative to that below


@dataclass(frozen=True, eq=False)
class SteadyHarmonics:
    """Harmonics 2 Re(c_nm exp(i (n t_A + m t_B))) of a steady state, the carriers first.

    Attributes
    ----------
    amplitude : (modes,) complex ndarray
        a_j of the retained modes at their carriers [kg^1/2 m].
    orders : list of (n, m)
    frequency : (orders,) ndarray
        n Omega_A + m Omega_B [rad/s].
    modal : (orders, modes + nonresonant) complex ndarray
        Displacement of all modes [kg^1/2 m].
    P : (orders, N_c) complex ndarray
        Of the contact displacement [m].
    """

    amplitude: Complexes
    orders: list[Order]
    frequency: Floats
    modal: Complexes
    P: Complexes

    __repr__ = short_repr


def relative_error(reduced: Reduced, error: Complexes | Floats, amplitude: Complexes) -> float:
    """The largest of errors (modes,) of amplitudes, by the contact motion that they bring."""
    moves = np.linalg.norm(reduced.coupling, axis=1)
    motion = moves * np.abs(amplitude)
    scale = np.maximum(motion, _WEAK * motion.max())
    return float((moves * np.abs(error) / np.maximum(scale, np.finfo(float).tiny)).max())
