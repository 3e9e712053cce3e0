"""Complex amplitudes of the modes at the start of a record, from its first milliseconds."""

from __future__ import annotations

import numpy as np

from slipmode.rom.common import Complexes, Floats
from slipmode.rom.identification.records.measurement import Record
from slipmode.rom.identification.slow_laws import SlowLaw

# Periods of the lowest mode, and of the beat between the modes, in the window that initial
# amplitudes are taken from. It is 18 ms for modes of 122 and 243 Hz, the window of Cenedese et
# al. (2022), whose data and error norm these are.
PERIODS = 2.25


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
    a = law.reference.astype(complex)
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
