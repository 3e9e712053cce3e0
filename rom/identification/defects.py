"""Defects of raw records: each function returns what is wrong in one line, or None."""

from __future__ import annotations

import numpy as np
import scipy.optimize

from slipmode.rom.arrays import Floats
from slipmode.rom.identification.first_look import noise_density, spectrum
from slipmode.rom.identification.measurement import Record

# A converter at its limit repeats one value at each peak, in at least two periods. Unclipped
# samples of a sinusoid pile up at its peaks too, on the coarsest converter 2.4 times as many on
# the highest level as on the next: 1 / (sqrt 2 - 1).
CLIPPED_SAMPLES, CLIPPED_RATIO = 4, 4.0
# A sinusoid repeats a value at its peak for a small part of a period; a sensor without contact
# for longer.
DROPOUT_PERIODS = 0.25
HUM_SHARE = (
    2e-3  # amplitude of a steady tone relative to the record's peak from which it is removed
)
HUM_NOISE = 10.0  # and relative to the amplitude of the noise in a bin
STEADY = 0.2  # largest change of its amplitude between the halves of a record


def defect(record: Record, bands: tuple[tuple[float, float], ...]) -> str | None:
    """Return why a record cannot be used, if that shows in its samples."""
    for signal in record.signal:
        if not np.isfinite(signal).all():
            wrong = np.flatnonzero(~np.isfinite(signal))
            first = wrong[0] / record.sample_rate
            return f"{wrong.size} samples are no finite numbers, the first at {first:.4g} s"
        if np.ptp(signal) == 0.0:
            return "the signal is constant"
        for found in (_clipping(signal), _dropout(signal, record.sample_rate, bands)):
            if found is not None:
                return found
    return None


def _clipping(signal: Floats) -> str | None:
    for side in (signal, -signal):
        largest = side.max()
        count = int((side == largest).sum())
        below = side[side < largest].max()
        if count >= CLIPPED_SAMPLES and count >= CLIPPED_RATIO * (side == below).sum():
            level = largest if side is signal else -largest
            return f"it is clipped: {count} samples are exactly {level:.4g}"
    return None


def _dropout(
    signal: Floats, sample_rate: float, bands: tuple[tuple[float, float], ...]
) -> str | None:
    """Return the first run of equal samples amid vibration."""
    highest, lowest = max(band[1] for band in bands), min(band[0] for band in bands)
    least = max(4, int(np.ceil(DROPOUT_PERIODS * sample_rate / highest)) + 1)
    edges = np.flatnonzero(np.diff(signal) != 0.0) + 1
    bounds = np.concatenate([[0], edges, [signal.size]])
    period = int(sample_rate / lowest) + 1
    step = np.abs(np.diff(signal))
    resolution = step[step > 0.0].min()
    for k in np.flatnonzero(np.diff(bounds) >= least):
        first, last = bounds[k], bounds[k + 1]
        before = signal[max(first - period, 0) : first]
        around = max(np.ptp(part) for part in (before, signal[last : last + period]) if part.size)
        if around > max(10.0 * resolution, 1e-2 * np.ptp(signal)) and before.size:
            return (
                f"the signal drops out at {first / sample_rate:.4g} s: "
                f"{last - first} equal samples amid vibration"
            )
    return None


def remove_hum(record: Record, modes: Floats) -> tuple[Record, list[str]]:
    """Return a record without steady tones, and a line for each tone.

    `modes` (modes,) are the frequencies [Hz] of the modes, next to which tones are not searched.
    """
    notes = []
    signal = record.signal.copy()
    half = record.samples // 2
    t = record.times
    for channel in signal:
        peak = np.abs(channel).max()
        for _ in range(4):
            late, early = channel[half:], channel[:half]
            f, size = spectrum(late, record.sample_rate)
            away = np.abs(f[:, np.newaxis] - modes).min(axis=1) > 4.0 * f[1]
            away &= f > 4.0 * f[1]
            noise = np.sqrt(
                np.pi * 1.5 * noise_density(late, record.sample_rate, f[1], f[-1]) / half
            )
            k = int(np.argmax(size * away))
            if size[k] < max(HUM_SHARE * peak, HUM_NOISE * noise):
                break
            frequency = _frequency(late, record.sample_rate, f[k - 1], f[k + 1])
            a, b = (abs(_tone(part, frequency / record.sample_rate)) for part in (early, late))
            if abs(a / b - 1.0) > STEADY:
                break
            wave = np.exp(2j * np.pi * frequency * t)
            basis = np.stack([wave.real, wave.imag], axis=1)
            window = np.hanning(late.size)[:, np.newaxis]
            fitted = np.linalg.lstsq(window * basis[half:], window[:, 0] * late, rcond=None)[0]
            channel -= basis @ fitted
            notes.append(
                f"a steady tone at {frequency:.4g} Hz, {100 * b / peak:.2g} % of the peak, "
                "was removed"
            )
    return Record(record.name, signal, record.sample_rate), notes


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
    """Return the amplitude of a sinusoid of some cycles per sample, by a Hann window."""
    window = np.hanning(signal.size)
    wave = np.exp(-2j * np.pi * cycles * np.arange(signal.size))
    return complex(2.0 * (window * signal) @ wave / window.sum())
