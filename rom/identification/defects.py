"""Defects of the samples of a record: those that exclude it, and those that are removed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.identification.first_look import noise_in_spectrum, noise_level, spectrum
from slipmode.rom.identification.measurement import Bands, Record

# A converter at its limit repeats one value at each peak, in at least two periods. Unclipped
# samples of a sinusoid pile up at its peaks too: on the highest level of a converter there are
# at most 2.4 = 1 / (sqrt 2 - 1) times as many as on the next.
CLIPPED_SAMPLES, CLIPPED_RATIO = 4, 4.0
# Periods that a sensor without contact keeps its value. A sinusoid of amplitude A keeps it
# within the resolution q for 2 sqrt(2 q / A) / omega at its peak, a sum of two for up to twice so.
DROPOUT_PERIODS = 0.25
LEAST = 0.01  # offset or drift relative to the peak that is removed
TONE = 2e-3  # amplitude of a steady tone relative to the peak from which it is removed
TONE_NOISE = 10.0  # and relative to the noise in its bin
STEADY = 0.2  # largest relative change of its amplitude between the halves of a record
MOST_TONES = 4


def without_padding(record: Record) -> tuple[Record, tuple[str, ...]]:
    """Return a record without NaN after its end, by which arrays of several records are filled."""
    known = np.flatnonzero(np.isfinite(record.signal).any(axis=0))
    samples = int(known[-1]) + 1 if known.size else 0
    if samples in (0, record.samples):
        return record, ()
    end = samples / record.sample_rate
    note = f"its last {record.samples - samples} samples, from {end:.4g} s on, are NaN"
    return replace(record, signal=record.signal[:, :samples]), (note,)


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
                f"the signal drops out at {first / sample_rate:.4g} s: {last - first} equal "
                "samples amid vibration"
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
        # A decay itself leaves up to 4 / (omega T) of its peak in a line.
        if share > max(LEAST, 10.0 / (2.0 * np.pi * modes.min() * record.duration)):
            channel -= line
            notes = (f"an offset or drift of {100 * share:.2g} % of the peak was removed",)
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
        for _ in range(MOST_TONES):
            early, late = channel[:half], channel[half:]
            f, size = spectrum(late, record.sample_rate)
            away = np.abs(f[:, np.newaxis] - modes).min(axis=1) > 4.0 * f[1]
            k = int(np.argmax(size * (away & (f > 4.0 * f[1]) & (f < f[-1]))))
            noise = noise_level(late, record.sample_rate, f[1], f[-1]) * noise_in_spectrum(
                late.size
            )
            if size[k] < max(TONE * peak, TONE_NOISE * noise):
                break
            frequency = _frequency(late, record.sample_rate, f[k - 1], f[k + 1])
            a, b = (abs(_tone(part, frequency / record.sample_rate)) for part in (early, late))
            if abs(a / b - 1.0) > STEADY:
                break
            wave = np.exp(2j * np.pi * frequency * record.times)
            basis = np.stack([wave.real, wave.imag], axis=1)
            fitted = np.linalg.lstsq(
                window[:, np.newaxis] * basis[half:], window * late, rcond=None
            )[0]
            channel -= basis @ fitted
            notes.append(
                f"a steady tone at {frequency:.4g} Hz, {100 * b / peak:.2g} % of the peak, was "
                "removed"
            )
    return replace(record, signal=signal), tuple(notes)


def _frequency(signal: Floats, sample_rate: float, low: float, high: float) -> float:
    """Return the frequency of the largest tone between two frequencies [Hz]."""
    from scipy.optimize import minimize_scalar  # takes a while to import

    found = minimize_scalar(
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
