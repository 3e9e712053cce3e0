"""Decays predicted from the first milliseconds of a record, and their errors."""

from __future__ import annotations

import numpy as np

from slipmode.rom.common import Floats, frozen
from slipmode.rom.identification.decay_flow import Decays
from slipmode.rom.identification.initial_amplitudes import first_window, initial_amplitudes
from slipmode.rom.identification.records.measurement import Record
from slipmode.rom.identification.uncertainty import Uncertainty


@frozen
class Prediction:
    """Hold a decay that a law predicts from the first window of a record.

    Attributes
    ----------
    record : Record
        Usable part of the record.
    window : float
        Length of the window from which the initial amplitudes are taken [s].
    signal : (channels, samples) ndarray
        Predicted signals at `record.times` [sensor unit].
    error : float
        Normalised error [-]. It is the norm of the difference from the measured signal in a
        moving window, as a mean over time. It is relative to the largest norm of the measured
        signal in a window.
    times : (n,) ndarray
        Times of the amplitudes after the start of the record [s].
    amplitude : (n, modes) ndarray
        Amplitudes |a| in the reference channel [sensor unit].
    phase : (n, modes) ndarray
        Phases arg a [rad], continuous.
    amplitude_deviation, phase_deviation : (n, modes) ndarray
        Standard deviations of amplitude [sensor unit] and phase [rad] in a further record. They
        include the scatter between records, laws that predict equally well, the misfit of the law
        and the error of the initial amplitudes. Infinite with fewer than three records.
    beyond : str
        Modes that start above the amplitudes of the identification, in words; empty if none.
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


def normalised_error(measured: Floats, predicted: Floats, samples: int) -> float:
    """Return the error of predicted signals (channels, n), see `Prediction.error`."""

    def norms(signal: Floats) -> Floats:
        total = np.concatenate([[0.0], np.cumsum((signal**2).sum(axis=0))])
        found: Floats = np.sqrt(np.maximum(total[samples:] - total[:-samples], 0.0))
        return found

    if not np.isfinite(predicted).all():
        return np.inf
    return float(norms(predicted - measured).mean() / norms(measured).max())


def predict(decays: Decays, uncertainty: Uncertainty, largest: Floats) -> list[Prediction]:
    """Return predictions of records by the identified law.

    `largest` (modes,) are the largest amplitudes of the records that the law was fitted to.
    """
    window, law = first_window(decays.carrier), uncertainty.laws[0][0]
    known = [initial_amplitudes(r, law, decays.shapes, window) for r in decays.records]
    start = np.array([a for a, _ in known]).T
    smallest = np.finfo(float).tiny  # where a mode is at rest
    signals = decays.signals(law, start)
    laws = [each for of_form in uncertainty.laws for each in of_form]
    values = np.stack([each.values for each in laws], axis=1)
    columns = np.tile(start[:, np.newaxis], (1, values.shape[1], 1))
    z = decays.nodes(values, columns)[:, 0]  # (nodes, modes, laws, records)
    with np.errstate(over="ignore", invalid="ignore"):  # laws that grow without limit
        amplitude = np.maximum(np.abs(z), smallest)
        phase = np.unwrap(np.angle(z), axis=0)
    times = np.asarray(np.arange(decays.steps + 1) * decays.step, float)
    made = []
    for i, record in enumerate(decays.records):
        inside = times <= record.duration
        initial = (known[i][1] / np.maximum(np.abs(start[:, i]), smallest)) ** 2
        by_laws = uncertainty.of_record(
            np.stack([np.log(amplitude[inside, ..., i]), phase[inside, ..., i]])
        )
        by_misfit = uncertainty.after(times[inside], record.duration)
        deviation = np.sqrt(by_laws + by_misfit + initial)
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
                size * deviation[0],
                deviation[1],
                " and ".join(beyond),
            )
        )
    return made
