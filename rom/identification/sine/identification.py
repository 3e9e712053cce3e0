"""Identification of a law of the slow flow from steady sine tests of one mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from typing import Any, Literal

import numpy as np
import scipy.optimize
import scipy.special

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.first_look import LocalRates
from slipmode.rom.identification.fit import CONFIDENCE, EXPONENTS, jackknife_variance
from slipmode.rom.identification.identification import DecayBackbone
from slipmode.rom.identification.sine.levels import (
    SineLevel,
    check_level,
    complex_rate,
    fit_level,
)
from slipmode.rom.identification.sine.reading import SineTest, SineTests, checked_tests
from slipmode.rom.identification.slow_laws import LawForm, SlowLaw
from slipmode.rom.short_repr import frozen, short_list


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
                    f"tests: {test.name} has no steady amplitude at {test.frequency[k]:g} Hz by "
                    "the law; its damping falls beyond the measured amplitudes"
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
    """Steady amplitudes of a sine test predicted from its measured force.

    Attributes
    ----------
    test : SineTest
    frequency : float
        Natural frequency at rest, given or fitted [rad/s].
    amplitude : (points,) ndarray
        [sensor unit]
    deviation : (points,) ndarray
        Standard deviation in a further test of the same kind, by the scatter of natural
        frequency, modal mass and damping between levels [sensor unit].
    error : float
        RMS of the difference from the measured amplitude, relative to its peak [-].
    peak_error : float
        Difference of the peaks relative to the measured one [-].
    """

    test: SineTest
    frequency: float
    amplitude: Floats
    deviation: Floats
    error: float
    peak_error: float


@frozen
class SineIdentification:
    """A law of the slow flow identified from steady sine tests.

    Attributes
    ----------
    law : SlowLaw
        Its damping is that of steady vibration. Friction damps free vibration more, by up to 1.7 %
        in an example of `model_of_rates`.
    parameters : dict
        Value of each parameter of the law, and "modal_mass" [kg].
    deviation : dict
        Standard deviation of each by the jackknife over the levels.
    interval : dict
        95 % interval of each, (low, high).
    unidentified : tuple of str
        Parameters with intervals that are wider on each side than their size. The law has no
        frequency shift, h_A = 0, if its interval contains 0.
    levels : tuple of SineLevel
    frequency_scatter : float
        Standard deviation of the natural frequency of a level from the law [rad/s].
    range : (1, 2) ndarray
        Smallest and largest amplitude at resonance [sensor unit].
    unit : str
    control : {"force", "response"}
        Kind of the levels.
    models : tuple of SineModel
        Law and modal mass of all levels, then without each of them.
    """

    law: SlowLaw
    parameters: dict[str, float]
    deviation: dict[str, float]
    interval: dict[str, tuple[float, float]]
    unidentified: tuple[str, ...]
    levels: tuple[SineLevel, ...]
    frequency_scatter: float
    range: Floats
    unit: str
    control: Literal["force", "response"]
    models: tuple[SineModel, ...] = field(repr=False)

    def backbone(self, amplitude: Any = None, extrapolate: bool = False) -> DecayBackbone:
        """Return natural frequency and damping against the amplitude.

        Parameters
        ----------
        amplitude : (n,) array_like, optional
            [sensor unit]. Default: 200 values over the measured range.
        extrapolate : bool
            Whether amplitudes above the measured range are allowed.

        Raises
        ------
        SlipmodeError
            If an amplitude is not positive or beyond the range.
        """
        a = (
            np.geomspace(self.range[0, 0], self.range[0, 1], 200)
            if amplitude is None
            else amplitude
        )
        a = np.atleast_1d(as_floats("amplitude", a))
        if a.ndim > 1 or not a.size or not np.all(np.isfinite(a) & (a > 0.0)):
            raise SlipmodeError("amplitude: must be finite numbers > 0 [sensor unit]")
        self._check_range(float(a.max()), extrapolate)
        rates = np.array([complex_rate(each.law, a) for each in self.models])
        damping = -rates.real / rates.imag
        points = {
            each.name: LocalRates(
                *(np.array([v]) for v in (0.0, each.amplitude, each.damping_rate, each.frequency))
            )
            for each in self.levels
        }
        omega_deviation, deviation = (
            np.sqrt(jackknife_variance(each[1:])) for each in (rates.imag, damping)
        )
        return DecayBackbone(
            0, a, rates.imag[0], damping[0], omega_deviation, deviation, points, self.unit
        )

    def predict(
        self,
        tests: SineTests,
        *,
        band: tuple[float, float],
        frequency: float | None = None,
        extrapolate: bool = False,
    ) -> tuple[SinePrediction, ...]:
        """Return the amplitudes of other tests under their measured forces.

        Parameters
        ----------
        tests : SineTests
            Force- or response-controlled.
        band : (float, float)
            Points between these frequencies are predicted [Hz].
        frequency : float, optional
            Natural frequency at rest [rad/s], the same for all tests. Default: fitted to each
            because it differs between tests by about the half-power bandwidth.
        extrapolate : bool
            Whether amplitudes may be beyond the measured range.

        Raises
        ------
        SlipmodeError
            If the tests have another unit, a test is not sound, or an amplitude is beyond the
            range.
        """
        if tests.unit != self.unit:
            raise SlipmodeError(f"tests: are in {tests.unit}, the identification in {self.unit}")
        parts, order = checked_tests(tests, band)
        n, made = len(self.levels), []
        for part in parts:
            end = self.range[0, 1]
            chosen = self._fitted_frequency(part, order) if frequency is None else frequency
            models = [each.shifted(chosen - self.law.values[1]) for each in self.models]
            sizes = np.array([each.amplitude(part, order, end) for each in models])
            size, measured = sizes[0], np.abs(part.response)
            self._check_range(float(size.max()), extrapolate)
            # The variance of the mean of n levels times n is the variance of a level.
            deviation = size * np.sqrt((1 + n) * jackknife_variance(np.log(sizes[1:])))
            error = float(np.sqrt(np.mean((size - measured) ** 2)) / measured.max())
            peak = float(size.max() / measured.max() - 1.0)
            made.append(SinePrediction(part, chosen, size, deviation, error, peak))
        return tuple(made)

    def _fitted_frequency(self, test: SineTest, order: int) -> float:
        """Return the natural frequency at rest with the least error of the amplitudes."""
        level, measured = fit_level(test, order, self.law), np.abs(test.response)
        near = level.frequency - complex_rate(self.law, level.amplitude).imag

        def squares(shift: float) -> float:
            model = self.models[0].shifted(shift)
            size = model.amplitude(test, order, self.range[0, 1])
            return float(np.mean((size - measured) ** 2))

        reach = level.damping_rate  # half the half-power bandwidth
        ends = (float(near - reach), float(near + reach))
        best = scipy.optimize.minimize_scalar(squares, bounds=ends, method="bounded")
        return float(self.law.values[1] + best.x)

    def _check_range(self, largest: float, extrapolate: bool) -> None:
        # 1 % is less than the errors of predictions.
        if largest > 1.01 * self.range[0, 1] and not extrapolate:
            raise SlipmodeError(
                f"amplitude: {largest:.4g} is beyond the largest measured amplitude, "
                f"{self.range[0, 1]:.4g} {self.unit}; extrapolate=True allows it"
            )


def identify_sine(
    tests: SineTests, *, band: tuple[float, float], law: Literal["power", "linear"] = "power"
) -> SineIdentification:
    """Identify frequency and damping of one mode against its amplitude from steady sine tests.

    Natural frequency, modal mass, damping and a phase error of the channels are fitted to each
    level. One law of damping follows from all levels, and its uncertainty from the scatter
    between them.

    Parameters
    ----------
    tests : SineTests
        Levels of one kind, force- or response-controlled, see `read_sine_tests`.
    band : (float, float)
        Lower and upper end of a band around the mode [Hz], in which it is the only mode.
    law : {"power", "linear"}
        delta = delta_0 + g (a / R)^p and omega = omega_0 - h (a / R)^p, or constants. R is the
        largest amplitude.

    Returns
    -------
    SineIdentification

    Raises
    ------
    SlipmodeError
        If an array or the unit of a test is not allowed, a level has no resonance or too few
        points around it, levels differ in kind, or are fewer than the parameters of the law.

    Notes
    -----
    Tests of different kinds (sine or decay, force or response control) differ in damping, by 10 to
    15 % on a bolted beam. The deviations are those of further tests of the same kind.
    """
    if law not in ("power", "linear"):
        raise SlipmodeError(f"law = {in_one_line(law)}: must be power or linear")
    form = LawForm(1, law, False)
    parts, order = checked_tests(tests, band)
    needed = 4 if law == "power" else 2  # parameters of damping, and one more for their scatter
    if len(parts) < needed:
        raise SlipmodeError(f"tests: has {len(parts)} levels, a {law} law needs {needed}")
    kinds = {kind: [p.name for p in parts if p.control == kind] for kind in ("force", "response")}
    if all(kinds.values()):
        raise SlipmodeError(
            f"tests: {short_list(kinds['force'])} are force-controlled, "
            f"{short_list(kinds['response'])} response-controlled; identify one kind, and predict "
            "the other"
        )
    levels, models = _fitted(parts, order, form, shift=law == "power")
    for part, level in zip(parts, levels, strict=True):
        check_level(part, level)
    shifts = np.array([x.law.values[3] for x in models])
    if _half_width(shifts) > abs(shifts[0]):
        levels, models = _fitted(parts, order, form, shift=False)
    values = {
        name: np.array([x.law.values[k] for x in models])
        for k, name in enumerate(form.names)
        if form.free[k]
    }
    values["modal_mass"] = np.array([x.mass for x in models])
    # An interval that contains h_A = 0 is that of the estimate, which the law does not have.
    estimates = {**values, "h_A": shifts} if "h_A" in values else values
    half = {name: _half_width(each) for name, each in estimates.items()}
    left_out = [
        complex_rate(model.law, x.amplitude) for x, model in zip(levels, models[1:], strict=True)
    ]
    whole = models[0].law
    rest = [x.frequency - complex_rate(whole, x.amplitude).imag for x in levels]
    sizes = [x.amplitude for x in levels]
    return SineIdentification(
        law=whole,
        parameters={name: float(each[0]) for name, each in values.items()},
        deviation={k: float(np.sqrt(jackknife_variance(v[1:]))) for k, v in estimates.items()},
        interval={k: (float(v[0] - half[k]), float(v[0] + half[k])) for k, v in estimates.items()},
        unidentified=tuple(k for k, v in estimates.items() if half[k] > abs(v[0])),
        levels=tuple(
            replace(x, left_out_damping=float(-rate.real / rate.imag))
            for x, rate in zip(levels, left_out, strict=True)
        ),
        frequency_scatter=float(np.std(rest, ddof=1)),
        range=np.array([[min(sizes), max(sizes)]]),
        unit=tests.unit,
        control="force" if kinds["force"] else "response",
        models=models,
    )


def _fitted(
    tests: Sequence[SineTest], order: int, form: LawForm, shift: bool
) -> tuple[list[SineLevel], tuple[SineModel, ...]]:
    """Return the levels, and the model of all levels and without each of them."""
    levels, model = _fitted_once(tests, order, form, shift)
    made = [model]
    for k in range(len(tests)):
        _, without = _fitted_once([*tests[:k], *tests[k + 1 :]], order, form, shift)
        law, values = without.law, without.law.values.copy()
        values[2:4] *= (model.law.reference / law.reference) ** values[4]
        made.append(
            SineModel(replace(law, values=values, reference=model.law.reference), without.mass)
        )
    return levels, tuple(made)


def _fitted_once(
    tests: Sequence[SineTest], order: int, form: LawForm, shift: bool
) -> tuple[list[SineLevel], SineModel]:
    levels = [fit_level(test, order, None) for test in tests]
    law = _law_of(levels, form, shift)
    # Levels depend on the law by the change of damping within them. Response-controlled ones
    # converge in 3 passes, force-controlled ones, whose amplitudes vary, in about 10.
    for _ in range(20):
        last = law.values
        levels = [fit_level(test, order, law) for test in tests]
        law = _law_of(levels, form, shift)
        if np.allclose(law.values, last, rtol=1e-5, atol=0.0):
            break
    return levels, SineModel(law, abs(float(np.mean([x.modal_mass for x in levels]))))


def _law_of(levels: Sequence[SineLevel], form: LawForm, shift: bool) -> SlowLaw:
    """Return the law that has the least relative errors of damping at the levels."""
    a, omega = (np.array([getattr(x, key) for x in levels]) for key in ("amplitude", "frequency"))
    delta = np.array([x.damping_rate for x in levels])
    reference = a.max()

    def damping(p: float) -> tuple[Floats, float]:
        basis = np.stack([np.ones(a.size), (a / reference) ** p], axis=1) / delta[:, np.newaxis]
        found, rest = scipy.optimize.nnls(basis, np.ones(a.size))
        return found, rest

    p, found = 1.0, np.array([1.0 / np.mean(1.0 / delta), 0.0])
    if form.law == "power":
        tried = np.geomspace(*EXPONENTS, 40)  # the sum of squares may have several minima
        best = int(np.argmin([damping(each)[1] for each in tried]))
        ends = float(tried[max(best - 1, 0)]), float(tried[min(best + 1, tried.size - 1)])
        p = float(
            scipy.optimize.minimize_scalar(
                lambda each: damping(each)[1],
                bounds=ends,
                method="bounded",
                options={"xatol": 1e-9},
            ).x
        )
        found = damping(p)[0]
    omega_0, h = omega.mean(), 0.0
    if shift:
        basis = np.stack([np.ones(a.size), -((a / reference) ** p)], axis=1)
        omega_0, h = np.linalg.lstsq(basis, omega, rcond=None)[0]
    values = np.array([found[0], omega_0, found[1], h, p, 0.0])
    return SlowLaw(form, values, np.array([reference]))


def _half_width(values: Floats) -> float:
    """Return half the width of the 95 % interval, from values of all levels and without each."""
    student = scipy.special.stdtrit(values.size - 2, 0.5 * (1.0 + CONFIDENCE))
    return float(student * np.sqrt(jackknife_variance(values[1:])))
