"""Steady states and limit cycles of a wave, and their stability."""

from __future__ import annotations

from functools import cached_property
from typing import Self

from slipmode.rom.arrays import Complexes
from slipmode.rom.cyclic.wave.pair_stability import CriticalPair, critical_pair
from slipmode.rom.cyclic.wave.wave_balance import Balanced
from slipmode.rom.short_repr import frozen


@frozen
class WaveState:
    """A travelling wave in a steady state or limit cycle.

    Sector j moves by 2 Re(c exp(i (Omega t + k 2 pi j / N))).

    Attributes
    ----------
    amplitude : complex
        a of the mode [kg^1/2 m].
    error : float
        Estimate of the error of |a| by time steps [kg^1/2 m].
    frequency : float
        Omega [rad/s]: of the force, or of the limit cycle.
    displacement : (n_s,) complex ndarray
        c of the free DOFs of sector 0 at this frequency [m].
    balanced : Balanced
        The wave at this amplitude and frequency.
    """

    amplitude: complex
    error: float
    frequency: float
    displacement: Complexes
    balanced: Balanced

    @classmethod
    def of(cls, found: Balanced) -> Self:
        """Return the state of a wave in balance."""
        balance, a = found.balance, found.amplitude
        shown = balance.displacement(a)
        return cls(a, found.error, balance.carrier.frequency, shown, found)

    @cached_property
    def critical_pair(self) -> CriticalPair:
        """The pair of waves n and 2 k - n that grows fastest in the presence of the wave.

        Computed at first access. All pairs of the family are tried, in a slow flow of first order.

        Raises
        ------
        UnsettledError
            If the contacts do not come to a periodic motion.
        """
        return critical_pair(self.balanced.balance, abs(self.amplitude))

    @property
    def stable(self) -> bool:
        """Whether small waves of all nodal diameters of the family decay."""
        return self.critical_pair.growth < 0.0
