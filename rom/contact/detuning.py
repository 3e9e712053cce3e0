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
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

# Largest distance from the carriers, relative to them; the core keeps S_j constant beyond.
MOST_DETUNING = 0.05


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

    def friction(
        self, amplitudes: Floats, initial_guess: Complexes | None = None
    ) -> tuple[Complexes, Complexes]:
        """Return S_j and harmonics of the contacts at effective amplitudes (points, modes).

        S_j (points, modes) is NaN where the motion is not periodic. The harmonics (points, orders,
        N_c) are an initial guess for other frequencies.
        """
        size = np.abs(self.coupling_factor)
        terms = self.torus.on_more_lines(self.torus.solve(amplitudes / size, initial_guess))
        S = terms.S / (self.coupling_factor**2 / size)
        S[~terms.is_periodic] = np.nan
        return np.asarray(S), terms.P


def coupling_factor(reduced: Reduced, frequency: Floats) -> Complexes:
    """Return L_j at frequencies (..., modes) [rad/s] relative to L_j at the carrier.

    Exact if the coupling to all contacts changes by one factor, as with damping proportional to
    stiffness.
    """
    c = reduced.coupling_coefficients
    factor: Complexes = 1.0 + c[:, 0] + 1j * frequency * c[:, 1]
    return factor
