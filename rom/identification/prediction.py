"""Decays predicted from the first milliseconds of a record, and their errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.identification.decay_flow import Decays
from slipmode.rom.identification.fit import LEAST_RECORDS, jackknife_variance
from slipmode.rom.identification.records.measurement import Record
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.short_repr import frozen

# Periods of the lowest mode, and of the beat between the modes, in the window that initial
# amplitudes are taken from. It is 18 ms for modes of 122 and 243 Hz, the window of Cenedese et
# al. (2022), whose data and error norm these are.
PERIODS = 2.25


@frozen
class Prediction:
    """A decay predicted by a law from the first window of a record.

    Attributes
    ----------
    record : Record
        Usable part of the record.
    window : float
        Length of the window that the initial amplitudes were taken from [s].
    signal : (channels, samples) ndarray
        Predicted signals at `record.times` [sensor unit].
    error : float
        Norm of the difference in a window that moves along the record, mean over time, relative to
        the largest norm of the measured signal in the window [-].
    times : (n,) ndarray
        Times of the amplitudes from the start of the record [s].
    amplitude : (n, modes) ndarray
        |a| in the reference channel [sensor unit].
    phase : (n, modes) ndarray
        arg a [rad], continuous.
    amplitude_deviation, phase_deviation : (n, modes) ndarray
        Standard deviations of the two in a further record, by the scatter between records and
        the error of the initial amplitudes [sensor unit], [rad]. Infinite for fewer than three
        records.
    beyond : str
        Modes that start beyond the amplitudes of the identification, in words; empty if none.
    """

    record: Record
    window: float
    signal: Floats
    error: float
    times: Floats
    amplitude: Floats
    phase: Floats
    amplitude_deviation: Floats
    phase_deviation: Floats
    beyond: str


def first_window(omega: Floats) -> float:
    """Return the length of the first window [s] for modes of angular frequencies [rad/s]."""
    return float(PERIODS * 2.0 * np.pi / min([omega[0], *np.abs(np.diff(omega))]))


def initial_amplitudes(
    record: Record, law: SlowLaw, shapes: Complexes, window: float
) -> tuple[Complexes, Floats]:
    """Return complex amplitudes at the start of a record, and their standard deviation, (modes,).

    They are fitted to a window in which the rates of the law hardly change.
    """
    count = min(round(window * record.sample_rate), record.samples)
    t = record.times[:count]
    measured = record.signal[:, :count].reshape(-1)
    a = np.zeros(law.form.modes, complex)
    for _ in range(4):  # with the rates at these amplitudes: each pass gains three digits
        rates = law.logarithmic_rates(a)
        wave = shapes[:, np.newaxis] * np.exp(np.multiply.outer(t, rates))
        wave = wave.reshape(-1, len(a))
        basis = np.concatenate([wave.real, -wave.imag], axis=1)
        found, *_ = np.linalg.lstsq(basis, measured, rcond=None)
        a = found[: len(a)] + 1j * found[len(a) :]
    rest = measured - basis @ found
    variance = np.diag(np.linalg.pinv(basis.T @ basis)) * (rest @ rest)
    variance /= max(len(rest) - len(found), 1)
    # The deviation of the amplitude, and of the phase times the amplitude.
    return a, np.sqrt(variance.reshape(2, -1).mean(axis=0))


def normalised_error(measured: Floats, predicted: Floats, samples: int) -> float:
    """Return the error of predicted signals (channels, n), see `Prediction.error`."""

    def norms(signal: Floats) -> Floats:
        total = np.concatenate([[0.0], np.cumsum((signal**2).sum(axis=0))])
        found: Floats = np.sqrt(np.maximum(total[samples:] - total[:-samples], 0.0))
        return found

    if not np.isfinite(predicted).all():
        return np.inf
    return float(norms(predicted - measured).mean() / norms(measured).max())


def predict(
    decays: Decays, law: SlowLaw, left_out: Sequence[SlowLaw], largest: Floats
) -> list[Prediction]:
    """Return predictions of records.

    `left_out` are the laws of the jackknife, `largest` (modes,) the largest amplitudes of the
    records that the law was fitted to.
    """
    window = first_window(decays.carrier)
    known = [initial_amplitudes(r, law, decays.shapes, window) for r in decays.records]
    start = np.array([a for a, _ in known]).T
    smallest = np.finfo(float).tiny  # where a mode is at rest
    signals = decays.signals(law, start)
    values = np.stack([each.values for each in (law, *left_out)], axis=1)
    columns = np.tile(start[:, np.newaxis], (1, values.shape[1], 1))
    z = decays.nodes(values, columns)[:, 0]  # (nodes, modes, laws, records)
    with np.errstate(over="ignore", invalid="ignore"):  # laws that grow without limit
        amplitude = np.maximum(np.abs(z), smallest)
        phase = np.unwrap(np.angle(z), axis=0)
    n = len(left_out)
    times = np.asarray(np.arange(decays.steps + 1) * decays.step, float)
    made = []
    for i, record in enumerate(decays.records):
        inside = times <= record.duration
        initial = (known[i][1] / np.maximum(np.abs(start[:, i]), smallest)) ** 2
        deviations = []
        for of_laws in (np.log(amplitude[inside, :, :, i]), phase[inside, :, :, i]):
            scatter = np.full(of_laws.shape[:2], np.inf)
            if n >= LEAST_RECORDS:
                # The variance of the mean of n records times n is the variance of a record.
                with np.errstate(invalid="ignore"):
                    scatter = (1.0 + n) * jackknife_variance(of_laws[:, :, 1:], axis=2)
            deviations.append(np.sqrt(scatter + initial))
        size = amplitude[inside, :, 0, i]
        beyond = [
            f"mode {'AB'[j]} starts at {abs(start[j, i]) / most:.3g} times the largest amplitude"
            for j, most in enumerate(largest)
            if abs(start[j, i]) - 3.0 * known[i][1][j] > most  # certainly
        ]
        made.append(
            Prediction(
                record,
                window,
                signals[i],
                normalised_error(record.signal, signals[i], round(window * record.sample_rate)),
                times[inside],
                size,
                phase[inside, :, 0, i] + np.multiply.outer(times[inside], decays.carrier),
                size * deviations[0],
                deviations[1],
                " and ".join(beyond),
            )
        )
    return made
