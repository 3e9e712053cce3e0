"""Defects of a record: those that exclude it, those that are removed, and further blows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from slipmode.rom.common import Complexes, Floats, frozen, percentage
from slipmode.rom.identification.first_look import (
    EDGE,
    SEEN,
    demodulate,
    envelope_noise,
    noise_in_spectrum,
    noise_level,
    spectrum,
)
from slipmode.rom.identification.records.measurement import Bands, Record

# A converter at its limit repeats one value at each peak, in at least two periods. Unclipped
# samples of a sinusoid pile up at its peaks too: on the highest level of a converter there are
# at most 2.4 = 1 / (sqrt 2 - 1) times as many as on the next.
CLIPPED_SAMPLES, CLIPPED_RATIO = 4, 4.0
# Periods that a sensor without contact keeps its value. A sinusoid of amplitude A keeps it
# within the resolution q for 2 sqrt(2 q / A) / omega at its peak, a sum of two for up to twice so.
DROPOUT_PERIODS = 0.25
# Decay of a tone from the third to the last quarter of a record, up to which it is steady.
STEADY = 0.02
# Change of the amplitudes, relative to all of them, that is another blow. Smaller ones leave a
# record that no law fits, see `selection.outliers`.
JUMP = 0.15
# Amplitude relative to its noise from which jumps are searched: a jump between lines fitted to
# both sides has 3.75 times the deviation of the noise, 15 in the largest of hundreds.
AUDIBLE = 20.0


def without_padding(record: Record) -> tuple[Record, tuple[str, ...]]:
    """Return a record without NaN and rest after its end.

    NaN fills arrays of several records. At rest the signal keeps its value: friction has stopped
    the motion, in a displacement at an offset.
    """
    finite = np.asarray(np.isfinite(record.signal).any(axis=0))
    last = int(finite[::-1].argmax())  # samples that are NaN
    signal = record.signal[:, : record.samples - last]
    moving = np.flatnonzero((signal != signal[:, -1:]).any(axis=0))
    samples = int(moving[-1]) + 1 if moving.size else 0
    if samples in (0, record.samples - 1):  # constant, or the last sample moves as well
        samples = record.samples - last
    end = (record.samples - last) / record.sample_rate
    note = f"its last {last} samples, from {end:.4g} s on, are NaN"
    return replace(record, signal=signal[:, :samples]), (note,) if last else ()


def defect(record: Record, bands: Bands) -> str | None:
    """Return in one line why a record cannot be used, if that shows in its samples."""
    for signal in record.signal:
        wrong = np.flatnonzero(~np.isfinite(signal))
        if wrong.size:
            first = wrong[0] / record.sample_rate
            return f"{wrong.size} samples are no finite numbers, the first at {first:.4g} s"
        if np.ptp(signal) == 0.0:
            return "the signal is constant"
        found = _clipping(signal) or _dropout(signal, record.sample_rate, bands)
        if found:
            return found
    return None


def _clipping(signal: Floats) -> str | None:
    for side in (signal, -signal):
        largest = side.max()
        count = int((side == largest).sum())
        next_level = side[side < largest].max()
        if count >= CLIPPED_SAMPLES and count >= CLIPPED_RATIO * (side == next_level).sum():
            level = largest if side is signal else -largest
            return f"it is clipped: {count} samples are exactly {level:.4g}"
    return None


def _dropout(signal: Floats, sample_rate: float, bands: Bands) -> str | None:
    """Return the first run of equal samples amid vibration, in one line."""
    least = max(4, int(np.ceil(DROPOUT_PERIODS * sample_rate / bands[-1][1])) + 1)
    period = int(sample_rate / bands[0][0]) + 1
    steps = np.abs(np.diff(signal))
    resolution = steps[steps > 0.0].min()
    bounds = np.concatenate([[0], np.flatnonzero(steps) + 1, [signal.size]])
    for k in np.flatnonzero(np.diff(bounds) >= least):
        first, last = bounds[k], bounds[k + 1]
        sides = [signal[max(first - period, 0) : first], signal[last : last + period]]
        if not sides[0].size:  # before the blow
            continue
        around = 0.5 * max(np.ptp(side) for side in sides if side.size)
        if around == 0.0:
            continue
        at_peak = 4.0 * np.sqrt(2.0 * resolution / around) / (2.0 * np.pi * bands[0][0])
        if around > 5e-3 * np.ptp(signal) and (last - first - 1) / sample_rate > at_peak:
            return (
                f"the signal drops out at {first / sample_rate:.4g} s: {last - first} samples "
                "are equal during vibration"
            )
    return None


def remove_line(record: Record, modes: Floats) -> tuple[Record, tuple[str, ...]]:
    """Return a record without offset and drift, if these are visible; `modes` (modes,) [Hz]."""
    x = np.linspace(-1.0, 1.0, record.samples)
    signal = record.signal.copy()
    notes: tuple[str, ...] = ()
    for channel in signal:
        line = np.polynomial.Polynomial.fit(x, channel, 1)(x)
        share = np.abs(line).max() / np.abs(channel - line).max()
        # 1 % of the peak is visible. A decay itself leaves up to 4 / (omega T) of it in a line.
        if share > max(0.01, 10.0 / (2.0 * np.pi * modes.min() * record.duration)):
            channel -= line
            notes = (f"an offset or drift of {percentage(share)} of the peak was removed",)
    return replace(record, signal=signal), notes


def remove_tones(record: Record, modes: Floats) -> tuple[Record, tuple[str, ...]]:
    """Return a record without hum and other steady tones; `modes` (modes,) [Hz].

    Tones next to a mode cannot be distinguished from it and stay.
    """
    signal = record.signal.copy()
    notes: list[str] = []
    half = record.samples // 2
    window = np.hanning(record.samples - half)
    for channel in signal:
        peak = np.abs(channel).max()
        for _ in range(4):  # hum and its harmonics
            early, late = channel[:half], channel[half:]
            f, size = spectrum(late, record.sample_rate)
            away = np.abs(f[:, np.newaxis] - modes).min(axis=1) > 4.0 * f[1]
            k = int(np.argmax(size * (away & (f > 4.0 * f[1]) & (f < f[-1]))))
            noise = noise_level(late, record.sample_rate, f[1], f[-1]) * noise_in_spectrum(
                late.size
            )
            if size[k] < max(2e-3 * peak, 10.0 * noise):  # not visible
                break
            frequency = _frequency(late, record.sample_rate, f[k - 1], f[k + 1])
            a, b = (abs(_tone(part, frequency / record.sample_rate)) for part in (early, late))
            # The late free vibration of a stuck joint decays, though slowly.
            first, last = (
                abs(_tone(part, frequency / record.sample_rate))
                for part in (late[: half // 2], late[half // 2 :])
            )
            decays = first > (1.0 + STEADY + 4.0 * noise / size[k]) * last
            if abs(a - b) > 0.2 * b or decays:  # not steady
                break
            wave = np.exp(2j * np.pi * frequency * record.times)
            basis = np.stack([wave.real, wave.imag], axis=1)
            fitted = np.linalg.lstsq(
                window[:, np.newaxis] * basis[half:], window * late, rcond=None
            )[0]
            channel -= basis @ fitted
            notes.append(
                f"a steady tone at {frequency:.4g} Hz, {percentage(b / peak)} of the peak, was "
                "removed"
            )
    return replace(record, signal=signal), tuple(notes)


def _frequency(signal: Floats, sample_rate: float, low: float, high: float) -> float:
    """Return the frequency of the largest tone between two frequencies [Hz]."""
    found = scipy.optimize.minimize_scalar(
        lambda f: -abs(_tone(signal, f / sample_rate)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-4 / signal.size * sample_rate},
    )
    return float(found.x)


def _tone(signal: Floats, cycles: float) -> complex:
    """Return the amplitude of a tone of some cycles per sample, under a Hann window."""
    window = np.hanning(signal.size)
    wave = np.exp(-2j * np.pi * cycles * np.arange(signal.size))
    return complex(2.0 * (window * signal) @ wave / window.sum())


def noise_around(channel: Floats, sample_rate: float, bands: Bands) -> float:
    """Return the deviation of the noise of a sample, from the spectrum around the bands."""
    low, high = 0.5 * bands[0][0], min(1.5 * bands[-1][1], 0.5 * sample_rate)
    half = channel.size // 2  # a disturbance in one half is no noise
    return min(
        noise_level(part, sample_rate, low, high) for part in (channel[:half], channel[half:])
    )


@frozen
class Envelopes:
    """Complex amplitudes of the modes, each in the channel that sees it best.

    Attributes
    ----------
    times : (n,) ndarray
        [s]
    values : (modes, n) ndarray
        [sensor unit]
    noise : (modes,) ndarray
        Deviation of the noise of the amplitudes [sensor unit].
    deviation : float
        Of the filter in time [s].
    """

    times: Floats
    values: Complexes
    noise: Floats
    deviation: float

    @classmethod
    def of(cls, record: Record, bands: Bands, modes: Floats) -> Envelopes:
        """Return the envelopes of modes of frequencies (modes,) [Hz]."""
        # One width for all modes, so that the envelopes have the same times.
        half = 0.5 * min(band[1] - band[0] for band in bands)
        values, noise = [], []
        for frequency in modes:
            band = (frequency - half, frequency + half)
            look = demodulate(record.signal, record.sample_rate, 2.0 * np.pi * frequency, band)
            channel = int((np.abs(look.values) ** 2).sum(axis=1).argmax())
            level = noise_around(record.signal[channel], record.sample_rate, bands)
            values.append(look.values[channel])
            noise.append(envelope_noise(level, look, record.sample_rate))
        return cls(look.times, np.array(values), np.array(noise), look.deviation)

    @property
    def sizes(self) -> Floats:
        """Amplitudes, (modes, n)."""
        return np.abs(self.values)

    @property
    def energy(self) -> Floats:
        """Sum of the squared amplitudes, (n,)."""
        found: Floats = (self.sizes**2).sum(axis=0)
        return found

    def between_jumps(self) -> list[tuple[float, float]]:
        """Return parts without jumps of the amplitudes, as pairs of times [s].

        A jump is the difference between lines through the logarithm of the amplitude on both
        sides.
        """
        end = self.times[-1] + EDGE * self.deviation
        spacing = self.times[1] - self.times[0]
        stride = max(int(0.25 * self.deviation / spacing), 1)
        length = int(EDGE * self.deviation / spacing / stride)  # of a line
        gap = int(2.5 * self.deviation / spacing / stride)  # where the filter smears a jump
        z = self.values[:, ::stride]
        t = self.times[::stride]
        centre = length + gap
        if t.size <= 2 * centre:
            return [(0.0, end)]
        logarithm = np.log(np.maximum(np.abs(z), np.finfo(float).tiny))
        logarithm = logarithm + 1j * np.unwrap(np.angle(z), axis=1)
        x = np.arange(length) - 0.5 * (length - 1)
        distance = gap + 0.5 * (length - 1) + 1.0
        ahead = 1.0 / length + x / (x @ x) * distance  # weights of the line's value at the jump
        windows = np.lib.stride_tricks.sliding_window_view(logarithm, length, axis=1)
        count = t.size - 2 * centre
        sizes = np.lib.stride_tricks.sliding_window_view(np.abs(z), length, axis=1).min(axis=2)
        floor = SEEN * self.noise[:, np.newaxis]  # a mode in the noise counts as at rest
        rests = [sizes[:, k : k + count] <= floor for k in (0, centre + gap)]
        before = np.where(rests[0], 0.0, np.exp(windows[:, :count] @ ahead))
        after = np.exp(windows[:, centre + gap :][:, :count] @ ahead[::-1])
        jumps = np.where(rests[1], 0.0, np.abs(after - before))
        # Curvature acts on both lines alike, its change is of third order: of the change of the
        # slope and the slope itself, between the centres of the lines.
        slopes = 2.0 * distance * (windows @ (x / (x @ x)))
        pair = slopes[:, :count], slopes[:, centre + gap :][:, :count]
        fall = np.maximum(*(np.abs(each.real) for each in pair))
        jumps = np.maximum(jumps - fall * np.abs(pair[1] - pair[0]) * np.abs(before), 0.0)
        loud = jumps > AUDIBLE * self.noise[:, np.newaxis]
        level = np.maximum(np.sqrt((np.abs(before) ** 2).sum(axis=0)), np.finfo(float).tiny)
        seen = (np.where(loud, jumps, 0.0) > JUMP * level).any(axis=0)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]])))
        parts, first = [], 0.0
        for k, after_last in edges.reshape(-1, 2):
            if k == 0:  # curvature of a fast decay; a blow so early leaves a bad fit
                continue
            # A jump is seen while it is between the far ends of the lines.
            reach = min(centre, (after_last - k) // 2)
            parts.append((first, max(t[k + centre + reach] - EDGE * self.deviation, first)))
            first = t[after_last - 1 + centre - reach] + EDGE * self.deviation
        return [*parts, (first, max(end, first))]

    def last_above_noise(self, first: float) -> float:
        """Return the last time [s] at which a mode stands out of the noise."""
        end = float(self.times[-1] + EDGE * self.deviation)
        # Noise exceeds three deviations now and then: half of the last ten windows have to.
        above = (self.sizes > 3.0 * self.noise[:, np.newaxis]).any(axis=0).astype(float)
        width = int(10.0 * self.deviation / (self.times[1] - self.times[0]))
        width = min(max(width, 1), self.times.size)
        share = np.convolve(above, np.full(width, 1.0 / width), mode="same")
        loud = self.times[(share > 0.5) & (self.times >= first)]
        if not loud.size or loud[-1] >= self.times[-1] - 6.0 * self.deviation:
            return end
        return float(loud[-1])
