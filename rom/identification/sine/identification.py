"""Identification of a law of the slow flow from steady sine tests of one mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from typing import Literal

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen, in_one_line, short_list
from slipmode.rom.identification.fit import interval_half_width, jackknife_variance
from slipmode.rom.identification.models.identified import IdentifiedLaw
from slipmode.rom.identification.models.macro_slip import NO_MACRO_SLIP
from slipmode.rom.identification.sine.levels import (
    SineLevel,
    check_level,
    complex_rate,
    fit_level,
)
from slipmode.rom.identification.sine.prediction import SineModel, SinePrediction, predicted
from slipmode.rom.identification.sine.responses import SineTest, SineTests, checked_tests
from slipmode.rom.identification.slow_laws import LawForm, SlowLaw
from slipmode.rom.identification.uncertainty import Uncertainty


@frozen
class SineIdentification(IdentifiedLaw):
    """Hold a law of the slow flow identified from steady sine tests.

    It has all attributes of `IdentifiedLaw`, and the following. Its damping is the damping of
    steady vibration; in free vibration friction damps more, by up to 1.7 % in an example of
    `rom.model_of_rates`. The parameters include "modal_mass" [kg]. The law has no frequency shift
    (h_A = 0) if the interval of h_A contains 0.

    Attributes
    ----------
    levels : tuple of SineLevel
        Fit of each level.
    frequency_scatter : float
        Standard deviation of the natural frequency of a level from the law [rad/s].
    control : {"force", "response"}
        Kind of the levels.
    tests : SineTests
        Fitted tests.
    held_out : tuple of SinePrediction
        Predictions of the tests that were not fitted.
    band : (float, float)
        Frequency band of the fitted points [Hz].
    models : tuple of SineModel
        Law and modal mass of all levels, then without each of them.
    """

    levels: tuple[SineLevel, ...]
    frequency_scatter: float
    control: Literal["force", "response"]
    tests: SineTests = field(repr=False)
    held_out: tuple[SinePrediction, ...]
    band: tuple[float, float]
    models: tuple[SineModel, ...] = field(repr=False)

    @property
    def misfit(self) -> Floats:
        """Deviation of the damping of each level from the law, relative to the law, (levels,)."""
        law = [-complex_rate(self.law, level.amplitude).real for level in self.levels]
        return np.array([level.damping_rate for level in self.levels]) / law - 1.0

    @property
    def steady(self) -> bool:
        """True: the law describes steady vibration."""
        return True

    def predict(
        self,
        tests: SineTests,
        *,
        band: tuple[float, float],
        frequency: float | None = None,
        extrapolate: bool = False,
    ) -> tuple[SinePrediction, ...]:
        """Return the predicted amplitudes of other tests under their measured forces.

        Parameters
        ----------
        tests : SineTests
            Tests, force-controlled or response-controlled.
        band : (float, float)
            Frequency band of the predicted points [Hz].
        frequency : float, optional
            Natural frequency at rest of all tests [rad/s]. Default: fitted to each test, because
            it differs between tests by about the half-power bandwidth.
        extrapolate : bool, default False
            Allow amplitudes above the measured range.

        Returns
        -------
        tuple of SinePrediction
            Amplitudes of each test with their standard deviations and errors.

        Raises
        ------
        SlipmodeError
            If the tests have another unit, an array is not allowed, or an amplitude is above the
            measured range.
        """
        if tests.unit != self.unit:
            raise SlipmodeError(
                f"tests: must be in {self.unit} like the identification, got {tests.unit}"
            )
        if frequency is not None and not (np.ndim(frequency) == 0 and 0.0 < frequency < np.inf):
            raise SlipmodeError(f"frequency = {in_one_line(frequency)}: must be > 0 [rad/s]")
        parts, order = checked_tests(tests, band)
        made = []
        for part in parts:
            each = predicted(part, order, self.models, float(self.range[0, 1]), frequency)
            largest = float(each.amplitude.max())
            if largest > 1.01 * self.range[0, 1]:  # 1 % is less than the errors of predictions
                self._check_range(0, largest, extrapolate)
            made.append(each)
        return tuple(made)


def identify_sine(
    tests: SineTests,
    *,
    band: tuple[float, float],
    law: Literal["power", "linear"] = "power",
    hold_out: Sequence[str] = (),
) -> SineIdentification:
    """Return a law of frequency and damping against amplitude, identified from steady sine tests.

    Natural frequency, modal mass, damping and a phase error of the channels are fitted to each
    level. One law of damping is fitted to all levels. The scatter between levels gives its
    uncertainty.

    Parameters
    ----------
    tests : SineTests
        Levels of one kind, force-controlled or response-controlled, see `rom.read_sine_tests`.
    band : (float, float)
        Frequency band [Hz] that contains one mode.
    law : {"power", "linear"}, default "power"
        "power": delta = delta_0 + g (a / R)^p and omega = omega_0 - h (a / R)^p, with the largest
        amplitude R. "linear": constant rates.
    hold_out : sequence of str
        Names, or beginnings of names, of tests that are predicted and not fitted. They may be of
        the other kind.

    Returns
    -------
    SineIdentification
        Law with its uncertainty, and the fit of each level.

    Raises
    ------
    SlipmodeError
        If an array or the unit of a test is not allowed. If a level has no resonance, or too few
        points around it. If levels differ in kind, or are fewer than the parameters of the law.

    Notes
    -----
    Tests of different kinds (sine or decay, force or response control) differ in damping, on a
    bolted beam by 10 to 15 %. The standard deviations are valid for further tests of the kind that
    was fitted.
    """
    if law not in ("power", "linear"):
        raise SlipmodeError(f"law = {in_one_line(law)}: must be power or linear")
    form = LawForm(1, law, False)
    held = [test for test in tests if any(test in tests[key].tests for key in hold_out)]
    held_out = SineTests(held, tests.unit)
    tests = SineTests([test for test in tests if test not in held], tests.unit)
    parts, order = checked_tests(tests, band)
    needed = 4 if law == "power" else 2  # parameters of damping, and one more for their scatter
    if len(parts) < needed:
        raise SlipmodeError(
            f"tests: must have at least {needed} levels for a {law} law, got {len(parts)}"
        )
    kinds = {kind: [p.name for p in parts if p.control == kind] for kind in ("force", "response")}
    if all(kinds.values()):
        raise SlipmodeError(
            f"tests: {short_list(kinds['force'])} are force-controlled, "
            f"{short_list(kinds['response'])} response-controlled; identify one kind, and predict "
            "the other"
        )
    fitted, shifts = _with_shift(parts, order, form) if law == "power" else (None, np.zeros(0))
    if fitted is None:
        fitted = _fitted(parts, order, form, shift=False)
    levels, models = fitted
    for part, level in zip(parts, levels, strict=True):
        check_level(part, level)
    values = {
        name: np.array([x.law.values[k] for x in models])
        for k, name in enumerate(form.names)
        if form.free[k]
    }
    values["modal_mass"] = np.array([x.mass for x in models])
    # An interval that contains h_A = 0 belongs to the estimate, which the law does not have.
    estimates = {**values, "h_A": shifts} if "h_A" in values else values
    deviation = {name: _deviation(each) for name, each in estimates.items()}
    half = {name: _half_width(each) for name, each in estimates.items()}
    left_out = [
        complex_rate(model.law, x.amplitude) for x, model in zip(levels, models[1:], strict=True)
    ]
    whole = models[0].law
    rest = [x.frequency - complex_rate(whole, x.amplitude).imag for x in levels]
    sizes = [x.amplitude for x in levels]
    found = SineIdentification(
        law=whole,
        parameters={name: float(each[0]) for name, each in values.items()},
        deviation=deviation,
        interval={k: (float(v[0] - half[k]), float(v[0] + half[k])) for k, v in estimates.items()},
        unidentified=tuple(k for k, v in estimates.items() if half[k] > abs(v[0])),
        levels=tuple(
            replace(x, left_out_damping=float(-rate.real / rate.imag))
            for x, rate in zip(levels, left_out, strict=True)
        ),
        frequency_scatter=float(np.std(rest, ddof=1)),
        range=np.array([[min(sizes), max(sizes)]]),
        unit=tests.unit,
        channels=("sensor",),
        channel="sensor",
        shapes=np.ones((1, 1)),
        points={x.name: [x.local_rates] for x in levels},
        uncertainty=Uncertainty([[model.law for model in models]], np.zeros((2, 1))),
        control="force" if kinds["force"] else "response",
        tests=tests,
        held_out=(),
        band=band,
        models=models,
    )
    return replace(found, held_out=found.predict(held_out, band=band, extrapolate=True))


def _with_shift(
    tests: Sequence[SineTest], order: int, form: LawForm
) -> tuple[tuple[list[SineLevel], tuple[SineModel, ...]] | None, Floats]:
    """Return the fit with a frequency shift, None if that may be 0, and estimates of h."""
    try:
        levels, models = _fitted(tests, order, form, shift=True)
    except SlipmodeError:  # some levels, without one of them, are too few for a shift
        return None, np.array([0.0] + [np.inf] * len(tests))
    shifts = np.array([each.law.values[3] for each in models])
    if _half_width(shifts) > abs(shifts[0]):
        return None, shifts
    return (levels, models), shifts


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
    # converge in 3 passes, force-controlled ones, whose amplitudes vary, in 10 to 20.
    for _ in range(50):
        last = law.values
        levels = [fit_level(test, order, law) for test in tests]
        law = _law_of(levels, form, shift)
        if np.allclose(law.values, last, rtol=1e-5, atol=0.0):
            break
    else:
        for test, level in zip(tests, levels, strict=True):
            check_level(test, level)
        raise SlipmodeError(
            "tests: no law fits the changes of damping within the levels; check the force channel"
        )
    return levels, SineModel(law, abs(float(np.mean([x.modal_mass for x in levels]))))


def _law_of(levels: Sequence[SineLevel], form: LawForm, shift: bool) -> SlowLaw:
    """Return the law of damping, and of frequency if it shifts, nearest to the levels.

    Errors of damping and of frequency count relative to delta. For a given exponent the law is
    linear. The best exponent has the largest likelihood for an unknown scatter of either; a
    scatter below 1 % is not distinguished from none.
    """
    a, omega = (np.array([getattr(x, key) for x in levels]) for key in ("amplitude", "frequency"))
    delta = np.array([x.damping_rate for x in levels])
    terms, mean = (2 if form.law == "power" else 1), omega.mean()
    relative = np.stack([np.ones(a.size), (omega - mean) / delta], axis=1)

    def fitted(p: float) -> tuple[Floats, Floats]:
        """Return damping and frequency (2 terms, 2), and their errors (levels, 2)."""
        basis = np.stack([np.ones(a.size), (a / a.max()) ** p], axis=1) / delta[:, np.newaxis]
        found = np.zeros((2, 2))
        found[:terms] = np.linalg.lstsq(basis[:, :terms], relative, rcond=None)[0]
        if found[0, 0] < 0.0:  # damping at rest
            found[:, 0] = 0.0, basis[:, 1].sum() / (basis[:, 1] ** 2).sum()
        return found, basis @ found - relative

    def unlikelihood(p: float) -> float:
        squares = np.mean(fitted(p)[1] ** 2, axis=0) + 0.01**2
        return float(np.log(squares if shift else squares[:1]).sum())

    p = 1.0
    if form.law == "power":
        tried = np.geomspace(0.1, 6.0, 20)  # there may be several minima
        best = int(np.argmin([unlikelihood(each) for each in tried]))
        ends = float(tried[max(best - 1, 0)]), float(tried[min(best + 1, tried.size - 1)])
        p = float(scipy.optimize.minimize_scalar(unlikelihood, bounds=ends, method="bounded").x)
    (delta_0, moved), (g, slope) = fitted(p)[0]
    omega_0, h = (mean + moved, -slope) if shift else (mean, 0.0)
    values = np.array([delta_0, omega_0, g, h, p, 0.0, NO_MACRO_SLIP, 0.0])
    return SlowLaw(form, values, np.array([a.max()]))


def _deviation(values: Floats) -> float:
    """Return the standard deviation of a quantity from values of all levels and without each."""
    if not np.isfinite(values).all():
        return np.inf
    return float(np.sqrt(jackknife_variance(values[1:])))


def _half_width(values: Floats) -> float:
    """Return half the width of its 95 % interval."""
    return float(interval_half_width(_deviation(values), values.size - 1))
