"""How friction differs where the forcing is off the carriers: dS_j / dOmega_k.

Contacts depend on the speed of their motion only through their dampers, the velocity of tanh, and
the response of modes to their harmonics. The slow flow has the factor of the coupling already.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import TorusProblem
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.reduction.reduced import Reduced, coupling_factor
from slipmode.rom.short_repr import frozen

# Largest distance from the carriers, relative to them; the core keeps S_j constant beyond.
MOST_DETUNING = 0.05
# Largest step of the central difference, relative to a carrier. Within it the difference over the
# whole range of the forcing has the least error (tests/evidence/test_stated_errors.py).
DIFFERENCE = 0.02


@frozen
class Detuned:
    """The contact problem of forcing off the carriers.

    Attributes
    ----------
    torus : TorusProblem
        With the forcing frequencies for carriers.
    coupling_factor : (modes,) complex ndarray
        r_j of the coupling there, relative to that at the carriers.
    """

    torus: TorusProblem
    coupling_factor: Complexes

    @classmethod
    def of(cls, torus: TorusProblem, detuning: ArrayLike) -> Self:
        """Return the problem at frequencies Omega_j (1 + detuning_j)."""
        reduced = torus.problem.reduced
        if not np.any(detuning):
            return cls(torus, np.ones(len(reduced.modes), dtype=complex))
        frequency = reduced.carrier * (1.0 + np.asarray(detuning))
        moved = torus.problem.at_carriers(frequency)
        there = moved.on(torus.grid, torus.tolerance, torus.smallest_amplitude)
        return cls(there, coupling_factor(reduced, frequency))

    @property
    def reduced(self) -> Reduced:
        """Reduced matrices at the forcing frequencies."""
        return self.torus.problem.reduced

    def solve(self, amplitudes: Floats, initial_guess: Complexes | None = None) -> ContactTerms:
        """Return the contact terms at effective amplitudes (points, modes)."""
        at = amplitudes / np.abs(self.coupling_factor)
        return self.torus.on_more_lines(self.torus.solve(at, initial_guess))

    def friction(self, terms: ContactTerms) -> Complexes:
        """Return S_j (points, modes) of these terms; NaN where the motion is not periodic."""
        size = np.abs(self.coupling_factor)
        S = terms.S / (self.coupling_factor**2 / size)
        S[~terms.is_periodic] = np.nan
        return np.asarray(S)


class FrictionDetuning:
    """dS_j / dOmega_k by central differences, at any amplitudes.

    `distance` is the largest relative distance of the forcing frequencies from the carriers.
    """

    def __init__(self, torus: TorusProblem, distance: float = MOST_DETUNING) -> None:
        reduced, step = torus.problem.reduced, min(distance, DIFFERENCE)
        steps = step * np.eye(len(reduced.modes))
        self.pairs = [(Detuned.of(torus, each), Detuned.of(torus, -each)) for each in steps]
        self.step = 2.0 * step * reduced.carrier  # from one of a pair to the other [rad/s]

    def __call__(self, amplitudes: Floats) -> Complexes:
        """Return dS_j / dOmega_k [N kg^-1/2 s], (points, modes, modes) by j and k.

        0 where the motion of the contacts is not periodic.
        """
        pairs = [[each.friction(each.solve(amplitudes)) for each in pair] for pair in self.pairs]
        slope = np.array([above - below for above, below in pairs])
        slope /= self.step[:, np.newaxis, np.newaxis]
        return np.asarray(np.nan_to_num(np.moveaxis(slope, 0, -1), nan=0.0))
