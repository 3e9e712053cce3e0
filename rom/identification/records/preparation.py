"""The usable part of each record, and what is wrong with the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen, percentage, short_list
from slipmode.rom.identification.first_look import (
    EDGE,
    SEEN,
    demodulate,
    noise_in_spectrum,
    spectrum,
)
from slipmode.rom.identification.records.defects import (
    Envelopes,
    defect,
    noise_around,
    remove_line,
    remove_tones,
    without_padding,
)
from slipmode.rom.identification.records.measurement import Bands, Measurement, Prepared, Record

ONSET = 0.1  # of the largest sample: where a blow begins
# Distance of a mode from an edge of its band, relative to the width, at which the filter of the
# first look has a third of its gain: exp(-0.5 (0.4 / 0.283)^2).
NEAR_EDGE = 0.1
SHORTEST = 5  # windows of the first look in the shortest usable part: two that are whole


def mode_frequencies(records: Sequence[Record], bands: Bands, alone: bool) -> Floats:
    """Return the frequency of the largest peak in each band, (modes,) [Hz].

    A band without a peak above the noise is refused and, where the modes have to be `alone`, a
    band with two.
    """
    found = np.empty(len(bands))
    for j, (low, high) in enumerate(bands):
        # Modes that are damped well are visible soon after the blow alone.
        looks = [_peaks(records, bands, j, share) for share in (1.0, 0.3, 0.1)]
        f, size, peaks = max(looks, key=lambda look: look[1][look[2]].max(initial=0.0))
        if not peaks.size:
            raise SlipmodeError(
                f"bands: {low:g} to {high:g} Hz has no decay of a mode, because no record has a "
                "peak above the noise there; choose another band"
            )
        k = int(peaks[size[peaks].argmax()])
        found[j] = f[k]
        if alone and min(f[k] - low, high - f[k]) < NEAR_EDGE * (high - low):
            reach = 0.5 * (high - low)
            raise SlipmodeError(
                f"bands: {low:g} to {high:g} Hz has its mode at {f[k]:.5g} Hz, where the filter "
                "of the band removes most of it; choose a band around the mode, for example "
                f"{f[k] - reach:.4g} to {f[k] + reach:.4g} Hz"
            )
        for other in peaks[size[peaks] > 0.05 * size[k]] if alone else ():
            between = size[min(k, other) : max(k, other) + 1].min()
            if abs(other - k) > 8 and between < 0.5 * size[other]:  # main lobes of the window
                raise SlipmodeError(
                    f"bands: {low:g} to {high:g} Hz has peaks at {f[k]:.5g} and {f[other]:.5g} Hz;"
                    " give each mode a band of its own"
                )
    return found


def _peaks(
    records: Sequence[Record], bands: Bands, j: int, share: float
) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Return frequencies [Hz], the spectrum of all records in a band, and its peaks above noise.

    Of each record, a share of the time from its onset on is seen. The spectrum is relative to the
    size from which a peak is above the noise.
    """
    duration = share * max(record.duration for record in records)
    f = np.arange(bands[j][0], bands[j][1], 0.5 / duration)
    square, seen = np.zeros(f.size), 0
    for record in records:
        for channel in record.signal:
            loudest = np.abs(channel).max()
            first = int(np.argmax(np.abs(channel) > ONSET * loudest))
            part = channel[first : first + int(share * channel.size)]
            g, size = spectrum(part, record.sample_rate)
            floor = (
                SEEN
                * noise_in_spectrum(part.size)
                * noise_around(channel, record.sample_rate, bands)
            )
            of_band = np.interp(f, g, size) / max(floor, SEEN * np.finfo(float).eps * loudest)
            if of_band.max(initial=0.0) > 1.0:
                square += of_band**2
                seen += 1
    size = np.sqrt(square / max(seen, 1))
    inner = size[1:-1]
    peaks = np.flatnonzero((inner > size[:-2]) & (inner >= size[2:]) & (inner > 1.0)) + 1
    return f, size, peaks


