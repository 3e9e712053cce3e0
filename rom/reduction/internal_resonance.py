"""Which mode, besides the retained ones, a harmonic of the contacts meets in resonance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom.reduction.combination import CombinationResonance, Order, resonant_modes
from slipmode.rom.reduction.reduced import Reduced


@dataclass(frozen=True)
class InternalResonance:
    """Harmonic (n, m) of the contact motion, and the mode that responds to it most.

    Attributes
    ----------
    order : (n, m)
    harmonic : float
        n Omega_A + m Omega_B [rad/s].
    mode : float
        Natural frequency of the mode [rad/s].
    """

    order: Order
    harmonic: float
    mode: float


def strongest_resonance(
    reduced: Reduced, orders: Sequence[Order], combinations: Sequence[CombinationResonance] = ()
) -> InternalResonance:
    """The harmonic and the mode whose response to contact motion is the largest."""
    omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
    found, largest = InternalResonance((1, 0), float(reduced.carrier[0]), float(omega[0])), -1.0
    for order in orders:
        nu = abs(float(np.dot(order[: len(reduced.modes)], reduced.carrier)))
        if nu == 0.0:
            continue
        stiffness = np.abs(np.diag(reduced.modal_stiffness(nu)))
        coupling = np.linalg.norm(reduced.modal_coupling(nu), axis=1)
        response = coupling**2 / np.maximum(stiffness, np.finfo(float).tiny)
        response[list(resonant_modes(len(reduced.modes), order, combinations))] = 0.0
        response /= sum(abs(k) for k in order) ** 2
        mode = int(np.argmax(response))
        if response[mode] > largest:
            largest = float(response[mode])
            found = InternalResonance(order, nu, float(omega[mode]))
    return found
