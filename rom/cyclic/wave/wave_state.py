"""Steady states and limit cycles of a wave, and their stability."""

from __future__ import annotations

from functools import cached_property
from typing import Self

from slipmode.rom.arrays import Complexes
from slipmode.rom.cyclic.wave.stability.pair_stability import CriticalPair, critical_pair
from slipmode.rom.cyclic.wave.wave_balance import Balanced
from slipmode.rom.short_repr import frozen


@frozen
class WaveState:
    """Hold a travelling wave in a steady state or limit cycle.

    The free DOFs of sector j move as 2 Re(c exp(i (Omega t + k 2 pi j / N))).

    Attributes
    ----------
    amplitude : complex
        Amplitude a of the mode [kg^1/2 m].
    error : float
        Estimated error of |a| due to time steps: change by half as many, and residual of the
        equations with four times as many [kg^1/2 m].
    frequency : float
        Frequency Omega of the force or of the limit cycle [rad/s].
    displacement : (n_s,) complex ndarray
        Harmonics c of the free DOFs of sector 0 at this frequency [m].
    balanced : Balanced
        Contact problem at this amplitude and frequency.
    """

    amplitude: complex
    error: float
    frequency: float
    displacement: Complexes
    balanced: Balanced

    @classmethod
    def of(cls, found: Balanced) -> Self:
        """Return the state of a balanced wave.

        Parameters
        ----------
        found : Balanced
            Solution of the balance of mode, contacts and force.

        Returns
        -------
        WaveState
            State with its displacements.
        """
        balance, a = found.balance, found.amplitude
        shown = balance.displacement(a)
        return cls(a, found.error, balance.carrier.frequency, shown, found)

    @cached_property
    def critical_pair(self) -> CriticalPair:
        """Pair of waves n and 2 k - n with the largest growth rate in the presence of this wave.

        All pairs of the family are computed at first access, in a slow flow of first order.

        Raises
        ------
        UnsettledError
            If no periodic contact motion is found.
        """
        return critical_pair(self.balanced.balance, abs(self.amplitude))

    @property
    def stable(self) -> bool:
        """Whether small waves of all nodal diameters of the family decay."""
        return self.critical_pair.growth < 0.0
