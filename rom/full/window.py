"""A stretch of time over which harmonics are projected out of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.short_repr import short_repr

_POWER = 8  # of sin(pi t / T): zero leakage from harmonics of the window beyond the 4th
_BINS = 12  # distance from a carrier to the next line of the spectrum, in 1 / T
_ORDER = 7  # |n| + |m| of the lines that are kept apart from the carriers
_SHORTEST, _LONGEST = 40, 1000  # window in periods of the slowest carrier
# of the fastest carrier: no whole number, so that no harmonic aliases onto a carrier and the steps
# fall on every phase of it within a window
_SAMPLES_PER_PERIOD = 32.618
_LOBE = 5  # bins that a line takes to either side
_PEAK = 1e-4  # of the largest: smaller ones count as on the lattice
_HIGHEST = {1: 60, 2: 41}  # |n| + |m| of what is looked for on the lattice, by carriers
_LOOKED, _MOST_SAMPLES = 1000, 2**20  # periods of the slowest carrier in which it is looked for
_CHUNK = 4096


@dataclass(frozen=True, eq=False)
class Elsewhere:
    """What a motion has beside the harmonics n Omega_A + m Omega_B.

    Attributes
    ----------
    share : float
        Its RMS, of that of the motion [-].
    frequency : float
        Of the strongest line in it [rad/s].
    """

    share: float
    frequency: float

    __repr__ = short_repr


@dataclass(frozen=True)
class Window:
    """Of some length, long enough to tell lines of the spectrum apart.

    Attributes
    ----------
    frequency : (modes,) ndarray
        Of the carriers [rad/s].
    forced : (modes,) ndarray
        Whether there is any force.
    length : float
        [s]
    samples : int
    """

    frequency: Floats
    forced: Flags
    length: float
    samples: int

    __repr__ = short_repr

    @classmethod
    def of(cls, excitation: Excitation, periods: float | None = None) -> Self:
        """With so many periods of the slowest carrier; by default what `_ORDER` lines need."""
        frequency = excitation.frequency[0]
        forced = np.any(excitation.patterns != 0, axis=1) & (excitation.amplitude[0] != 0)
        slowest = frequency.min()
        if periods is None:
            needed = _BINS / _line_spacing(frequency[forced] if forced.any() else frequency)
            periods = float(np.clip(needed * slowest, _SHORTEST, _LONGEST))
        length = 2 * np.pi * periods / slowest
        samples = int(np.ceil(length * frequency.max() * _SAMPLES_PER_PERIOD / (2 * np.pi)))
        return cls(frequency, forced, length, samples)

    @classmethod
    def of_lines(cls, excitation: Excitation) -> Self:
        """Long enough to see lines beside the lattice."""
        frequency = excitation.frequency[0]
        dense = frequency.max() / frequency.min() * _SAMPLES_PER_PERIOD
        return cls.of(excitation, min(float(_LOOKED), _MOST_SAMPLES / dense))

    def times(self, begin: float) -> Floats:
        """When to sample, (samples,) [s]."""
        return begin + self.length * np.arange(1, self.samples + 1) / self.samples

    @property
    def _weight(self) -> Floats:
        weight = np.sin(np.pi * np.arange(1, self.samples + 1) / self.samples) ** _POWER
        return np.asarray(weight / weight.sum())

    def project(self, time: Floats, signal: Floats, frequency: Floats) -> Complexes:
        """Amplitudes c of lines, 2 Re(c exp(i nu t)), in a signal (samples, outputs).

        (lines, outputs), at frequencies nu (lines,) [rad/s]; of the mean, nu = 0, one half.
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
        """Largest amplitude of each carrier, of any where it is not forced, (modes, 1)."""
        largest = np.abs(amplitude).max(axis=1, keepdims=True)
        return np.asarray(np.where(self.forced[:, np.newaxis], largest, largest.max()))

    def elsewhere(self, signal: Floats) -> Elsewhere:
        """What of a signal (samples, outputs) is not on the lattice, its mean apart.

        Line by line, the strongest first. Those that lie nearer to a harmonic than the window
        resolves count as that.
        """
        weight = self._weight[:, np.newaxis]
        mean = (weight * signal).sum(axis=0)
        power = (np.abs(np.fft.rfft(weight * (signal - mean), axis=0)) ** 2).sum(axis=1)
        on_lattice = self._lattice(power.size)
        left, off, strongest = power.copy(), 0.0, 0
        while left.max() > _PEAK**2 * power.max():
            peak = int(np.argmax(left))
            line = slice(max(peak - _LOBE, 0), peak + _LOBE + 1)
            if not on_lattice[peak]:
                strongest = strongest if off > 0.0 else peak
                off += left[line].sum()
            left[line] = 0.0
        share = np.sqrt(off / max(power.sum(), np.finfo(float).tiny))
        return Elsewhere(float(share), float(2.0 * np.pi * strongest / self.length))

    def _lattice(self, bins: int) -> Flags:
        """Where in the spectrum harmonics have their peaks, (bins,)."""
        highest = _HIGHEST[self.frequency.size]
        order = np.arange(-highest, highest + 1)
        n, m = np.meshgrid(order, order if self.frequency.size == 2 else [0])
        listed = np.abs(n) + np.abs(m) <= highest
        lines = n[listed] * self.frequency[0] + m[listed] * self.frequency[-1]
        place = lines * self.length / (2.0 * np.pi)
        place = np.abs(place - self.samples * np.round(place / self.samples))  # by sampling
        lattice = np.zeros(bins + 2, dtype=bool)
        for offset in (-1, 0, 1):
            lattice[np.abs(np.round(place).astype(int) + offset)] = True
        return lattice[:bins]


def _line_spacing(frequency: Floats) -> float:
    """Least distance from a carrier to another line of the spectrum [rad/s]."""
    orders = np.arange(-_ORDER, _ORDER + 1)
    n, m = np.meshgrid(orders, orders if frequency.size == 2 else [0])
    listed = np.abs(n) + np.abs(m) <= _ORDER
    lines = n[listed] * frequency[0] + m[listed] * frequency[-1]
    distance = np.abs(lines[:, np.newaxis] - frequency)
    return float(distance[distance > 1e-9 * frequency.max()].min())
