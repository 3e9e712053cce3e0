"""Choice of a law: it has to predict the loudest records from a fit to the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import percentage
from slipmode.rom.identification.decay_flow import STEP, Decays
from slipmode.rom.identification.deviations import QUIET, Deviation, systematic_deviations
from slipmode.rom.identification.first_look import FirstLook
from slipmode.rom.identification.fit import Fit, fit
from slipmode.rom.identification.initial_amplitudes import first_window, initial_amplitudes
from slipmode.rom.identification.prediction import normalised_error
from slipmode.rom.identification.records.measurement import Bands, Prepared
from slipmode.rom.identification.records.preparation import Plan
from slipmode.rom.identification.slow_laws import CONSTANT_FORCE, LawForm, LawName, SlowLaw

# Distance from 1:2, relative to the fastest rate of slow time, up to which laws with a quadratic
# coupling are tried. There the coupling drives B at a third of the amplitude at resonance, and to
# resolve its beat takes three times as many steps.
NEAR = 3.0
SHARE = 3  # one record of so many is left out
# A law with more terms has to have a smaller error by this factor.
BETTER = 0.98
# Segalman's law instead of a smaller one. With its two shape parameters it also follows errors of
# averaging: of one Jenkins element it had 0.88 of the error (test_macro_slip.py).
MUCH_BETTER = 0.8
# Relative error of a signal by steps and by the end of the iterations. Of drawn decays without
# noise it is up to 8e-5 (test_decays.py).
RESOLVED = 1e-4
# Error of a record's own fit from which it is excluded: relative to the norm of its signal, and
# to the median of the records or the noise; and the latter from which it is mentioned. Of the
# records of the double beam none is above 1.6 times the median.
POOR, OUTLYING, DOUBTFUL = 0.05, 4.0, 2.0
# Error of a record's own fit, relative to the noise, up to which no other law is tried.
DESCRIBED = 1.2
# Error of a signal by averaging over cycles in which the amplitude of a slipping joint falls.
AVERAGING_ERROR = 0.01


def first_guess(
    used: Sequence[Prepared], plan: Plan, derivative: int
) -> tuple[FirstLook, SlowLaw, Decays]:
    """Return the first look at records, the law that it shows, and the records for fits."""
    look = FirstLook.of(used, plan.bands, plan.modes, derivative)
    for j, (low, high) in enumerate(plan.bands):
        if len(look.pooled(j).times) < 2:
            raise SlipmodeError(
                f"bands: the mode of {low:g} to {high:g} Hz decays into the noise too soon in all "
                "records; choose a wider band"
            )
    guess = look.guess()
    sizes = [np.array([0.0, size]) for size in look.reference]
    detuning = guess.frequencies(*sizes) - look.carrier[:, np.newaxis]
    rate = float(np.hypot(guess.damping_rates(*sizes), detuning).max())
    # The rate of a constant friction force is largest at the smallest amplitude.
    least = [
        np.maximum(look.pooled(j).amplitude.min(keepdims=True), QUIET * reference)
        for j, reference in enumerate(look.reference)
    ]
    rate = max(rate, float(look.guess(CONSTANT_FORCE).damping_rates(*least).max()))
    records = [each.part for each in used if each.part is not None]
    return look, guess, Decays.of(records, look.carrier, look.shapes, look.reference, rate)


def with_coupling(forms: Sequence[LawForm], decays: Decays) -> tuple[Sequence[LawForm], Decays]:
    """Return laws without quadratic coupling that is too far from 1:2, and records for the others.

    The slow time of the records resolves the beat of the coupling. A coupling that is the only
    law is kept.
    """
    if not any(form.law == "quadratic" for form in forms):
        return forms, decays
    d = decays
    beat, rate = abs(d.carrier[1] - 2.0 * d.carrier[0]), STEP / d.step
    apart = [form for form in forms if form.law != "quadratic"]
    if apart and beat > NEAR * rate:
        return apart, decays
    if beat > rate:
        decays = Decays.of(d.records, d.carrier, d.shapes, d.reference, beat)
    return forms, decays


def determined(forms: Sequence[LawForm], look: FirstLook) -> list[LawForm]:
    """Return the laws with no more parameters than the first look has independent values.

    Effects of a mode on the other are left out, if they need not be there, for fewer than three
    records: both amplitudes fall along one line in each record.
    """
    # A window gives two values of a mode, and half of it is in the window before.
    values = sum(len(look.pooled(j).times) for j in range(len(look.carrier)))
    kept = [form for form in forms if form.free.sum() <= values]
    if not kept:
        raise SlipmodeError(
            f"law = {forms[0]}: has {forms[0].free.sum()} parameters, but the records have only "
            f"{values} independent values of frequency and damping; give more or longer records"
        )
    apart = [form for form in kept if not form.cross and form.law != "quadratic"]
    return apart if apart and len(look.rates) < SHARE else kept


def outliers(
    used: Sequence[Prepared], look: FirstLook, decays: Decays, allowed: Sequence[LawForm]
) -> tuple[dict[str, str], dict[str, str], bool]:
    """Return records that no decay fits, by name with the reason, and those that look doubtful.

    Each record is fitted alone, so that a broken one does not spoil the others. Also return
    whether laws without macro-slip describe all records.
    """
    modes = len(look.carrier)
    laws: tuple[LawName, ...] = ("power", "coulomb", "jenkins", "segalman")
    forms = [LawForm(modes, law, False) for law in (laws if modes == 1 else laws[:2])]
    if len(allowed) == 1 and allowed[0] in forms:
        forms = sorted(forms, key=lambda form: form != allowed[0])  # it comes first
    errors, noise, without_macro_slip = {}, {}, True
    for i, each in enumerate(used):
        rates = look.rates[each.name]
        if min(len(of_mode.times) for of_mode in rates) < 2:
            continue  # one of the modes is too quiet to be fitted alone
        guess = replace(look, rates={each.name: rates}).guess()
        noise[each.name] = each.noise / np.sqrt(np.mean(decays.records[i].signal ** 2))
        errors[each.name], averaging = np.inf, 0.0
        for form in forms:
            if errors[each.name] <= max(DESCRIBED * max(noise[each.name], RESOLVED), averaging):
                break  # the law before describes it
            averaging = AVERAGING_ERROR if form.kind == "macro-slip" else 0.0
            without_macro_slip &= form.kind != "macro-slip"
            try:
                (found,) = fit_in_turn(decays.only([i]), [form], guess, look)
            except SlipmodeError:
                continue
            errors[each.name] = min(errors[each.name], float(np.sqrt(found.normal.cost.sum())))
    typical = float(np.median(list(errors.values()))) if len(errors) >= SHARE else 0.0
    broken, doubtful = {}, {}
    for name, error in errors.items():
        usual = max(typical, noise[name], RESOLVED)
        if error > (DOUBTFUL * usual if typical else POOR):
            line = f"the error of its own fit is {percentage(error)} of the signal"
            if typical:
                line += f", {error / typical:.2g} times the median of the records"
            if error > max(POOR, OUTLYING * usual):
                broken[name] = f"no decay fits it: {line}"
            else:
                doubtful[name] = f"{line}; check it for disturbances"
    return broken, doubtful, without_macro_slip


def fit_in_turn(
    decays: Decays, forms: Sequence[LawForm], guess: SlowLaw, look: FirstLook
) -> list[Fit]:
    """Return the fits of laws, each from the guess or the fit of a power law before it."""
    window = first_window(decays.carrier)
    start = np.array(
        [initial_amplitudes(r, guess, decays.shapes, window)[0] for r in decays.records]
    ).T
    made: list[Fit] = []
    values = guess.values
    for form in forms:
        initial = _of_form(replace(guess, values=values), form, look)
        found = fit(decays, form, initial.values, start)
        made.append(found)
        if form.law in ("power", "quadratic"):
            values, start = found.law.values, found.start
    return made


def _of_form(guess: SlowLaw, form: LawForm, look: FirstLook) -> SlowLaw:
    """Return a guess with the terms of a law.

    Laws with and without macro-slip have no terms in common: the first look replaces the guess.
    """
    if form.kind == "macro-slip" and form != guess.form:
        return look.macro_slip_guess(form)
    if form.kind != "macro-slip" and guess.form.kind == "macro-slip":
        guess = look.guess()
    return replace(guess, form=form, values=form.without_others(guess.values))


def prediction_error(decays: Decays, law: SlowLaw) -> float:
    """Return the mean normalised error of predictions of records."""
    window = first_window(decays.carrier)
    known = [initial_amplitudes(r, law, decays.shapes, window)[0] for r in decays.records]
    signals = decays.signals(law, np.array(known).T)
    return float(
        np.mean(
            [
                normalised_error(r.signal, signal, round(window * r.sample_rate))
                for r, signal in zip(decays.records, signals, strict=True)
            ]
        )
    )


def select(
    decays: Decays, forms: Sequence[LawForm], guess: SlowLaw, look: FirstLook
) -> tuple[SlowLaw, dict[LawForm, float]]:
    """Return the law that predicts the loudest third of the records, and the errors of all laws.

    It has the values of its fit to the other records. Of fewer than three records, the loud first
    part of each is left out. A single law is returned as it was guessed.
    """
    if len(forms) == 1:
        return _of_form(guess, forms[0], look), {}
    loudness = [float(np.abs(record.signal).max()) for record in decays.records]
    order = np.argsort(loudness).tolist()
    kept = len(order) - -(-len(order) // SHARE)
    if len(order) >= SHARE:
        quiet, loud = decays.only(order[:kept]), decays.only(order[kept:])
    else:
        quiet, loud = quiet_parts(decays), decays
    laws = [found.law for found in fit_in_turn(quiet, forms, guess, look)]
    errors = {law.form: max(prediction_error(loud, law), RESOLVED) for law in laws}
    chosen = laws[0]
    for law in laws[1:]:
        least = MUCH_BETTER if law.form.law == "segalman" else BETTER
        if errors[law.form] < least * errors[chosen.form]:
            chosen = law
    return chosen, errors


def closest_fit(
    decays: Decays, look: FirstLook, bands: Bands, chosen: SlowLaw, errors: dict[LawForm, float]
) -> tuple[Fit, list[Deviation]]:
    """Return the fit of the chosen law, and the systematic deviations of measured rates from it.

    If there are any, the law with the fewest of them is taken, of equal ones the best. Quadratic
    coupling has to be chosen, because models do not contain it.
    """
    others = sorted(errors, key=errors.__getitem__)
    others = [form for form in others if form != chosen.form and form.law != "quadratic"]
    made = []
    for form in (chosen.form, *others):
        found = fit_in_turn(decays, [form], chosen, look)[0]
        made.append((found, systematic_deviations(found, decays, look, bands)))
        if not made[-1][1]:
            break
    return min(made, key=lambda each: len(each[1]))


def as_good(chosen: LawForm, errors: dict[LawForm, float]) -> list[LawForm]:
    """Return the other nonlinear laws that predict as well as the chosen one.

    Segalman's law is left out: the data do not determine its shape if a smaller law suffices.
    """
    return [
        form
        for form, error in errors.items()
        if form != chosen
        and form.law not in ("linear", "segalman")
        and BETTER * error <= errors[chosen]
    ]


def quiet_parts(decays: Decays) -> Decays:
    """Return records from the time on at which their envelope has fallen to a half."""
    window = first_window(decays.carrier)
    parts = []
    for record in decays.records:
        samples = max(round(window * record.sample_rate), 1)
        energy = (record.signal**2).sum(axis=0)
        envelope = np.convolve(energy, np.ones(samples), mode="valid")
        first = int(np.argmax(envelope < 0.25 * envelope[0])) / record.sample_rate
        parts.append(record.part(first, record.duration))
    d = decays
    return Decays.of(parts, d.carrier, d.shapes, d.reference, STEP / d.step)
