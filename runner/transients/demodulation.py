"""Slow quantities of a full-order motion: amplitudes, powers, energy without fast cycles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from math import prod
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import short_repr

PERIODS = 4.0  # of the slowest line, whose cycles the window has to take out
_ORDER = 2  # of the polynomial in time
_LINES = 2  # highest order of the harmonics of both carriers that are fitted beside it
_COINCIDE = 1e-9  # of the squares of the fit
_ALIKE = 1e-9  # of half a window, and of a radian: samples so near lie alike
_APART = 2.0  # bins of the window: lines nearer to the slow part belong to it


def window_length(frequency: Floats) -> float:
    """How long a window has to be with carriers at frequencies (n, modes) at some time [s]."""
    lines = np.append(frequency, np.abs(np.diff(frequency, axis=1)))
    return float(PERIODS * 2.0 * np.pi / lines.min())


def slow_parts(
    time: Floats, signals: Complexes, angle: Floats, at: Floats, length: float
) -> tuple[Complexes, Complexes, Complexes]:
    """Values, rates and second derivatives of signals (n, k) without what is fast in them.

    The parabola that fits best around each instant, beside harmonics of the carriers, weighted by
    a smooth window of this length; near the ends of the signal by the part of it that is left,
    made as long.

    Parameters
    ----------
    time : (n,) ndarray
        Evenly spaced, at least `length` long.
    angle : (n, modes) ndarray
        Of the carriers.
    at : (points,) ndarray
        Instants in it.

    Returns
    -------
    three (points, k) complex ndarrays
    """
    turned, turning = np.unwrap(angle, axis=0), np.exp(1j * angle)
    real = np.ascontiguousarray(signals).view(float)
    found = np.empty((3, at.size, real.shape[1]))
    last_filter: _Filter | None = None
    for row, instant in enumerate(at):
        half = max(0.5 * length, length - (instant - time[0]), length - (time[-1] - instant))
        window = slice(*np.searchsorted(time, (instant - half, instant + half)))
        tau, phases = (time[window] - instant) / half, turned[window] - turned[window.start]
        if last_filter is None or not last_filter.suits(tau, phases):
            last_filter = _Filter.of(tau, phases, turning[window], half / length)
        value, rate, second = last_filter.weights @ real[window]
        found[:, row] = value, rate / half, 2.0 * second / half**2
    values, rates, seconds = found.view(complex)
    return values, rates, seconds


@dataclass(frozen=True, eq=False)
class _Filter:
    """Weights of samples in the parabola that fits best around an instant.

    Windows after one another have the same, as long as frequencies stay and samples lie alike.

    Attributes
    ----------
    tau : (n,) ndarray
        Time from the instant, relative to half a window.
    phases : (n, modes) ndarray
        How far the carriers have turned since the first sample.
    weights : (3, n) ndarray
    """

    tau: Floats
    phases: Floats
    weights: Floats

    __repr__ = short_repr

    def suits(self, tau: Floats, phases: Floats) -> bool:
        """Whether samples lie so in a window."""
        return tau.size == self.tau.size and bool(
            np.abs(tau - self.tau).max() <= _ALIKE and np.abs(phases - self.phases).max() <= _ALIKE
        )

    @classmethod
    def of(cls, tau: Floats, phases: Floats, turning: Complexes, longer: float) -> Self:
        """From exp(i theta) `turning` of the carriers (n, modes).

        `longer` is half the window relative to the length that windows have at least.
        """
        lines = _lines(phases.shape[1])
        turned = np.abs(lines @ phases[-1])
        apart = lines[turned > _APART * 2.0 * np.pi * longer * (tau[-1] - tau[0])]
        powers = [np.ones_like(turning), turning, turning**2]
        columns = [tau**power for power in range(_ORDER + 1)]
        for order in apart:
            parts = [powers[abs(n)][:, mode] for mode, n in enumerate(order)]
            line = prod(
                part.conj() if n < 0 else part for n, part in zip(order, parts, strict=True)
            )
            columns += [line.real, line.imag]
        basis = np.array(columns)
        onto = basis * np.cos(0.5 * np.pi * tau) ** 4
        # lines that coincide share what is there
        gram, wanted = onto @ basis.T, np.eye(len(basis), _ORDER + 1)
        return cls(tau, phases, np.linalg.lstsq(gram, wanted, rcond=_COINCIDE)[0].T @ onto)


@cache
def _lines(modes: int) -> NDArray[np.int64]:
    """Orders (lines, modes) of the harmonics of the carriers that are fitted, by their sign."""
    every = product(range(-_LINES, _LINES + 1), repeat=modes)
    zero = modes * (0,)
    return np.array([order for order in every if order > zero and sum(map(abs, order)) <= _LINES])


def carrier_signal(
    displacement: Floats, velocity: Floats, angle: Floats, frequency: Floats
) -> Complexes:
    """Of modal motion (n, modes), what turns with the carriers; the slow part of it is z.

    z = a - i a' / (2 Omega), for q = a exp(i theta) + c.c.
    """
    q = displacement - 1j * velocity / frequency
    return np.asarray(0.5 * q * np.exp(-1j * angle))


def amplitudes(
    z: Complexes, rate: Complexes, second: Complexes, frequency: Floats
) -> tuple[Complexes, Complexes]:
    """Amplitudes and da/dt (points, modes) from the slow parts of `carrier_signal`."""
    lag = -0.5j / frequency
    return z - lag * rate + lag**2 * second, rate - lag * second
