"""Sine sweeps and stepped sines as time signals of force and response.

The controlled signal, force or response, has a constant amplitude. Its phase gives the drive
frequency Omega. In Hann windows w, both signals x have the complex amplitude

    2 sum w x e^{-i Omega (t - t_k)} / sum w

at the centre t_k of the window.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Floats, as_floats, frozen, in_one_line, percentage
from slipmode.rom.identification.records.measurement import SAMPLES
from slipmode.rom.identification.sine.responses import SineTest, checked

# Periods of the mean drive frequency in a window. At a fifth of that frequency three are left, of
# which Hann windows suppress harmonics and offsets to 1 %.
PERIODS = 16
LEAST_WINDOWS = 4  # in a test, of which every other one has samples of its own


def demodulate_sine_test(name: str, force: Any, response: Any, sample_rate: float) -> SineTest:
    """Return the force and response amplitudes of a sine sweep or stepped sine test.

    Parameters
    ----------
    name : str
        Name of the test.
    force : (samples,) array_like
        Force signal [N].
    response : (samples,) array_like
        Response signal at the times of the force signal [sensor unit].
    sample_rate : float
        Sampling rate [Hz].

    Returns
    -------
    SineTest
        A sweep has two points per window of 16 periods. A stepped sine has one point at the end of
        each step. Samples before and after the test, where the force is small, are omitted.

    Raises
    ------
    SlipmodeError
        If the signals differ in length, are not finite, zero or too short, or are no sine test.
    """
    signals = np.stack(_checked_signals(name, force, response))
    if not (np.ndim(sample_rate) == 0 and 0.0 < sample_rate < np.inf):
        raise SlipmodeError(f"sample_rate = {in_one_line(sample_rate)}: must be > 0 [Hz]")
    signals -= signals.mean(axis=1, keepdims=True)
    analytic = _analytic(signals)
    used = _driven(np.abs(analytic[0]))
    controlled = int(np.argmin([_variation(np.abs(each[used])) for each in analytic]))
    windows = Windows.of(signals[:, used], analytic[controlled, used], sample_rate)
    if windows is None:
        raise SlipmodeError(
            f"tests: {name} is too short. It is driven for {used.stop - used.start} samples and "
            f"must be driven for {LEAST_WINDOWS // 2} windows of {PERIODS} periods"
        )
    highest, share = float(windows.frequency.max()), float(windows.share[controlled])
    if share < 0.5:
        raise SlipmodeError(
            f"tests: {name} is not a sine test. {percentage(share)} of the power of the "
            f"{('force', 'response')[controlled]} is at one frequency, at least 50 % is needed"
        )
    if highest * SAMPLES > sample_rate:
        raise SlipmodeError(
            f"tests: {name} has drive frequencies up to {highest:.4g} Hz, which needs a sampling "
            f"rate of at least {SAMPLES * highest:.4g} Hz"
        )
    return checked(windows.test(name, controlled))


@frozen
class Windows:
    """Amplitudes in windows, each half a window after the one before it.

    Attributes
    ----------
    frequency : (windows,) ndarray
        Drive frequency [Hz].
    amplitude : (2, windows) ndarray
        Complex amplitudes of force and response.
    share : (2,) ndarray
        Share of the power of force and response that is at the drive frequency.
    hop : float
        Time from a window to the next [s].
    """

    frequency: Floats
    amplitude: Complexes
    share: Floats
    hop: float

    @classmethod
    def of(cls, signals: Floats, analytic: Complexes, sample_rate: float) -> Windows | None:
        """Return the windows of signals (2, samples), None for too few.

        `analytic` (samples,) is the analytic signal of the controlled one.
        """
        phase = np.unwrap(np.angle(analytic))
        turns = (phase[-1] - phase[0]) / (2.0 * np.pi)
        half = max(int(0.5 * PERIODS / max(turns, 1.0) * phase.size), 1)
        centres = np.arange(half, phase.size - half, half)
        if centres.size < LEAST_WINDOWS - 1:
            return None
        t = np.arange(-half, half + 1) / sample_rate
        weight = np.hanning(t.size + 2)[1:-1]
        weight /= weight.sum()
        slope = weight * t / (weight @ t**2)
        omega, power = np.empty(centres.size), np.zeros(2)
        amplitude = np.empty((2, centres.size), complex)
        for k, centre in enumerate(centres):
            inside = slice(centre - half, centre + half + 1)
            omega[k] = slope @ phase[inside]
            amplitude[:, k] = 2.0 * signals[:, inside] @ (weight * np.exp(-1j * omega[k] * t))
            power += signals[:, inside] ** 2 @ weight
        share = 0.5 * (np.abs(amplitude) ** 2).sum(axis=1) / power
        return cls(omega / (2.0 * np.pi), amplitude, share, half / sample_rate)

    def test(self, name: str, controlled: int) -> SineTest:
        """Return the points of the test; of a stepped sine, a settled one of each step."""
        turn = self.amplitude[controlled] / np.abs(self.amplitude[controlled])
        steady = self.amplitude[1] / turn  # relative to the drive
        steps = _steps(self.frequency)
        if steps is None:
            change = np.gradient(steady, self.hop) / steady
            at = np.arange(self.frequency.size)
        else:
            # Windows at both ends of a step contain samples of other steps. The change over a
            # third of the step is larger than at its end, but has little noise.
            at = np.array([step[-2] for step in steps])
            before = np.array([step[-2] - max(step.size // 3, 1) for step in steps])
            change = (1.0 - steady[before] / steady[at]) / (self.hop * (at - before))
        force, response = self.amplitude[:, at]
        return SineTest(
            name, self.frequency[at], force, response, np.abs(change), steps is not None
        )


def _checked_signals(name: str, force: Any, response: Any) -> tuple[Floats, Floats]:
    given = {"force": force, "response": response}
    arrays = [as_floats(f"{name}: {key}", each) for key, each in given.items()]
    if arrays[0].ndim != 1 or arrays[0].shape != arrays[1].shape or not arrays[0].size:
        raise SlipmodeError(
            f"tests: {name} must have force and response of one length, got shapes "
            f"{', '.join(str(each.shape) for each in arrays)}"
        )
    for key, each in zip(given, arrays, strict=True):
        if not (np.isfinite(each).all() and np.ptp(each) > 0.0):
            raise SlipmodeError(f"tests: {key} of {name} must be finite and not constant")
    return arrays[0], arrays[1]


def _analytic(signals: Floats) -> Complexes:
    """Return the analytic signals of (2, samples)."""
    samples = signals.shape[1]
    spectrum = scipy.fft.fft(signals)
    spectrum[:, 1 : (samples + 1) // 2] *= 2.0
    spectrum[:, samples // 2 + 1 :] = 0.0
    return np.asarray(scipy.fft.ifft(spectrum))


def _variation(envelope: Floats) -> float:
    low, high = np.quantile(envelope, [0.1, 0.9])
    return float(high / low)


def _driven(force: Floats) -> slice:
    """Return the samples from the first to the last in which the force is not small."""
    loud = np.flatnonzero(force > 0.25 * np.quantile(force, 0.9))
    return slice(int(loud[0]), int(loud[-1]) + 1)


def _steps(frequency: Floats) -> list[NDArray[np.intp]] | None:
    """Return the windows of each step of a stepped sine, None for a sweep."""
    change, span = np.diff(frequency), float(np.ptp(frequency))
    if span == 0.0:
        return None
    # Within steps the frequency has noise alone. In sweeps most windows change by about the mean.
    if abs(np.median(change)) * change.size > 0.2 * span:
        return None
    size = np.abs(change)
    typical = (size**2).sum() / size.sum()  # of the windows that contain two steps
    jumps = size > max(8.0 * float(np.median(size)), 0.05 * typical)
    if size[jumps].sum() < 0.5 * span:  # up and down again
        return None
    steps = np.split(np.arange(frequency.size), np.flatnonzero(jumps) + 1)
    return [step for step in steps if step.size >= 3] or None
