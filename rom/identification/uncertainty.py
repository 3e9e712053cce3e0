"""How far the parameters and rates of a law may be from the true ones.

Three causes add up: scatter between records, laws that predict equally well, and rates of parts of
the records that the law does not follow (a slider that sticks below some amplitude, for example).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace

import numpy as np

from slipmode.rom.common import Floats, frozen
from slipmode.rom.identification.decay_flow import STEP, Decays
from slipmode.rom.identification.deviations import Deviation
from slipmode.rom.identification.fit import (
    DIFFERENCE,
    LEAST_RECORDS,
    Fit,
    fit,
    interval_half_width,
    jackknife_variance,
)
from slipmode.rom.identification.initial_amplitudes import first_window, initial_amplitudes
from slipmode.rom.identification.slow_laws import WIDTH, LawForm, SlowLaw

# Of each record, of equal duration. Of 60 structures of test_jointed_structures.py, 90 % have all
# true parameters in their intervals with 8 parts, 95 % with 10, 85 % with 12.
PARTS = 10
# Error of rates by a Runge-Kutta step of x = STEP, x^5 / 120 of the amplitude, relative to the
# fastest rate.
STEP_ERROR = STEP**4 / 120.0

# Standard deviation of the parameters of a joint with macro-slip, relative to their value, by
# averaging over a cycle in which the amplitude falls: this times the damping ratio
# (test_macro_slip.py).
AVERAGING = 0.15


@frozen
class Uncertainty:
    """Scatter of laws, and their misfit.

    Attributes
    ----------
    laws : sequence of sequences of SlowLaw
        The identified law, then other laws that fit equally well. Each is followed by the law
        without each of the records or levels.
    misfit : (2, modes) ndarray
        Variances of the misfit of damping rates [1/s^2] and frequencies [rad^2/s^2].
    parameter_errors : (errors, free parameters) ndarray, optional
        Independent standard errors of the free parameters by the misfit, in a row for each cause.
        Default: none.
    """

    laws: Sequence[Sequence[SlowLaw]] = field(repr=False)
    misfit: Floats
    parameter_errors: Floats | None = None

    @property
    def left_out(self) -> Sequence[SlowLaw]:
        """The identified law without each of the records or levels."""
        return self.laws[0][1:]

    @property
    def alike(self) -> list[Sequence[SlowLaw]]:
        """The laws whose parameters have the meaning of the identified ones."""
        return [each for each in self.laws if each[0].form.kind == self.laws[0][0].form.kind]

    def variance(self, quantity: Callable[[SlowLaw], Floats]) -> Floats:
        """Return the variance of a quantity of the law, without the misfit of rates.

        Infinite for fewer than three records.
        """
        values = [np.array([quantity(law) for law in laws]) for laws in self.laws]
        return self._mean_variance(values, 1.0)

    def of_record(self, values: Floats) -> Floats:
        """Return the variance of a quantity in a further record, without the misfit of rates.

        `values` (..., laws) are those of all laws in their order. Infinite for fewer than three
        records.
        """
        by_law = np.moveaxis(values, -1, 0)
        # The variance of the mean of n records times n is the variance of a record.
        scatter = 1.0 + len(self.left_out)
        return self._mean_variance(np.split(by_law, len(self.laws)), scatter)

    def after(self, times: Floats, duration: float) -> Floats:
        """Return the variances of log amplitude and phase after times by the misfit of rates.

        They are (2, times, modes), for a record of a duration [s]. Rates of the parts of a record
        are in error independently of each other, as `PartRates.misfit` takes them to be.
        """
        of_unit = times * np.minimum(times, duration / PARTS)
        return np.asarray(self.misfit[:, np.newaxis] * of_unit[:, np.newaxis])

    def samples(self, rng: np.random.Generator) -> Iterator[SlowLaw]:
        """Yield laws from the posterior, without end.

        The law is any of those that fit equally well. Its parameters have the covariance of the
        jackknife and of the misfit, with the distribution of their intervals, Student's.
        """
        records, coupled = len(self.left_out), self.laws[0][0].form.law == "quadratic"
        # a model without quadratic coupling has none in its samples
        likely = [each for each in self.alike if coupled or each[0].form.law != "quadratic"]
        while True:
            law, *left_out = likely[rng.integers(len(likely))]
            values = np.array([each.values for each in left_out])
            of_records = (values - values.mean(axis=0)) * np.sqrt((records - 1) / records)
            error = rng.standard_normal(records) @ of_records
            if self.parameter_errors is not None:
                errors = self.parameter_errors
                error[self.laws[0][0].form.free] += rng.standard_normal(len(errors)) @ errors
            error *= np.sqrt((records - 1) / rng.chisquare(records - 1)) * law.form.free
            yield replace(law, values=law.form.limited(law.values + error))

    def _mean_variance(self, values: Sequence[Floats], scatter: float) -> Floats:
        """Return the variance by values (1 + records, ...) of each law.

        It is the mean over the laws of their jackknife variance, times `scatter`, and their
        squared distance from the identified law (Buckland, Burnham and Augustin, Model selection:
        an integral part of inference, Biometrics 53, 1997).
        """
        best = values[0][0]
        if len(self.left_out) < LEAST_RECORDS:
            return np.full(best.shape, np.inf)
        with np.errstate(over="ignore", invalid="ignore"):  # laws that the data do not determine
            variances = [
                scatter * jackknife_variance(each[1:]) + (each[0] - best) ** 2 for each in values
            ]
            mean: Floats = np.mean(variances, axis=0)
        return np.where(np.isnan(mean), np.inf, mean)


@frozen
class PartRates:
    """Rates of parts of the records compared with the law.

    Attributes
    ----------
    amplitude : (modes, parts) ndarray
        Geometric mean amplitudes [sensor unit].
    difference : (2, modes, parts) ndarray
        Damping rates [1/s] and frequencies [rad/s] minus those of the law.
    variance : (2, modes, parts) ndarray
        Of the differences, by the scatter between records; infinite below the noise.
    resolution : float
        Variance of rates by the steps of the integration [1/s^2], times the number of parts,
        because all parts share the error.
    """

    amplitude: Floats
    difference: Floats
    variance: Floats
    resolution: float

    @classmethod
    def of(cls, decays: Decays, law: SlowLaw, floor: Floats) -> PartRates:
        """Return the rates of parts: constants delta_0 and omega_0 are fitted to each part.

        `floor` (modes,) are the smallest amplitudes that are above the noise [sensor unit].
        """
        constants = LawForm(law.form.modes, "linear", False)
        window = first_window(decays.carrier)
        resolution = PARTS * (STEP_ERROR * STEP / decays.step) ** 2
        amplitudes, differences, variances = [], [], []
        for k in range(PARTS):
            records = [
                r.part(k * r.duration / PARTS, (k + 1) * r.duration / PARTS)
                for r in decays.records
            ]
            d = decays
            part = Decays.of(records, d.carrier, d.shapes, d.reference, STEP / d.step)
            known = [initial_amplitudes(r, law, d.shapes, window)[0] for r in records]
            found = fit(part, constants, law.values, np.array(known).T)
            left_out = np.array([each.values for each in found.left_out()])
            nodes = part.nodes(found.law.values[:, np.newaxis], found.start[:, np.newaxis])
            amplitudes.append(np.exp(np.log(np.abs(nodes[:, 0, :, 0])).mean(axis=(0, 2))))
            free = constants.free
            differences.append((found.law.values - law.values)[free].reshape(-1, 2).T)
            variance = jackknife_variance(left_out)[free].reshape(-1, 2).T
            variances.append(np.where(amplitudes[-1] > floor, variance + resolution, np.inf))
        return cls(
            np.stack(amplitudes, axis=-1),
            np.stack(differences, axis=-1),
            np.stack(variances, axis=-1),
            resolution,
        )

    @property
    def misfit(self) -> Floats:
        """Variance of the misfit, (2, modes): what the scatter between records leaves.

        The moment estimator of R. DerSimonian and N. Laird, Meta-analysis in clinical trials,
        Control. Clin. Trials 7 (1986).
        """
        excess = self.difference**2 / self.variance - np.isfinite(self.variance)
        weight = np.maximum((1.0 / self.variance).sum(axis=-1), np.finfo(float).tiny)
        return np.asarray(np.maximum(excess.sum(axis=-1) / weight, self.resolution))

    def parameter_errors(self, found: Fit) -> Floats:
        """Return standard errors of the free parameters by the misfit, (rates, free parameters).

        The parameters are a regression on the rates of the parts, with their variances. Errors of
        different rates are independent.
        """
        law = found.law

        def rates(values: Floats) -> Floats:
            each = replace(law, values=law.form.tied(values))
            return np.stack(
                [each.damping_rates(*self.amplitude), each.frequencies(*self.amplitude)]
            )

        slopes = []
        for k, scale in zip(np.flatnonzero(law.form.free), found.scale, strict=True):
            values = law.values.copy()
            values[k] += DIFFERENCE * scale
            slopes.append((rates(values) - rates(law.values)).reshape(-1) / DIFFERENCE)
        misfit = self.misfit[:, :, np.newaxis]
        weight = 1.0 / np.sqrt(misfit + self.variance).reshape(-1)
        regression = np.linalg.pinv(np.array(slopes).T * weight[:, np.newaxis], rcond=DIFFERENCE)
        of_part = np.broadcast_to(misfit, self.variance.shape).reshape(-1) * weight**2
        return np.asarray((regression * np.sqrt(of_part)).T * found.scale)


def uncertainty(
    fits: Sequence[Fit], decays: Decays, floor: Floats, deviations: Sequence[Deviation]
) -> tuple[Uncertainty, Floats, Floats, tuple[str, ...]]:
    """Return the uncertainty of the first of several fits of laws.

    `floor` (modes,) are the smallest amplitudes above the noise [sensor unit], `deviations` the
    modes for which no law is claimed. Deviations and half-widths of the intervals of the free
    parameters follow, and the names of unidentified ones.
    Deviations by least squares are 7 to 64 times smaller than differences between measured decays.
    Of fewer than three records both are infinite, and parameters without any effect are
    unidentified.
    """
    found = fits[0]
    form, free = found.law.form, found.law.form.free
    names = [name for name, each in zip(form.names, free, strict=True) if each]
    records = len(found.normal.cost)
    singular = found.singular()
    laws = [[each.law, *(each.left_out() if records > 1 else [])] for each in fits]
    scatter = Uncertainty(laws, np.zeros((2, form.modes)))
    deviation, half, wide = np.full(len(names), np.inf), np.full(len(names), np.inf), singular
    if records >= LEAST_RECORDS:
        parts = PartRates.of(decays, found.law, floor)
        errors = parts.parameter_errors(found)
        if form.kind == "macro-slip":
            a = np.geomspace(floor[0], np.abs(found.start).max(), 100)
            ratio = (found.law.damping_rates(a) / found.law.frequencies(a)).max()
            of_joint = np.array([name[0] in "ghpJ" for name in names])
            averaging = of_joint * AVERAGING * ratio * found.law.values[free]
            errors = np.vstack((errors, np.diag(averaging)))
        scatter = Uncertainty(laws, parts.misfit, errors)
        variance = replace(scatter, laws=scatter.alike).variance(lambda law: law.values)[free]
        variance = variance + (errors**2).sum(axis=0)
        added = np.zeros(len(free))
        for each in deviations:
            scatter.misfit[:, each.mode] += each.variance
            own = slice(WIDTH * each.mode, WIDTH * (each.mode + 1))
            added[own] = [*each.variance, *(WIDTH - 2) * [np.inf]]
        variance = variance + added[free]
        deviation = np.where(singular, np.inf, np.sqrt(variance))
        half = interval_half_width(deviation, records)
        wide = half > _parameter_sizes(form, found.law.values)[free]
    unidentified = {name for name, each in zip(names, wide, strict=True) if each}
    for mode in "AB"[: form.modes]:  # constant rates have no exponent
        if {f"g_{mode}", f"h_{mode}"} & set(names) <= unidentified:
            unidentified |= {f"p_{mode}", f"kappa_{mode}"}
    return scatter, deviation, half, tuple(name for name in names if name in unidentified)


def _parameter_sizes(form: LawForm, values: Floats) -> Floats:
    """Return the size that the interval of each parameter is compared with.

    A kappa or h may well be zero. The size of kappa is at least 1, at which the other mode counts
    as much as the mode itself; the size of h is at least the size of g.
    """
    sizes = np.abs(values)
    for k, name in enumerate(form.names):
        if name.startswith("kappa"):
            sizes[k] = max(sizes[k], 1.0)
        elif name.startswith("h"):
            sizes[k] = max(sizes[k], sizes[k - 1])
    return sizes
