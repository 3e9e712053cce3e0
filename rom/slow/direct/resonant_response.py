"""Modes in resonance with a harmonic of the contacts, as additional unknowns.

The search for periodic contact motion iterates on the response of the modes, and diverges if the
response of a mode to a harmonic nu is large. Such a response q has its slow flow instead,

    2 i nu q' + D(nu) q = -B(nu) P_nu,

and moves the contacts by the given force -B^T q.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.combination import Order, resonant_modes
from slipmode.rom.reduction.interaction.internal_resonance import harmonic_decay, mode_gains
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

# Gain of a mode above which it is an unknown, and the most of them: weaker ones converge in a
# few periods.
_STRONG, _MOST = 0.1, 3
# Dynamic stiffness relative to nu^2 below which a mode is in resonance: others follow their
# harmonic, and as unknowns they stop the continuation (tests/rom/slow/branches, seed 75).
_RESONANT = 0.3


@frozen
class Resonances:
    """The strongest resonances of modes with harmonics besides the carriers.

    Attributes
    ----------
    orders : tuple of (n, m)
        Harmonics of the contact problem.
    order, mode : (resonances,) ndarray of int
        Number of the order and of the mode.
    """

    orders: tuple[Order, ...]
    order: NDArray[np.intp]
    mode: NDArray[np.intp]

    @classmethod
    def none(cls, orders: tuple[Order, ...]) -> Self:
        """Return no resonances."""
        nothing = np.zeros(0, dtype=np.intp)
        return cls(orders, nothing, nothing)

    @classmethod
    def along(cls, reduced: Reduced, orders: tuple[Order, ...], frequency: Floats) -> Self:
        """Return the strongest resonances at any of the frequencies (points, modes)."""
        modes = frequency.shape[1]
        nu = frequency @ np.array(orders)[:, :modes].T
        gain, D = mode_gains(reduced, nu, harmonic_decay(orders))
        effect = gain.max(axis=0)
        effect[(np.abs(D) > _RESONANT * nu[..., np.newaxis] ** 2).all(axis=0)] = 0.0
        effect[:modes] = 0.0  # the carriers
        strongest = np.argsort(-effect, axis=None)[:_MOST]
        strong = strongest[effect.ravel()[strongest] > _STRONG]
        return cls(orders, *np.unravel_index(strong, effect.shape))

    @property
    def numbers(self) -> NDArray[np.intp]:
        """Orders (n, m) of the resonances, (resonances, 2)."""
        return np.array(self.orders)[self.order]

    def matrices(self, reduced: Reduced) -> tuple[Floats, Complexes, Complexes]:
        """Return nu [rad/s], D (resonances, resonances) and B (resonances, N_c) at the carriers.

        They include the other modes, which follow through dampers.
        """
        nu = self.numbers[:, : len(reduced.modes)] @ reduced.carrier
        stiffness, coupling = reduced.modal_stiffness(nu), reduced.modal_coupling(nu)
        D = np.zeros((nu.size, nu.size), dtype=complex)
        B = np.zeros((nu.size, reduced.n_contacts), dtype=complex)
        for k, order in enumerate(self.order):
            alike = np.flatnonzero(self.order == order)
            own, others = self.mode[alike], np.ones(stiffness.shape[-1], dtype=bool)
            others[own] = False
            both = stiffness[k][np.ix_(others, own)]
            follow = np.linalg.solve(stiffness[k][np.ix_(others, others)], both)
            row = int(np.flatnonzero(alike == k)[0])
            D[k, alike] = stiffness[k][self.mode[k], own] - follow[:, row] @ both
            B[k] = coupling[k, self.mode[k]] - follow[:, row] @ coupling[k][others]
        return nu, D, B

    def largest(self, reduced: Reduced, amplitude_range: Floats) -> Floats:
        """Return responses (resonances,) that move contacts as modes over their range do."""
        moved = amplitude_range * np.linalg.norm(reduced.coupling, axis=1)
        *_, B = self.matrices(reduced)
        return np.asarray(moved.max() / np.linalg.norm(B, axis=1))

    def reaction(self, reduced: Reduced) -> Complexes:
        """Return the part of the reaction to the contacts by the resonances, (orders, ...)."""
        modes = len(reduced.modes)
        nu = np.array(self.orders)[:, :modes] @ reduced.carrier
        carriers = resonant_modes(modes, self.orders, ())
        held: Flags = np.zeros((nu.size, reduced.all_shapes.shape[1]), dtype=bool)
        held[:, :modes] = carriers
        held[self.order, self.mode] = True
        return reduced.reaction(nu, carriers) - reduced.reaction(nu, held)

    def force(self, B: Complexes, q: Complexes) -> Complexes:
        """Return the harmonics of the force on the contacts (orders, N_c) by responses q."""
        found = np.zeros((len(self.orders), B.shape[1]), dtype=complex)
        np.add.at(found, self.order, -q[:, np.newaxis] * B)
        return found
