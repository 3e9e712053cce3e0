"""Harmonics of a motion under steady forces, fitted by least squares to a few periods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.short_repr import frozen

# Per period of the fastest carrier: not an integer, so that harmonics do not alias onto each
# other, and samples fall on all phases of the carrier within a window.
SAMPLES_PER_PERIOD = 16.309
_APART = 0.8  # turns between two lines in a window that distinguishes them


@frozen
class HarmonicFit:
    """Fit of lines 2 Re(c exp(i nu t)) of known frequencies to signals in a window.

    The window is far shorter than one that separates lines by their spectrum. Motion at other
    frequencies changes the lines from window to window.
    """

    orders: list[Order]  # nu = n Omega_A + m Omega_B; of aliased lines the lowest order is fitted
    frequency: Floats  # nu (lines,) [rad/s]
    length: float  # of the window [s]
    samples: int
    tapered: bool = False  # less weight at the ends reduces the effect of other lines

    @classmethod
    def over(cls, periods: float, carrier: Floats, orders: Sequence[Order]) -> Self:
        """Return the fit over periods of the slowest carrier (modes,); lowest `orders` first."""
        length = 2.0 * np.pi * periods / float(carrier.min())
        samples = int(np.ceil(length * carrier.max() * SAMPLES_PER_PERIOD / (2.0 * np.pi)))
        return cls([], np.zeros(0), length, samples).with_lines(carrier, orders)

    def with_lines(self, carrier: Floats, orders: Sequence[Order]) -> Self:
        """Return the fit of other lines in the same window."""
        nu = np.array(orders, dtype=float)[:, : carrier.size] @ carrier
        turns = nu * self.length / (2.0 * np.pi)
        seen = np.abs(turns - self.samples * np.round(turns / self.samples))  # with aliasing
        kept: list[int] = []
        for k, place in enumerate(seen):
            apart = np.abs(place - seen[kept]) > _APART
            if (nu[k] == 0.0 or place > _APART) and np.all(apart):
                kept.append(k)
        return type(self)([orders[k] for k in kept], nu[kept], self.length, self.samples)

    @property
    def twice(self) -> Self:
        """The fit in a tapered window of twice the length, which separates lines as well."""
        return replace(self, length=2.0 * self.length, samples=2 * self.samples, tapered=True)

    def times(self, begin: float) -> Floats:
        """Return the sample times (samples,) [s]."""
        return begin + self.length * np.arange(1, self.samples + 1) / self.samples

    @cached_property
    def _moving(self) -> Flags:
        """All lines but the mean, which is always fitted."""
        return np.asarray(self.frequency != 0.0)

    @cached_property
    def _waves(self) -> Floats:
        """Signals of the mean, of real and of imaginary parts, (samples, columns)."""
        step = np.exp(1j * self.frequency[self._moving] * self.length / self.samples)
        # evenly spaced samples: a product takes a sixth of the time of an exponential
        turn = 2.0 * np.cumprod(np.broadcast_to(step, (self.samples, step.size)), axis=0)
        return np.hstack((np.full((self.samples, 1), 2.0), turn.real, -turn.imag))

    @cached_property
    def _weighted(self) -> Floats:
        """Waves times the weights of the samples, (samples, columns)."""
        if not self.tapered:
            return self._waves
        place = (np.arange(1, self.samples + 1) - 0.5) / self.samples
        return np.asarray(self._waves * np.sin(np.pi * place)[:, np.newaxis] ** 2)

    @cached_property
    def _factor(self) -> tuple[Floats, bool]:
        """Cholesky factor of the normal equations: distinguishable lines are well conditioned."""
        factor, lower = scipy.linalg.cho_factor(self._weighted.T @ self._waves)
        return factor, lower

    def _parts(self, signal: Floats) -> Floats:
        """Return the coefficients of the waves in a signal, (columns, outputs)."""
        return np.asarray(scipy.linalg.cho_solve(self._factor, self._weighted.T @ signal))

    def lines(self, begin: float, signal: Floats) -> Complexes:
        """Return amplitudes c (lines, outputs) in a signal (samples, outputs); the mean is 2 c."""
        parts = self._parts(signal)
        real, imaginary = np.split(parts[1:], 2)
        found = np.tile(parts[0].astype(complex), (self.frequency.size, 1))
        turned = np.exp(-1j * self.frequency[self._moving] * begin)
        found[self._moving] = (real + 1j * imaginary) * turned[:, np.newaxis]
        return found

    def nonharmonic_share(self, signal: Floats) -> float:
        """Return the RMS of a signal (samples, outputs) without its lines, relative to its RMS."""
        rest = signal - self._waves @ self._parts(signal)
        moved = np.linalg.norm(signal - signal.mean(axis=0))
        return float(np.linalg.norm(rest) / max(moved, np.finfo(float).tiny))
