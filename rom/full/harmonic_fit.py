"""Harmonics of a motion under steady forces, by least squares over a few periods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy.linalg

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.short_repr import short_repr

# Of the fastest carrier: no whole number, so that harmonics do not alias onto each other.
SAMPLES_PER_PERIOD = 16.309
_APART = 0.8  # of a turn that lines drift apart in a window which tells them apart


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """Lines c of signals, 2 Re(c exp(i nu t)), over a window.

    It is far shorter than one that separates lines by their spectrum, because it is known where
    they are. What is at other frequencies changes the lines from window to window.

    Attributes
    ----------
    orders : list of (n, m)
        nu = n Omega_A + m Omega_B. Where the window does not tell lines apart, the lowest order
        stands for them.
    frequency : (lines,) ndarray
        nu [rad/s]
    length : float
        Of the window [s].
    samples : int
    tapered : bool
        Whether ends of the window count less, so that what is at other frequencies tells less.
    """

    orders: list[Order]
    frequency: Floats
    length: float
    samples: int
    tapered: bool = False

    __repr__ = short_repr

    @classmethod
    def over(cls, periods: float, carrier: Floats, orders: Sequence[Order]) -> Self:
        """So many periods of the slowest carrier (modes,); the lowest of `orders` first."""
        length = 2.0 * np.pi * periods / float(carrier.min())
        samples = int(np.ceil(length * carrier.max() * SAMPLES_PER_PERIOD / (2.0 * np.pi)))
        return cls([], np.zeros(0), length, samples).with_lines(carrier, orders)

    def with_lines(self, carrier: Floats, orders: Sequence[Order]) -> Self:
        """In the same window."""
        nu = np.array(orders, dtype=float)[:, : carrier.size] @ carrier
        turns = nu * self.length / (2.0 * np.pi)
        seen = np.abs(turns - self.samples * np.round(turns / self.samples))  # by sampling
        kept: list[int] = []
        for k, place in enumerate(seen):
            apart = np.abs(place - seen[kept]) > _APART
            if (nu[k] == 0.0 or place > _APART) and np.all(apart):
                kept.append(k)
        return type(self)([orders[k] for k in kept], nu[kept], self.length, self.samples)

    @property
    def twice(self) -> Self:
        """The same lines in two windows, tapered: lines are as far apart as in one that is not."""
        return replace(self, length=2.0 * self.length, samples=2 * self.samples, tapered=True)

    def times(self, begin: float) -> Floats:
        """When to sample, (samples,) [s]."""
        return begin + self.length * np.arange(1, self.samples + 1) / self.samples

    @cached_property
    def _moving(self) -> Flags:
        """All lines but the mean, which is fitted even where it is not one of them."""
        return np.asarray(self.frequency != 0.0)

    @cached_property
    def _waves(self) -> Floats:
        """Of the mean, of real parts and of imaginary ones, (samples, columns)."""
        step = np.exp(1j * self.frequency[self._moving] * self.length / self.samples)
        # samples are evenly spaced: a product takes a sixth of the time of an exponential
        turn = 2.0 * np.cumprod(np.broadcast_to(step, (self.samples, step.size)), axis=0)
        return np.hstack((np.full((self.samples, 1), 2.0), turn.real, -turn.imag))

    @cached_property
    def _weighted(self) -> Floats:
        """Waves by the weights of their samples, (samples, columns)."""
        if not self.tapered:
            return self._waves
        place = (np.arange(1, self.samples + 1) - 0.5) / self.samples
        return np.asarray(self._waves * np.sin(np.pi * place)[:, np.newaxis] ** 2)

    @cached_property
    def _factor(self) -> tuple[Floats, bool]:
        """Of the normal equations: lines that are apart are well conditioned."""
        factor, lower = scipy.linalg.cho_factor(self._weighted.T @ self._waves)
        return factor, lower

    def _parts(self, signal: Floats) -> Floats:
        """Of the waves in a signal, (columns, outputs)."""
        return np.asarray(scipy.linalg.cho_solve(self._factor, self._weighted.T @ signal))

    def lines(self, begin: float, signal: Floats) -> Complexes:
        """Amplitudes c (lines, outputs) in a signal (samples, outputs); of the mean one half."""
        parts = self._parts(signal)
        real, imaginary = np.split(parts[1:], 2)
        found = np.tile(parts[0].astype(complex), (self.frequency.size, 1))
        turned = np.exp(-1j * self.frequency[self._moving] * begin)
        found[self._moving] = (real + 1j * imaginary) * turned[:, np.newaxis]
        return found

    def beside(self, signal: Floats) -> float:
        """RMS of what the lines leave of a signal (samples, outputs), over that of its motion."""
        left = signal - self._waves @ self._parts(signal)
        moved = np.linalg.norm(signal - signal.mean(axis=0))
        return float(np.linalg.norm(left) / max(moved, np.finfo(float).tiny))
