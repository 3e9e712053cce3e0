"""Slow quantities of a full-order motion: amplitudes, powers, energy without fast cycles."""

from __future__ import annotations

from itertools import product

import numpy as np

from slipmode.rom.arrays import Complexes, Floats

PERIODS = 4.0  # of the slowest line, whose cycles the window has to take out
_ORDER = 2  # of the polynomial in time
_LINES = 2  # order of the harmonics of both carriers that are fitted beside it
_COINCIDE = 1e-9  # of the squares of the fit
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
    orders = range(-_LINES, _LINES + 1)
    lines = [
        order
        for order in product(orders, repeat=angle.shape[1])
        if 0 < sum(map(abs, order)) <= _LINES
    ]
    phase = np.unwrap(angle, axis=0) @ np.array(lines, dtype=float).T
    turning = np.exp(1j * phase)
    found = np.empty((3, at.size, signals.shape[1]), dtype=complex)
    for row, instant in enumerate(at):
        half = max(0.5 * length, length - (instant - time[0]), length - (time[-1] - instant))
        first, last = np.searchsorted(time, (instant - half, instant + half))
        tau = (time[first:last] - instant) / half
        weight = np.cos(0.5 * np.pi * tau) ** 4
        turned = np.abs(phase[last - 1] - phase[first])
        apart = turned > _APART * 2.0 * np.pi * (time[last - 1] - time[first]) / length
        powers = tau[:, np.newaxis] ** np.arange(_ORDER + 1)
        basis = np.hstack((powers, turning[first:last, apart]))
        onto = (weight[:, np.newaxis] * basis).conj().T
        # lines that coincide share what is there
        fit = np.linalg.lstsq(onto @ basis, onto @ signals[first:last], rcond=_COINCIDE)[0]
        found[:, row] = fit[0], fit[1] / half, 2.0 * fit[2] / half**2
    return found[0], found[1], found[2]


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
