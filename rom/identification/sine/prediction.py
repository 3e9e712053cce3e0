"""Steady amplitudes of sine tests by a law, under their measured forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen
from slipmode.rom.identification.fit import jackknife_variance
from slipmode.rom.identification.sine.levels import complex_rate, fit_level
from slipmode.rom.identification.sine.responses import SineTest
from slipmode.rom.identification.slow_laws import SlowLaw


@frozen
class SineModel:
    """A law and a modal mass [kg]."""

    law: SlowLaw
    mass: float

    def force(self, omega: Floats, amplitude: Floats, order: int) -> Floats:
        """Return the force amplitude [N] of steady motion, arrays that broadcast.

        `omega` is the forcing frequency [rad/s], `amplitude` that of the sensor, which measures
        the displacement derived `order` times. Contacts follow the displacement, so the law takes
        it as if the frequency were the natural one.
        """
        natural = self.law.frequencies(amplitude)[0]
        rate = complex_rate(self.law, amplitude * (natural / omega) ** order)
        dynamic = np.abs(rate) ** 2 - omega**2 - 2.0j * rate.real * omega
        return np.asarray(self.mass * np.abs(dynamic) * amplitude / omega**order)

    def amplitude(self, test: SineTest, order: int, end: float) -> Floats:
        """Return the steady amplitude at each frequency of a test, under its measured force.

        `end` is the end of the measured amplitudes. Of several steady amplitudes at a frequency,
        the one next to the preceding point is taken, as in a sweep.
        """
        omega, force = 2.0 * np.pi * test.frequency, np.abs(test.force)
        # Above `end`, where damping grows, no amplitude is larger than with the damping at `end`.
        loss = 2.0 * self.mass * self.law.damping_rates(np.array(end))[0]
        largest = 1.1 * max(end, float(np.max(force * omega ** (order - 1)) / loss))
        # Steps of 3 %: closer solutions, in narrow folds, are not distinguished.
        grid = np.geomspace(1e-4 * largest, largest, 300)
        above = self.force(omega[:, np.newaxis], grid, order) > force[:, np.newaxis]
        place, last = np.empty(omega.size, int), None
        for k, crossed in enumerate(above[:, 1:] != above[:, :-1]):
            places = np.flatnonzero(crossed)
            if not places.size:
                raise SlipmodeError(
                    f"tests: the law has no steady amplitude for {test.name} at "
                    f"{test.frequency[k]:g} Hz, because its damping decreases above the measured "
                    "amplitudes"
                )
            last = places[0] if last is None else places[np.argmin(np.abs(places - last))]
            place[k] = last
        low, high = grid[place], grid[place + 1]
        rising = above[np.arange(omega.size), place + 1]
        for _ in range(30):  # from 3 % to 1e-11
            middle = 0.5 * (low + high)
            upper = (self.force(omega, middle, order) > force) == rising
            low, high = np.where(upper, low, middle), np.where(upper, middle, high)
        return np.asarray(0.5 * (low + high))

    def shifted(self, change: float) -> SineModel:
        """Return the model with natural frequencies that differ by a change [rad/s]."""
        values = self.law.values.copy()
        values[1] += change
        return SineModel(replace(self.law, values=values), self.mass)


@frozen
class SinePrediction:
    """Hold the amplitudes of a sine test predicted from its measured force.

    Attributes
    ----------
    test : SineTest
        Measured test.
    frequency : float
        Natural frequency at rest, given or fitted [rad/s].
    amplitude : (points,) ndarray
        Predicted amplitudes [sensor unit].
    deviation : (points,) ndarray
        Standard deviation in a further test of this kind [sensor unit], due to the
        scatter of natural frequency, modal mass and damping between levels.
    error : float
        RMS of the difference from the measured amplitude, relative to its peak [-].
    peak_error : float
        Difference of the peaks, relative to the measured peak [-].
    """

    test: SineTest
    frequency: float
    amplitude: Floats
    deviation: Floats
    error: float
    peak_error: float


def predicted(
    test: SineTest,
    order: int,
    models: Sequence[SineModel],
    end: float,
    frequency: float | None,
) -> SinePrediction:
    """Return the prediction of a test.

    `models` are of all levels, and without each of them; `end` is the end of the measured
    amplitudes; `frequency` is the natural frequency at rest [rad/s], fitted if it is None.
    """
    best = models[0]
    if frequency is None:
        frequency = _fitted_frequency(test, order, best, end)
    change = frequency - best.law.values[1]
    sizes = np.array([each.shifted(change).amplitude(test, order, end) for each in models])
    size, measured = sizes[0], np.abs(test.response)
    # The variance of the mean of n levels times n is the variance of a level.
    deviation = size * np.sqrt(len(models) * jackknife_variance(np.log(sizes[1:])))
    return SinePrediction(
        test=test,
        frequency=frequency,
        amplitude=size,
        deviation=deviation,
        error=float(np.sqrt(np.mean((size - measured) ** 2)) / measured.max()),
        peak_error=float(size.max() / measured.max() - 1.0),
    )


def _fitted_frequency(test: SineTest, order: int, model: SineModel, end: float) -> float:
    """Return the natural frequency at rest with the least error of the amplitudes [rad/s]."""
    level, measured = fit_level(test, order, model.law), np.abs(test.response)
    near = level.frequency - complex_rate(model.law, level.amplitude).imag

    def squares(change: float) -> float:
        size = model.shifted(change).amplitude(test, order, end)
        return float(np.mean((size - measured) ** 2))

    reach = level.damping_rate  # half the half-power bandwidth
    ends = (float(near - reach), float(near + reach))
    found = scipy.optimize.minimize_scalar(squares, bounds=ends, method="bounded")
    return float(model.law.values[1] + found.x)
