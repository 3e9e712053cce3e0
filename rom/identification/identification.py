"""Identification of a law of the slow flow from measured decays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Literal

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import frozen
from slipmode.rom.identification.decay_flow import STEP, Decays
from slipmode.rom.identification.deviations import QUIET, Deviation
from slipmode.rom.identification.first_look import FirstLook
from slipmode.rom.identification.fit import Fit
from slipmode.rom.identification.models.identified import IdentifiedLaw
from slipmode.rom.identification.models.joint import joint_parameters
from slipmode.rom.identification.models.sensor_units import derivative
from slipmode.rom.identification.prediction import Prediction, predict
from slipmode.rom.identification.records.measurement import (
    Measurement,
    Prepared,
    Record,
    RecordReport,
    checked_bands,
)
from slipmode.rom.identification.records.preparation import (
    Plan,
    nothing_usable,
    prepare,
    prepare_all,
)
from slipmode.rom.identification.selection import (
    as_good,
    closest_fit,
    determined,
    first_guess,
    fit_in_turn,
    outliers,
    select,
    with_coupling,
)
from slipmode.rom.identification.slow_laws import LawForm, LawName, allowed_forms
from slipmode.rom.identification.uncertainty import uncertainty


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
    """

    measurement: Measurement
    plan: Plan
    look: FirstLook
    decays: Decays


@frozen
class Identification(IdentifiedLaw):
    """Hold a law of the slow flow identified from decays.

    An identification has all attributes of `IdentifiedLaw`, and the following.

    Attributes
    ----------
    records : tuple of RecordReport
        Report for each record.
    deviations : tuple of str
        One line for each mode whose rates, in windows of the records, deviate systematically from
        every allowed law. For such a mode `law` is the closest law and is not claimed: `deviation`
        and bands include the deviations, and the parameters of friction are unidentified.
    errors : dict of LawForm to float
        Mean normalised error of each form of the law [-], in the prediction of loud records that
        were not fitted. Empty if only one form was allowed.
    source : Source
        Data from which further results are computed.
    """

    records: tuple[RecordReport, ...]
    deviations: tuple[str, ...]
    errors: dict[LawForm, float]
    source: Source = field(repr=False)

    def predict(self, record: str | int | Record, extrapolate: bool = False) -> Prediction:
        """Return the prediction of a decay from its first window.

        Parameters
        ----------
        record : str, int or Record
            Name or number of a record of the measurement, or a record with the channels of the
            measurement.
        extrapolate : bool, default False
            Allow a decay that starts above the measured amplitudes.

        Returns
        -------
        Prediction
            Predicted signals, amplitudes and phases with their standard deviations.

        Raises
        ------
        SlipmodeError
            If there is no such record, it has other channels or is not usable, or it starts above
            the measured amplitudes.
        """
        given = record if isinstance(record, Record) else self.source.measurement[record]
        if len(given.signal) != len(self.shapes):
            raise SlipmodeError(
                f"record: has {len(given.signal)} channels, must have {len(self.shapes)} like the "
                "measurement"
            )
        prepared = prepare(given, self.source.plan)
        if prepared.part is None:
            raise SlipmodeError(f"record: {prepared.name} cannot be used: {prepared.notes[-1]}")
        found = self._predicted([prepared.part])[0]
        if found.beyond and not extrapolate:
            raise SlipmodeError(
                f"record: {prepared.name}: {found.beyond} that was fitted; give extrapolate=True "
                "to predict it nevertheless"
            )
        return found

    def _predicted(self, records: Sequence[Record]) -> list[Prediction]:
        d = self.source.decays
        decays = Decays.of(records, d.carrier, d.shapes, d.reference, STEP / d.step)
        return predict(decays, self.uncertainty, self.range[:, 1])


