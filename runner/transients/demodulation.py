"""Slow quantities of a full-order motion: amplitudes, powers, energy without fast cycles."""

from __future__ import annotations

from functools import cache
from itertools import product
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats


class _Filter(NamedTuple):
    """Weights (3, n) of the samples in the parabola that fits best around an instant.

    `tau` (n,) is their time from the instant, relative to half a window, and `phases` (n, modes)
    the angles of the carriers since the first sample.
    """

    tau: Floats
    phases: Floats
    weights: Floats

    def suits(self, tau: Floats, phases: Floats) -> bool:
        """Return whether the samples of another window have the same weights."""
        if tau.size != self.tau.size:
            return False
        largest = max(np.abs(tau - self.tau).max(), np.abs(phases - self.phases).max())
        return bool(largest <= 1e-9)  # rounding, of half a window and [rad]


def window_length(frequency: Floats) -> float:
    """Return the window [s] for carriers that have frequencies (n, modes) [rad/s] at some time.

    It is four periods of the slowest line, whose cycles the fit then separates from the slow part.
    """
    lines = np.append(frequency, np.abs(np.diff(frequency, axis=1)))
    return float(4.0 * 2.0 * np.pi / lines.min())


def slow_parts(
    time: Floats, signals: Complexes, angle: Floats, at: Floats, length: float
) -> tuple[Complexes, Complexes, Complexes]:
    """Return values, rates and second derivatives (points, k) of the slow part of signals (n, k).

    Around each instant of `at` (points,) a parabola and harmonics of the carriers are fitted,
    weighted by a smooth window of some `length` [s]. Near the ends of the signal the window is
    shifted. Times (n,) are evenly spaced, over at least `length`; `angle` (n, modes) has the
    angles of the carriers [rad].
    """
    turned, phasors = np.unwrap(angle, axis=0), np.exp(1j * angle)
    real = np.ascontiguousarray(signals).view(float)
    found = np.empty((3, at.size, real.shape[1]))
    last: _Filter | None = None
    for row, instant in enumerate(at):
        half = max(0.5 * length, length - (instant - time[0]), length - (time[-1] - instant))
        window = slice(*np.searchsorted(time, (instant - half, instant + half)))
        tau, phases = (time[window] - instant) / half, turned[window] - turned[window.start]
        if last is None or not last.suits(tau, phases):
            last = _filter(tau, phases, phasors[window], half / length)
        value, rate, second = last.weights @ real[window]
        found[:, row] = value, rate / half, 2.0 * second / half**2
    values, rates, seconds = found.view(complex)
    return values, rates, seconds


def _filter(tau: Floats, phases: Floats, phasors: Complexes, longer: float) -> _Filter:
    """Return the weights of samples, from exp(i theta) of the carriers (n, modes).

    `longer` is half the window relative to `length`: shifted windows are longer.
    """
    lines = _lines(phases.shape[1])
    turned = np.abs(lines @ phases[-1])
    # a line closer to the slow part than two bins of the window belongs to it
    separate = lines[turned > 4.0 * np.pi * longer * (tau[-1] - tau[0])]
    powers = [np.ones_like(phasors), phasors, phasors**2]
    columns = [tau**power for power in range(3)]
    for order in separate:
        parts = [powers[abs(n)][:, mode] for mode, n in enumerate(order)]
        line = prod(part.conj() if n < 0 else part for n, part in zip(order, parts, strict=True))
        columns += [line.real, line.imag]
    basis = np.array(columns)
    weighted = basis * np.cos(0.5 * np.pi * tau) ** 4
    gram, wanted = weighted @ basis.T, np.eye(len(basis), 3)
    # lines that coincide share their part
    solution = np.linalg.lstsq(gram, wanted, rcond=1e-9)[0]
    return _Filter(tau, phases, solution.T @ weighted)


@cache
def _lines(modes: int) -> NDArray[np.int64]:
    """Return the orders (lines, modes) of the fitted harmonics, to 2; one of each pair +-order."""
    every = product(range(-2, 3), repeat=modes)
    zero = modes * (0,)
    return np.array([order for order in every if order > zero and sum(map(abs, order)) <= 2])


def carrier_signal(
    displacement: Floats, velocity: Floats, angle: Floats, frequency: Floats
) -> Complexes:
    """Return the part of modal motion (n, modes) that turns with the carriers.

    Its slow part is z = a - i a' / (2 Omega), for q = a exp(i theta) + c.c.
    """
    q = displacement - 1j * velocity / frequency
    return np.asarray(0.5 * q * np.exp(-1j * angle))


def amplitudes(
    z: Complexes, rate: Complexes, second: Complexes, frequency: Floats
) -> tuple[Complexes, Complexes]:
    """Return amplitudes and da/dt (points, modes) from the slow parts of `carrier_signal`."""
    lag = -0.5j / frequency
    return z - lag * rate + lag**2 * second, rate - lag * second