@frozen
class Plan:
    """How records of a measurement are prepared.

    Attributes
    ----------
    bands : tuple of (float, float)
        [Hz]
    modes : (modes,) ndarray
        Frequencies of the modes [Hz].
    other : float or None
        Frequency of the largest other mode [Hz], if such modes have to be filtered out.
    """

    bands: Bands
    modes: Floats
    other: float | None


def prepare_all(data: Measurement, bands: Bands) -> tuple[dict[str, Prepared], Plan]:
    """Return all records of a measurement by name, and the plan that others can follow.

    Other modes are filtered out of all records if they are visible in one.
    """
    checked = {record.name: _checked(record, bands) for record in data}
    sound = [p.part for p in checked.values() if p.part is not None]
    if not sound:
        raise nothing_usable(checked)
    rough = mode_frequencies(sound, bands, alone=False)
    clean = [_cleaned(record, rough)[0] for record in sound]
    modes = mode_frequencies(clean, bands, alone=True)
    plan = Plan(bands, modes, None)
    made = {record.name: prepare(record, plan) for record in data}
    outside = [_other_peak(p.part, bands) for p in made.values() if p.part is not None]
    share, frequency = max(outside, default=(0.0, 0.0))
    if share > 0.01:
        plan = Plan(bands, modes, frequency)
        made = {name: _filtered(each, plan) for name, each in made.items()}
    return made, plan


def nothing_usable(prepared: Mapping[str, Prepared]) -> SlipmodeError:
    """Return the refusal of a measurement of which no record can be used."""
    why = short_list(f"{p.name}: {p.notes[-1]}" for p in prepared.values() if p.part is None)
    return SlipmodeError(f"data: no record can be fitted ({why or 'all are held out'})")


def prepare(record: Record, plan: Plan) -> Prepared:
    """Return the usable part of a record."""
    checked = _checked(record, plan.bands)
    if checked.part is None:
        return checked
    clean, removed = _cleaned(checked.part, plan.modes)
    made = _usable(replace(checked, part=clean, notes=(*checked.notes, *removed)), plan)
    return made if plan.other is None else _filtered(made, plan)


def _checked(record: Record, bands: Bands) -> Prepared:
    """Return a whole record without padding, excluded if its samples have defects."""
    whole, notes = without_padding(record)
    found = Prepared(record.name, whole, 0.0, whole.duration, 0.0, (*record.notes, *notes))
    width = min(high - low for low, high in bands)
    if whole.duration * width < SHORTEST:
        return found.excluded(f"{whole.duration:.3g} s are too short for bands of {width:g} Hz")
    reason = defect(whole, bands)
    return found if reason is None else found.excluded(reason)


def _cleaned(record: Record, modes: Floats) -> tuple[Record, tuple[str, ...]]:
    """Return a record without offset, drift and steady tones, and what was removed."""
    level, first = remove_line(record, modes)
    clean, second = remove_tones(level, modes)
    return clean, (*first, *second)


def _usable(whole: Prepared, plan: Plan) -> Prepared:
    """Return the usable part of a clean record."""
    record = whole.part
    if record is None:
        return whole
    start, notes = _onset(record, plan)
    found = Envelopes.of(record.part(start, record.duration), plan.bands, plan.modes)
    if not (found.sizes > SEEN * found.noise[:, np.newaxis]).any():
        return whole.excluded("there is no decay above the noise in any band")
    parts = found.between_jumps()
    first, last = max(parts, key=lambda part: part[1] - part[0])
    if len(parts) > 1:
        notes += (
            f"there is another blow or disturbance, so only {start + first:.3g} to "
            f"{start + last:.3g} s are used",
        )
    last = min(last, found.last_above_noise(first))
    made = Prepared(
        record.name,
        record.part(start + first, start + last),
        start + first,
        start + last,
        max(noise_around(channel, record.sample_rate, plan.bands) for channel in record.signal),
        (*whole.notes, *notes),
    )
    if last - first < SHORTEST * EDGE * found.deviation:
        return made.excluded(
            f"its usable part, {made.start:.3g} to {made.end:.3g} s, is too short"
        )
    inside = found.energy[(found.times >= first) & (found.times <= last)]
    if inside.size < 2 or inside[-1] > inside[0] / 1.1:
        return made.excluded("the vibration does not decay")
    return made