def identify(
    data: Measurement,
    *,
    bands: Sequence[tuple[float, float]],
    law: LawName | Literal["auto"] = "auto",
    cross: bool | Literal["auto"] = "auto",
    hold_out: Sequence[str | int] = (),
) -> Identification:
    """Return a law of frequency and damping against amplitude, identified from measured decays.

    The slow flow of one or two modes is fitted to the raw signals of all records, with one law,
    and initial amplitudes for each record.

    Parameters
    ----------
    data : Measurement
        Free decays, see `rom.read_measurement`. The start and the usable part of each record are
        detected. Records with defects are excluded and named in `Identification.records`.
    bands : sequence of (float, float)
        Frequency band [Hz] of each of one or two modes. Each band contains one mode.
    law : {"auto", "linear", "coulomb", "jenkins", "iwan", "power", "segalman",
        "quadratic"}, default "auto"
        Form of the law, see Notes. "auto" chooses the form that predicts the loudest records best
        after a fit to the others.
    cross : {"auto", True, False}, default "auto"
        Whether the rates of a mode depend on the amplitude of the other mode. At least three
        records are needed for "auto" to choose True.
    hold_out : sequence of str or int
        Names or numbers of records that are predicted and not fitted.

    Returns
    -------
    Identification
        Law with its uncertainty, and a report for each record.

    Raises
    ------
    SlipmodeError
        If no record is usable, a band has no mode or two modes, or bands overlap. If the sampling
        rate is too low, or there are fewer data than parameters.

    Notes
    -----
    With the complex amplitude a_j of mode j in sensor units::

        a_j' = (-delta_j + i omega_j) a_j + q_j(a),
        delta_j = delta_0 + g (s_j / R_j)^p,    omega_j = omega_0 - h (s_j / R_j)^p,
        s_A^2 = |a|^2 + kappa_A |b|^2,          s_B^2 = |b|^2 + kappa_B |a|^2.

    - "linear" has constant rates, g = h = 0.
    - "coulomb" has constant rates and a constant friction force: p = -1, h = 0.
    - "jenkins" is one Jenkins element, for one mode: constant rates in stick. Beyond macro-slip
      friction adds g R / s to the damping rate, and the frequency tends to omega_0 - h.
    - "segalman" is Segalman's four-parameter Iwan law up to macro-slip and beyond, for one mode:
      p = chi + 1, and J = beta / (1 + beta) is the share of the stiffness lost at macro-slip.
    - "iwan" is the power law of friction alone: h follows from g by Masing's rule.
    - "power" has free g, h and p.
    - "quadratic" adds q_A = q_1 conj(a) b and q_B = q_2 a^2, for two modes near 1:2. "auto" tries
      it if the frequency of B differs from twice the frequency of A by at most three times the
      fastest rate of change of the amplitudes.

    "auto" tries "jenkins" and "segalman" if a record is not described by a constant friction force
    or a power law. With them `parameters` has `limit_A`, the force of macro-slip per modal mass
    [N/kg], and `ratio_A`, the stiffness of the mode in slip relative to stick [-].

    No law is claimed for a mode whose rates, in windows of the records, deviate from every allowed
    law by more than 5 % of the damping rate at several amplitudes: see
    `Identification.deviations`.

    References
    ----------
    Segalman, D. J., A four-parameter Iwan model for lap-type joints, J. Appl. Mech. 72 (2005).

    Cenedese, M., J. Axas, B. Baeuerlein, K. Avila, G. Haller, Data-driven modeling and prediction
    of non-linearizable dynamics via spectral submanifolds, Nat. Commun. 13, 872 (2022): the error
    norm.

    Examples
    --------
    One mode between 80 and 120 Hz from hammer tests::

        data = rom.read_measurement("hit*.csv", quantity="acceleration", unit="m/s^2")
        found = rom.identify(data, bands=[(80.0, 120.0)])
        found.backbone().plot()
    """
    checked = checked_bands(bands, data)
    forms = allowed_forms(law, cross, len(checked))
    held = {data[key].name for key in hold_out}
    prepared, plan = prepare_all(data, checked)
    while True:
        used = [p for p in prepared.values() if p.part is not None and p.name not in held]
        if not used:
            raise nothing_usable(prepared)
        look, guess, decays = first_guess(used, plan, derivative(data.unit))
        broken, doubtful, without_macro_slip = outliers(used, look, decays, forms)
        if not broken:
            break
        for name, reason in broken.items():
            prepared[name] = prepared[name].excluded(reason)
    for name, note in doubtful.items():
        prepared[name] = replace(prepared[name], notes=(*prepared[name].notes, note))
    if law == "auto" and without_macro_slip:
        forms = [form for form in forms if form.kind != "macro-slip"]
    considered, decays = with_coupling(determined(forms, look), decays)
    chosen, errors = select(decays, considered, guess, look)
    closest, deviations = closest_fit(decays, look, plan.bands, chosen, errors)
    found = [closest]
    for form in as_good(closest.law.form, errors):
        found += fit_in_turn(decays, [form], chosen, look)
    source = Source(data, plan, look, decays)
    return _identification(source, prepared, held, found, deviations, errors)


def _identification(
    source: Source,
    prepared: Mapping[str, Prepared],
    held: set[str],
    fits: Sequence[Fit],
    deviations: Sequence[Deviation],
    errors: dict[LawForm, float],
) -> Identification:
    """Return the result of the first of several fits; the others are as good."""
    data, look, found = source.measurement, source.look, fits[0]
    form = found.law.form
    names = [name for name, free in zip(form.names, form.free, strict=True) if free]
    values = found.law.values[form.free]
    largest = np.abs(found.start).max(axis=1)
    heard = np.array([look.pooled(j).amplitude.min() for j in range(form.modes)])
    floor = np.maximum(heard, QUIET * largest)
    scatter, deviation, half, unidentified = uncertainty(fits, source.decays, floor, deviations)
    if form.kind == "macro-slip":
        for name, (origin, value, slope) in joint_parameters(found.law, data.unit).items():
            k = names.index(origin)
            values = np.append(values, value)
            deviation, half = (np.append(x, abs(slope) * x[k]) for x in (deviation, half))
            names.append(name)
            unidentified += (name,) if origin in unidentified else ()
    made = Identification(
        law=found.law,
        parameters=dict(zip(names, values.tolist(), strict=True)),
        deviation=dict(zip(names, deviation.tolist(), strict=True)),
        interval={
            name: (float(v - h), float(v + h))
            for name, v, h in zip(names, values, half, strict=True)
        },
        unidentified=unidentified,
        range=np.stack([floor, largest], axis=1),
        unit=data.unit,
        channels=data.channels,
        channel=data.channels[look.channel],
        shapes=look.shapes,
        points=look.rates,
        uncertainty=scatter,
        records=(),
        deviations=tuple(each.line(data.unit) for each in deviations),
        errors=errors,
        source=source,
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
