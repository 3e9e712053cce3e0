"""The usable part of each record, and what is wrong with the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.defects import defect, remove_hum
from slipmode.rom.identification.first_look import (
    EDGE,
    SEEN,
    demodulate,
    envelope_noise,
    noise_density,
    spectrum,
)
from slipmode.rom.identification.measurement import Bands, Measurement, Prepared, Record
from slipmode.rom.short_repr import frozen

ONSET = 0.1  # of the largest sample: where a blow begins
RISE = 1.3  # factor of the energy of all modes that only a blow can add
AUDIBLE = 20.0  # amplitude relative to its noise from which rises are read as blows
SECOND_PEAK = 0.05  # size of another peak of a band relative to the first that is a second mode
SHORTEST = 8  # windows of the first look in the shortest usable part


class _UnusableError(Exception):
    """Why a record is excluded."""


def mode_frequencies(records: Sequence[Record], bands: Bands) -> Floats:
    """Return the frequency of the largest peak in each band, (modes,) [Hz].

    A band with two peaks is refused.
    """
    found = np.empty(len(bands))
    for j, (low, high) in enumerate(bands):
        longest = max(record.duration for record in records)
        f = np.arange(low, high, 0.5 / longest)
        total = np.zeros(f.size)
        for record in records:
            for channel in record.signal:
                g, size = spectrum(channel, record.sample_rate)
                total += (np.interp(f, g, size) / np.abs(channel).max()) ** 2
        size = np.sqrt(total)
        k = int(size.argmax())
        found[j] = f[k]
        peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
        for other in peaks[size[peaks] > SECOND_PEAK * size[k]]:
            between = size[min(k, other) : max(k, other) + 1].min()
            if abs(f[other] - f[k]) > 4.0 / longest and between < 0.5 * size[other]:
                raise SlipmodeError(
                    f"bands: {low:g} to {high:g} Hz has peaks at {f[k]:.5g} and {f[other]:.5g} Hz;"
                    " give each mode a band of its own"
                )
    return found


def sound(measurement: Measurement, bands: Bands) -> tuple[list[Record], dict[str, Prepared]]:
    """Return records without defects in their samples, and the others by name."""
    good, bad = [], {}
    for record in measurement:
        record, notes = _without_padding(record)
        if record.duration * min(band[1] - band[0] for band in bands) < SHORTEST:
            found: str | None = f"{record.duration:.3g} s are too short for the bands"
        else:
            found = defect(record, bands)
        if found is None:
            good.append(record)
        else:
            nothing = np.zeros(len(bands))
            bad[record.name] = Prepared(record.name, None, 0.0, 0.0, nothing, (*notes, found))
    return good, bad


def _without_padding(record: Record) -> tuple[Record, list[str]]:
    """Return a record without NaN after its end, by which arrays of several records are filled."""
    known = np.flatnonzero(np.isfinite(record.signal).any(axis=0))
    samples = int(known[-1]) + 1 if known.size else 0
    if samples in (0, record.samples):
        return record, []
    note = f"{record.samples - samples} samples after {samples / record.sample_rate:.4g} s are NaN"
    return Record(record.name, record.signal[:, :samples], record.sample_rate), [note]


def prepare(record: Record, bands: Bands, modes: Floats) -> Prepared:
    """Return the usable part of a record without defects; `modes` (modes,) [Hz]."""
    record, notes = remove_hum(record, modes)
    noise = np.zeros(len(bands))
    try:
        start = _onset(record, modes, notes)
        end = record.duration
        part = record.part(start, end)
        found = _Energy.of(part, bands, modes)
        noise = found.noise
        if not (found.amplitudes > SEEN * noise[:, np.newaxis]).any():
            raise _UnusableError("no decay rises from the noise in any band")
        spans = found.between_blows()
        if len(spans) > 1:
            at = ", ".join(f"{start + span[0]:.3g}" for span in spans[1:])
            notes.append(f"another blow or disturbance before {at} s; the longest part is used")
        first, last = max(spans, key=lambda span: span[1] - span[0])
        last = min(last, found.last_above_noise(first))
        if last - first < SHORTEST * EDGE * found.deviation:
            raise _UnusableError(f"the usable part from {start + first:.3g} s is too short")
        inside = found.energy[(found.times >= first) & (found.times <= last)]
        if inside.size < 2 or inside[-1] > inside[0] / 1.1:
            raise _UnusableError("the vibration does not decay")
    except _UnusableError as reason:
        return Prepared(record.name, None, 0.0, 0.0, noise, (*notes, str(reason)))
    start, end = start + first, start + last
    return Prepared(record.name, record.part(start, end), start, end, noise, tuple(notes))


def _onset(record: Record, modes: Floats, notes: list[str]) -> float:
    """Return the time [s] from which a record decays: its beginning, or after the blow."""
    relative = np.abs(record.signal) / np.abs(record.signal).max(axis=1, keepdims=True)
    first = int(np.argmax(relative.max(axis=0) > ONSET))
    if first / record.sample_rate < 0.25 / modes.max():
        return 0.0
    before = record.signal[:, :first]
    if first * modes.min() / record.sample_rate > 4.0:
        window = np.hanning(first)
        wave = np.exp(-2j * np.pi * np.multiply.outer(record.times[:first], modes))
        size = 2.0 * np.abs((window * before) @ wave) / window.sum()
        after = record.signal[:, first:]
        density = [
            noise_density(channel, record.sample_rate, 0.5 * modes.min(), 1.5 * modes.max())
            for channel in record.signal
        ]
        noise = np.sqrt(6.0 * np.array(density) / first)[:, np.newaxis]
        share = size / np.abs(after).max(axis=1, keepdims=True)
        loud = (size > 5.0 * noise) & (share > 1e-2)
        if loud.any():
            notes.append(
                f"it vibrates before the blow at {first / record.sample_rate:.3g} s, "
                f"{100 * share[loud].max():.2g} % of the peak"
            )
    # A blow that excites a mode ends within about half a period of it: one period of the lowest
    # mode is past the blow.
    return first / record.sample_rate + 1.0 / float(modes.min())


@frozen
class _Energy:
    """Energy of all modes and channels against time, in squared sensor units."""

    times: Floats
    energy: Floats
    amplitudes: Floats
    noise: Floats
    deviation: float

    @classmethod
    def of(cls, record: Record, bands: Bands, modes: Floats) -> _Energy:
        low, high = 0.5 * modes.min(), min(1.5 * modes.max(), 0.5 * record.sample_rate)
        density = sum(
            noise_density(channel, record.sample_rate, low, high) for channel in record.signal
        )
        # One width for all modes, so that the envelopes have the same times.
        half = 0.5 * min(band[1] - band[0] for band in bands)
        squares: list[Floats] = []
        noise = np.empty(len(bands))
        for j, frequency in enumerate(modes):
            band = (frequency - half, frequency + half)
            look = demodulate(record.signal, record.sample_rate, 2.0 * np.pi * frequency, band)
            values: Complexes = look.values
            squares.append((np.abs(values) ** 2).sum(axis=0))
            noise[j] = envelope_noise(density, look, record.sample_rate)
        amplitudes = np.sqrt(np.array(squares))
        return cls(look.times, np.sum(squares, axis=0), amplitudes, noise, look.deviation)

    def between_blows(self) -> list[tuple[float, float]]:
        """Return parts in which the energy only falls, as pairs of times [s]."""
        floor = (AUDIBLE**2) * np.sum(self.noise**2)
        step = self.times[1] - self.times[0]
        stride = max(int(0.25 * self.deviation / step), 1)
        t, energy = self.times[::stride], self.energy[::stride]
        spans, first, k = [], 0.0, 0
        while True:
            lowest = np.minimum.accumulate(energy[k:])
            rises = np.flatnonzero((energy[k:] > RISE * lowest) & (energy[k:] > floor))
            if not rises.size:
                end = self.times[-1] + EDGE * self.deviation
                return [*spans, (first, end)]
            blow = k + int(rises[0])
            valley = k + int(np.argmin(energy[k : blow + 1]))
            spans.append((first, max(t[valley] - 2.0 * self.deviation, first)))
            k = blow
            while k + 1 < len(energy) and energy[k + 1] > energy[k]:
                k += 1
            first = t[k] + 2.0 * self.deviation

    def last_above_noise(self, first: float) -> float:
        """Return the last time [s] at which a mode stands out of the noise."""
        above = (self.amplitudes > 3.0 * self.noise[:, np.newaxis]).any(axis=0)
        # Stretches of noise exceed three deviations now and then: the decay ends where the mean
        # over ten windows falls below.
        width = max(int(10.0 * self.deviation / (self.times[1] - self.times[0])), 1)
        share = np.convolve(above, np.full(width, 1.0 / width), mode="same")
        loud = self.times[(share > 0.5) & (self.times >= first)]
        at_end = loud.size and loud[-1] >= self.times[-1] - 5.0 * self.deviation
        end = self.times[-1] + EDGE * self.deviation
        return float(end if at_end or not loud.size else loud[-1])
