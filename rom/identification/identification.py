"""Identification of a law of the slow flow from measured decays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.identification.decay_flow import STEP, Decays
from slipmode.rom.identification.first_look import FirstLook, LocalRates
from slipmode.rom.identification.fit import LEAST_RECORDS, Fit, jackknife_variance, uncertainty
from slipmode.rom.identification.measurement import (
    Measurement,
    Prepared,
    Record,
    RecordReport,
    checked_bands,
)
from slipmode.rom.identification.models.law_model import model_of_law
from slipmode.rom.identification.models.sensor_units import sensor_factors, shape_at_sensor
from slipmode.rom.identification.prediction import Prediction, predict
from slipmode.rom.identification.preparation import (
    Plan,
    nothing_usable,
    prepare,
    prepare_all,
)
from slipmode.rom.identification.selection import (
    determined,
    first_guess,
    fit_in_turn,
    outliers,
    select,
)
from slipmode.rom.identification.slow_laws import LawForm, LawName, SlowLaw, allowed_forms
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAND = 0.2  # opacity of bands in pictures


@frozen
class DecayBackbone:
    """Frequency and damping of a mode against its amplitude.

    By an identified law, or as measured otherwise, for `fit_contacts`.

    Attributes
    ----------
    mode : int
        0 for A, 1 for B; of a structure its number.
    amplitude : (n,) ndarray
        [sensor unit]
    frequency : (n,) ndarray
        [rad/s]
    damping : (n,) ndarray
        Damping ratio delta / omega [-].
    frequency_deviation, damping_deviation : (n,) ndarray
        Standard deviations by the scatter between records. Infinite for fewer than three.
    unit : str
        Of the amplitudes.
    points : dict
        By name of the record, the `LocalRates` of the first look.
    left_out : (records, 2, n) ndarray
        Frequency and damping by the law without each of the records. Empty if the deviations of
        the n values are independent.
    steady : bool
        Whether the vibration is steady, in sine tests; else it is free.
    """

    mode: int
    amplitude: Floats
    frequency: Floats
    damping: Floats
    frequency_deviation: Floats
    damping_deviation: Floats
    unit: str
    points: Mapping[str, LocalRates] = field(default_factory=dict)
    left_out: Floats = field(default_factory=lambda: np.zeros((0, 2, 0)))
    steady: bool = False

    def plot(self, axes: tuple[Axes, Axes] | None = None) -> Any:
        """Draw frequency [Hz] and damping ratio with bands of two standard deviations."""
        if axes is None:
            axes = extra("matplotlib.pyplot", "pictures").subplots(2, sharex=True)[1]
        hertz = 1.0 / (2.0 * np.pi)
        for name, look in self.points.items():
            axes[0].plot(look.amplitude, look.omega * hertz, ".", label=name)
            axes[1].plot(look.amplitude, look.delta / look.omega, ".", label=name)
        shown = (
            ("frequency [Hz]", self.frequency * hertz, self.frequency_deviation * hertz),
            ("damping [-]", self.damping, self.damping_deviation),
        )
        for ax, (name, values, deviation) in zip(axes, shown, strict=True):
            ax.semilogx(self.amplitude, values, color="k")
            if np.isfinite(deviation).all():
                low, high = values - 2.0 * deviation, values + 2.0 * deviation
                ax.fill_between(self.amplitude, low, high, alpha=BAND, lw=0, color="k")
            ax.set_ylabel(name)
            if self.amplitude.max() < 30.0 * self.amplitude.min():  # labels within a decade
                ax.xaxis.get_major_locator().set_params(subs=(1.0, 2.0, 5.0))
                ax.xaxis.set_major_formatter("{x:g}")
                ax.xaxis.set_minor_formatter("")
        mode = "AB"[self.mode] if self.mode < 2 else f"{self.mode}"
        axes[1].set_xlabel(f"amplitude of mode {mode} [{self.unit}]")
        return axes


def backbone_amplitudes(given: Any, measured: Floats) -> Floats:
    """Return amplitudes (n,) as given, checked, or 200 over the `measured` range (2,)."""
    if given is None:
        return np.geomspace(measured[0], measured[1], 200)
    amplitude = np.atleast_1d(as_floats("amplitude", given))
    positive = np.isfinite(amplitude) & (amplitude > 0.0)
    if amplitude.ndim > 1 or not amplitude.size or not positive.all():
        raise SlipmodeError("amplitude: must be finite numbers > 0 [sensor unit]")
    return amplitude


@frozen
class Source:
    """What the results of an identification are computed from.

    Attributes
    ----------
    measurement : Measurement
    plan : Plan
        How records are prepared.
    look : FirstLook
    decays : Decays
        The fitted records.
    left_out : sequence of SlowLaw
        The law without each of the records.
    """

    measurement: Measurement
    plan: Plan
    look: FirstLook
    decays: Decays
    left_out: Sequence[SlowLaw]


@frozen
class Identification:
    """A law of the slow flow identified from decays.

    Attributes
    ----------
    law : SlowLaw
    parameters : dict
        Value of each fitted parameter; units in `rom.identification.slow_laws`.
    deviation : dict
        Standard deviation of each, by the jackknife over the records. Infinite for fewer than
        three records.
    interval : dict
        95 % interval of each, (low, high).
    unidentified : tuple of str
        Parameters that the data do not determine: the half-width of their interval is larger than
        their size. Of fewer than three records, those without any effect.
    records : tuple of RecordReport
    range : (modes, 2) ndarray
        Smallest and largest amplitude of the fitted records in the reference channel [sensor
        unit].
    channel : str
        Reference channel.
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel.
    errors : dict
        Mean normalised error of each law in the prediction of loud records that it was not
        fitted to; empty if only one law was allowed.
    source : Source
        What these and further results are computed from.
    """

    law: SlowLaw
    parameters: dict[str, float]
    deviation: dict[str, float]
    interval: dict[str, tuple[float, float]]
    unidentified: tuple[str, ...]
    records: tuple[RecordReport, ...]
    range: Floats
    channel: str
    shapes: Any
    errors: dict[LawForm, float]
    source: Source = field(repr=False)

    def backbone(
        self, mode: int = 0, amplitude: Any = None, other: float = 0.0, extrapolate: bool = False
    ) -> DecayBackbone:
        """Return frequency and damping of a mode against its amplitude.

        Parameters
        ----------
        mode : int
            0 for A, 1 for B.
        amplitude : (n,) array_like, optional
            [sensor unit]. Default: 200 values over the measured range.
        other : float
            Amplitude of the other mode [sensor unit].
        extrapolate : bool
            Whether amplitudes above the measured range are allowed.

        Raises
        ------
        SlipmodeError
            If there is no such mode, or an amplitude is not positive or beyond the range.
        """
        modes = self.law.form.modes
        if mode not in range(modes):
            raise SlipmodeError(f"mode = {in_one_line(mode)}: must be 0 to {modes - 1}")
        r = backbone_amplitudes(amplitude, self.range[mode])
        self._check_range(mode, float(r.max()), extrapolate)
        if modes == 1 and other != 0.0:
            raise SlipmodeError(f"other = {other}: must be 0, there is one mode")
        sizes: list[Any] = [r] if modes == 1 else [r, np.full(r.size, other)]
        if mode == 1:
            sizes.reverse()
        laws = (self.law, *self.source.left_out)
        omega = np.array([law.frequencies(*sizes)[mode] for law in laws])
        zeta = np.array([law.damping_rates(*sizes)[mode] for law in laws]) / omega
        points = {name: look[mode] for name, look in self.source.look.rates.items()}
        return DecayBackbone(
            mode,
            r,
            omega[0],
            zeta[0],
            self._deviations(omega[1:]),
            self._deviations(zeta[1:]),
            self.source.measurement.unit,
            points,
            np.stack((omega[1:], zeta[1:]), axis=1),
        )

    def predict(self, record: str | int | Record, extrapolate: bool = False) -> Prediction:
        """Return the prediction of a decay from its first window alone.

        Parameters
        ----------
        record : str, int or Record
            A name or number in the measurement, fitted or not, or a record of the same channels.
        extrapolate : bool
            Whether it may start beyond the measured amplitudes.

        Raises
        ------
        SlipmodeError
            If there is no such record, it has other channels, it cannot be used, or it starts
            beyond the measured amplitudes.
        """
        given = record if isinstance(record, Record) else self.source.measurement[record]
        if len(given.signal) != len(self.shapes):
            raise SlipmodeError(
                f"record: has {len(given.signal)} channels, the measurement {len(self.shapes)}"
            )
        prepared = prepare(given, self.source.plan)
        if prepared.part is None:
            raise SlipmodeError(f"record: {prepared.name} cannot be used: {prepared.notes[-1]}")
        found = self._predicted([prepared.part])[0]
        if found.beyond and not extrapolate:
            raise SlipmodeError(
                f"record: {prepared.name}: {found.beyond} that was fitted; extrapolate=True "
                "predicts it nevertheless"
            )
        return found

    def model(
        self,
        *,
        modal_mass: Any = None,
        mode_shape: Any = None,
        amplitude: Any = None,
        tolerance: float = 1e-3,
        extrapolate: bool = False,
    ) -> Model:
        """Return the law as a model, for `fmu.Component`, FMUs, curves and scenes.

        The model has no contacts. Its DOFs are the channels of the measurement. Modal amplitudes
        follow from sensor amplitudes by `sensor_factors`.

        Parameters
        ----------
        modal_mass : float or (modes,) array_like, optional
            Modal masses at the reference channel [kg]. Default: 1 kg. Free decays do not determine
            it: with the default, forces are relative to an unknown modal mass.
        mode_shape : (modes,) array_like, optional
            Mass-normalised modes at the reference channel [kg^-1/2], instead of `modal_mass`.
        amplitude : (modes,) array_like, optional
            Largest amplitudes of the model [sensor unit]. Default: the largest measured ones.
        tolerance : float
            As in `rom.model_of_rates`.
        extrapolate : bool
            Whether `amplitude` may exceed the measured range.

        Raises
        ------
        SlipmodeError
            If the unit of the measurement is not one of displacement, velocity or acceleration,
            a modal mass is not positive, or an amplitude is beyond the range.

        Warns
        -----
        ValidityWarning
            If the law has a quadratic coupling, which the model leaves out. See also
            `rom.model_of_rates`.
        """
        modes = self.law.form.modes
        largest = as_floats("amplitude", self.range[:, 1] if amplitude is None else amplitude)
        if largest.shape != (modes,) or not np.all(np.isfinite(largest) & (largest > 0.0)):
            raise SlipmodeError(
                f"amplitude = {in_one_line(amplitude)}: must be {modes} finite numbers > 0 "
                "[sensor unit]"
            )
        for mode, size in enumerate(largest.tolist()):
            self._check_range(mode, size, extrapolate)
        shape = shape_at_sensor(modes, modal_mass, mode_shape)
        factors = self.sensor_factors(modal_mass=modal_mass, mode_shape=mode_shape)
        return model_of_law(self.law, factors, largest, self.shapes.real * shape, tolerance)

    def sensor_factors(self, *, modal_mass: Any = None, mode_shape: Any = None) -> Complexes:
        """Return the sensor amplitude of a modal amplitude of 1 kg^1/2 m, (modes,) complex.

        The reference channel measures y = Re sum_j factor_j a_j exp(i theta_j), with a_j and
        theta_j as in `fmu.Component`.

        Parameters
        ----------
        modal_mass, mode_shape
            Of `model`.
        """
        shape = shape_at_sensor(self.law.form.modes, modal_mass, mode_shape)
        return sensor_factors(self.law, self.source.measurement.unit, shape)

    def plot(self, axes: Any = None) -> Any:
        """Draw the backbone of each mode with the points of the records, (2, modes) axes."""
        modes = self.law.form.modes
        if axes is None:
            pyplot = extra("matplotlib.pyplot", "pictures")
            axes = pyplot.subplots(2, modes, sharex="col", squeeze=False)[1]
        for mode in range(modes):
            self.backbone(mode).plot(tuple(axes[:, mode]))
        axes[0, 0].legend(fontsize="small")
        return axes

    def _check_range(self, mode: int, largest: float, extrapolate: bool) -> None:
        if largest > self.range[mode, 1] * (1.0 + 1e-12) and not extrapolate:
            raise SlipmodeError(
                f"amplitude: {largest:.4g} is beyond the largest measured amplitude of mode "
                f"{'AB'[mode]}, {self.range[mode, 1]:.4g} {self.source.measurement.unit}; "
                "extrapolate=True allows it"
            )

    def _deviations(self, of_left_out: Floats) -> Floats:
        if len(of_left_out) < LEAST_RECORDS:
            return np.full(of_left_out.shape[1:], np.inf)
        return np.sqrt(jackknife_variance(of_left_out))

    def _predicted(self, records: Sequence[Record]) -> list[Prediction]:
        d = self.source.decays
        decays = Decays.of(records, d.carrier, d.shapes, d.reference, STEP / d.step)
        return predict(decays, self.law, self.source.left_out, self.range[:, 1])


def identify(
    data: Measurement,
    *,
    bands: Sequence[tuple[float, float]],
    law: LawName | Literal["auto"] = "auto",
    cross: bool | Literal["auto"] = "auto",
    hold_out: Sequence[str | int] = (),
) -> Identification:
    """Identify frequency and damping of one or two modes against their amplitudes from decays.

    The slow flow of the modes is fitted to the raw signals of all records: one law, and initial
    amplitudes for each record. See `rom.identification.slow_laws` for the laws.

    Parameters
    ----------
    data : Measurement
        Free decays, see `read_measurement`. The start and the usable part of each record are
        found; records with defects are excluded and named in `Identification.records`.
    bands : sequence of (float, float)
        Lower and upper end of a band around each of one or two modes [Hz], in which it is the
        only mode.
    law : {"auto", "linear", "iwan", "power", "quadratic"}
        "auto" chooses the law that predicts the loudest records best from a fit to the others.
        Fewer than three records cannot show effects of a mode on the other.
        "iwan" is the power law of friction alone, "quadratic" the power law with the quadratic
        coupling of two modes near 1:2.
    cross : {"auto", True, False}
        Whether the rates of a mode depend on the amplitude of the other mode.
    hold_out : sequence of str or int
        Names or numbers of records that are predicted, not fitted.

    Returns
    -------
    Identification

    Raises
    ------
    SlipmodeError
        If no record can be used, a band has no or two modes, bands overlap, the sampling rate is
        too low, or there are fewer data than parameters.

    References
    ----------
    M. Cenedese, J. Axas, B. Baeuerlein, K. Avila, G. Haller, Data-driven modeling and prediction
    of non-linearizable dynamics via spectral submanifolds, Nat. Commun. 13, 872 (2022): the error
    norm.
    """
    checked = checked_bands(bands, data)
    forms = allowed_forms(law, cross, checked)
    held = {data[key].name for key in hold_out}
    prepared, plan = prepare_all(data, checked)
    quadratic = any(form.law == "quadratic" for form in forms)
    while True:
        used = [p for p in prepared.values() if p.part is not None and p.name not in held]
        if not used:
            raise nothing_usable(prepared)
        look, guess, decays = first_guess(used, plan, quadratic)
        broken, doubtful = outliers(used, look, decays)
        if not broken:
            break
        for name, reason in broken.items():
            prepared[name] = prepared[name].excluded(reason)
    for name, note in doubtful.items():
        prepared[name] = replace(prepared[name], notes=(*prepared[name].notes, note))
    chosen, errors = select(decays, determined(forms, look), guess)
    found = fit_in_turn(decays, [chosen.form], chosen)[0]
    return _identification(data, plan, prepared, held, look, decays, found, errors)


def _identification(
    data: Measurement,
    plan: Plan,
    prepared: Mapping[str, Prepared],
    held: set[str],
    look: FirstLook,
    decays: Decays,
    found: Fit,
    errors: dict[LawForm, float],
) -> Identification:
    form = found.law.form
    left_out = found.left_out() if len(decays.records) > 1 else []
    names = [name for name, free in zip(form.names, form.free, strict=True) if free]
    values = found.law.values[form.free]
    deviation, half, unidentified = uncertainty(found)
    floor = [look.pooled(j).amplitude.min() for j in range(form.modes)]
    span = np.stack([floor, np.abs(found.start).max(axis=1)], axis=1)
    made = Identification(
        law=found.law,
        parameters=dict(zip(names, values.tolist(), strict=True)),
        deviation=dict(zip(names, deviation.tolist(), strict=True)),
        interval={
            name: (float(v - h), float(v + h))
            for name, v, h in zip(names, values, half, strict=True)
        },
        unidentified=unidentified,
        records=(),
        range=span,
        channel=data.channels[look.channel],
        shapes=look.shapes,
        errors=errors,
        source=Source(data, plan, look, decays, left_out),
    )
    usable = [p for p in (prepared[r.name] for r in data) if p.part is not None]
    predicted = made._predicted([p.part for p in usable if p.part is not None])
    predictions = {p.name: each for p, each in zip(usable, predicted, strict=True)}
    reports = []
    for record in data:
        p = prepared[record.name]
        each = predictions.get(record.name)
        if each is None:
            nothing = np.full(form.modes, np.nan)
            reports.append(RecordReport(p.name, "excluded", 0.0, 0.0, nothing, np.nan, p.notes))
            continue
        notes = list(p.notes)
        if each.beyond and record.name in held:
            notes.append(f"{each.beyond} that was fitted")
        use: Literal["fitted", "held out"] = "held out" if record.name in held else "fitted"
        first = each.amplitude[0]
        reports.append(RecordReport(p.name, use, p.start, p.end, first, each.error, tuple(notes)))
    return replace(made, records=tuple(reports))
