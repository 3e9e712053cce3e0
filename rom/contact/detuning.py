"""How friction differs where the forcing is off the carriers: dS_j / dOmega_k.

Contacts do not care how fast they move but for their dampers, the velocity of tanh, and what modes
respond to their harmonics. The factor of the coupling is in the slow flow already.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.friction_terms import ContactTerms
from slipmode.rom.contact.settled import UNSETTLED
from slipmode.rom.reduction.reduced import Reduced, coupling_factor
from slipmode.rom.short_repr import short_repr

MOST_DETUNING = 0.05  # of the carriers: that of the core, which takes S_j to be the same beyond
_DIFFERENCE = 0.02  # of a carrier: over a part of that range, far above rounding

# of reduced matrices, at amplitudes (points, modes), from harmonics (points, orders, N_c) nearby
Solve = Callable[[Reduced, Floats, Complexes | None], ContactTerms]


@dataclass(frozen=True, eq=False)
class Detuned:
    """The contact problem of forcing off the carriers.

    Attributes
    ----------
    reduced : Reduced
        With the forcing frequencies for carriers.
    coupling_factor : (modes,) complex ndarray
        r_j of the coupling there, relative to that at the carriers.
    """

    reduced: Reduced
    coupling_factor: Complexes

    __repr__ = short_repr

    @classmethod
    def of(cls, reduced: Reduced, apart: ArrayLike) -> Self:
        """At frequencies so far from the carriers (modes,), relative to them."""
        frequency = reduced.carrier * (1.0 + np.asarray(apart))
        factor = coupling_factor(reduced, frequency)
        return cls(reduced.at_carrier(frequency.tolist()), factor)

    def friction(
        self, solve: Solve, amplitudes: Floats, near: Complexes | None = None
    ) -> Complexes:
        """S_j (points, modes) at effective amplitudes; NaN where contacts do not settle."""
        return self.settled(self.terms(solve, amplitudes, near))

    def terms(
        self, solve: Solve, amplitudes: Floats, near: Complexes | None = None
    ) -> ContactTerms:
        """Contact terms at effective amplitudes; the search begins with the harmonics `near`."""
        return solve(self.reduced, amplitudes / np.abs(self.coupling_factor), near)

    def settled(self, terms: ContactTerms) -> Complexes:
        """S_j (points, modes) of them; NaN where contacts do not settle."""
        size = np.abs(self.coupling_factor)
        S = terms.S / (self.coupling_factor**2 / size)
        S[terms.residual > UNSETTLED] = np.nan
        return np.asarray(S)


def detuned_problems(reduced: Reduced) -> list[Detuned]:
    """Those of which `friction_detuning` takes the difference: above, below each carrier."""
    aside = _DIFFERENCE * np.eye(len(reduced.modes))
    return [Detuned.of(reduced, sign * apart) for apart in aside for sign in (1.0, -1.0)]


def friction_detuning(
    problems: list[Detuned], carrier: Floats, solve: Solve, amplitudes: Floats
) -> Complexes:
    """dS_j / dOmega_k [N kg^-1/2 s], (points, modes, modes) by j and k; 0 where it is not known.

    Parameters
    ----------
    problems : list of Detuned
        See `detuned_problems`.
    carrier : (modes,) ndarray
        [rad/s]
    solve : callable
        Contact terms of reduced matrices at amplitudes (points, modes).
    amplitudes : (points, modes) ndarray
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    """
    S = np.array([problem.friction(solve, amplitudes) for problem in problems])
    slope = (S[0::2] - S[1::2]) / (2.0 * _DIFFERENCE * carrier[:, np.newaxis, np.newaxis])
    return np.asarray(np.nan_to_num(np.moveaxis(slope, 0, -1), nan=0.0))
