"""Windows in time over which harmonics are projected out of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.harmonic_fit import SAMPLES_PER_PERIOD
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.short_repr import frozen, short_repr

_SHORTEST, _LONGEST = 40, 1000  # window, in periods of the slowest carrier
_LOBE = 5  # bins of a line on either side of its peak: its leakage ends at the 4th
_HIGHEST = {1: 60, 2: 41}  # |n| + |m| of the harmonics, by carriers
_CHUNK = 4096  # samples projected at a time


@frozen
class Nonharmonic:
    """The part of a motion at other frequencies than n Omega_A + m Omega_B."""

    share: float  # its RMS, relative to the RMS of the motion [-]
    frequency: float  # of its strongest line [rad/s]


@dataclass(frozen=True)
class Window:
    """A window that is long enough to separate lines of the spectrum."""

    frequency: Floats  # (modes,), of the carriers [rad/s]
    forced: Flags  # (modes,), whether there is a force
    length: float  # [s]
    samples: int

    __repr__ = short_repr

    @classmethod
    def of(cls, excitation: Excitation, periods: float | None = None) -> Self:
        """Return the window of so many periods of the slowest carrier.

        By default it separates the lines up to |n| + |m| = 7 from the carriers.
        """
        frequency = excitation.frequency[0]
        forced = np.any(excitation.patterns != 0, axis=1) & (excitation.amplitude[0] != 0)
        slowest = frequency.min()
        if periods is None:
            carriers = frequency[forced] if forced.any() else frequency
            distance = np.abs(harmonic_frequencies(carriers, 7)[:, np.newaxis] - carriers)
            spacing = distance[distance > 1e-9 * carriers.max()].min()
            # twelve bins from a carrier to the next line of the spectrum
            periods = float(np.clip(12 / spacing * slowest, _SHORTEST, _LONGEST))
        length = 2 * np.pi * periods / slowest
        samples = int(np.ceil(length * frequency.max() * 2 * SAMPLES_PER_PERIOD / (2 * np.pi)))
        return cls(frequency, forced, length, samples)

    @classmethod
    def of_lines(cls, excitation: Excitation) -> Self:
        """Return a window that is long enough to find lines between the harmonics."""
        frequency = excitation.frequency[0]
        samples_per_period = frequency.max() / frequency.min() * 2 * SAMPLES_PER_PERIOD
        return cls.of(excitation, min(float(_LONGEST), 2**20 / samples_per_period))

    def times(self, begin: float) -> Floats:
        """Return the sample times (samples,) [s]."""
        return begin + self.length * np.arange(1, self.samples + 1) / self.samples

    @property
    def _weight(self) -> Floats:
        # sin(pi t / T)^8: no leakage from harmonics of the window beyond the 4th
        weight = np.sin(np.pi * np.arange(1, self.samples + 1) / self.samples) ** 8
        return np.asarray(weight / weight.sum())

    def project(self, time: Floats, signal: Floats, frequency: Floats) -> Complexes:
        """Return amplitudes c (lines, outputs) of lines 2 Re(c exp(i nu t)) in a signal.

        The signal is (samples, outputs), frequencies nu are (lines,) [rad/s]. The mean, nu = 0,
        is 2 c.
        """
        weight = self._weight
        found = np.zeros((frequency.size, signal.shape[1]), dtype=complex)
        for first in range(0, self.samples, _CHUNK):
            part = slice(first, first + _CHUNK)
            turn = np.exp(-1j * np.outer(frequency, time[part]))
            found += (turn * weight[part]) @ signal[part]
        found[frequency == 0.0] *= 0.5
        return found

    def scale(self, amplitude: Complexes) -> Floats:
        """Return the largest amplitude of each carrier, of all if it is not forced, (modes, 1)."""
        largest = np.abs(amplitude).max(axis=1, keepdims=True)
        return np.asarray(np.where(self.forced[:, np.newaxis], largest, largest.max()))

    def nonharmonic(self, signal: Floats) -> Nonharmonic:
        """Return the part of a signal (samples, outputs) that is neither harmonic nor mean.

        Lines are classified from the strongest down. A line nearer to a harmonic than the window
        resolves is taken for the harmonic.
        """
        weight = self._weight[:, np.newaxis]
        mean = (weight * signal).sum(axis=0)
        power = (np.abs(np.fft.rfft(weight * (signal - mean), axis=0)) ** 2).sum(axis=1)
        harmonic = self._harmonic_bins(power.size)
        rest, other, strongest = power.copy(), 0.0, 0
        # peaks of less than 1e-4 of the largest are not classified
        while rest.max() > 1e-4**2 * power.max():
            peak = int(np.argmax(rest))
            line = slice(max(peak - _LOBE, 0), peak + _LOBE + 1)
            if not harmonic[peak]:
                strongest = strongest if other > 0.0 else peak
                other += rest[line].sum()
            rest[line] = 0.0
        share = np.sqrt(other / max(power.sum(), np.finfo(float).tiny))
        return Nonharmonic(float(share), float(2.0 * np.pi * strongest / self.length))

    def _harmonic_bins(self, bins: int) -> Flags:
        """Return where in the spectrum harmonics have their peaks, (bins,)."""
        lines = harmonic_frequencies(self.frequency, _HIGHEST[self.frequency.size])
        place = lines * self.length / (2.0 * np.pi)
        place = np.abs(place - self.samples * np.round(place / self.samples))  # with aliasing
        harmonic = np.zeros(bins + 2, dtype=bool)
        for offset in (-1, 0, 1):
            harmonic[np.abs(np.round(place).astype(int) + offset)] = True
        return harmonic[:bins]


def harmonic_frequencies(carriers: Floats, highest: int) -> Floats:
    """Return |n Omega_A + m Omega_B| with |n| + |m| <= highest, for carriers (modes,) [rad/s]."""
    orders = np.array(harmonic_orders(highest, carriers.size, even=True))
    return np.asarray(np.abs(orders[:, : carriers.size] @ carriers))