def _filtered(made: Prepared, plan: Plan) -> Prepared:
    """Return a usable part that passed the filter of the first look, without the ends."""
    part = made.part
    if part is None:
        return made
    carriers = [np.pi * (low + high) for low, high in plan.bands]
    looks = [
        demodulate(part.signal, part.sample_rate, carrier, band)
        for carrier, band in zip(carriers, plan.bands, strict=True)
    ]
    first = max(look.times[0] for look in looks)
    last = min(look.times[-1] for look in looks)
    if last - first < SHORTEST * EDGE * max(look.deviation for look in looks):
        return made.excluded("its usable part is too short for the filter of other modes")
    waves = [
        (look.values * np.exp(1j * carrier * look.times)).real[
            :, (look.times >= first) & (look.times <= last)
        ]
        for look, carrier in zip(looks, carriers, strict=True)
    ]
    note = (
        f"other modes, the largest at {plan.other:.4g} Hz, were filtered out, and with them the "
        f"first {1e3 * first:.3g} ms"
    )
    return Prepared(
        made.name,
        replace(part, signal=np.sum(waves, axis=0)),
        made.start + first,
        made.start + last,
        made.noise,
        (*made.notes, note),
    )


def _other_peak(record: Record, bands: Bands) -> tuple[float, float]:
    """Return size and frequency [Hz] of the largest peak outside the bands.

    The size is relative to the peak in the bands, and 0 for noise.
    """
    worst = (0.0, 0.0)
    for channel in record.signal:
        f, size = spectrum(channel, record.sample_rate)
        inside = np.zeros(f.size, bool)
        for low, high in bands:
            inside |= (f >= low) & (f <= high)
        noise = noise_around(channel, record.sample_rate, bands) * noise_in_spectrum(channel.size)
        outside = np.where(inside | (f < 4.0 * f[1]), 0.0, size)
        k = int(outside.argmax())
        if outside[k] > SEEN * noise:
            worst = max(worst, (float(outside[k] / size[inside].max()), float(f[k])))
    return worst


def _onset(record: Record, plan: Plan) -> tuple[float, tuple[str, ...]]:
    """Return the time [s] from which a record decays: its beginning, or after the blow."""
    bands, modes = plan.bands, plan.modes
    relative = np.abs(record.signal) / np.abs(record.signal).max(axis=1, keepdims=True)
    first = int(np.argmax(relative.max(axis=0) > ONSET))
    if first / record.sample_rate < 0.25 / modes.max():
        return 0.0, ()
    notes: tuple[str, ...] = ()
    if first * modes.min() / record.sample_rate > 4.0:
        window = np.hanning(first)
        wave = np.exp(-2j * np.pi * np.multiply.outer(record.times[:first], modes))
        size = 2.0 * np.abs((window * record.signal[:, :first]) @ wave) / window.sum()
        noise = [noise_around(channel, record.sample_rate, bands) for channel in record.signal]
        floor = SEEN * noise_in_spectrum(first) * np.array(noise)[:, np.newaxis]
        share = size / np.abs(record.signal).max(axis=1, keepdims=True)
        loud = (size > floor) & (share > 0.1 * ONSET)
        if loud.any():
            notes = (
                f"it vibrates before the blow at {first / record.sample_rate:.3g} s with "
                f"{percentage(share[loud].max())} of the peak",
            )
    # A blow that excites a mode ends within about half a period of it: one period of the lowest
    # mode is past the blow.
    return first / record.sample_rate + 1.0 / float(modes.min()), notes
