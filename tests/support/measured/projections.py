"""Decays projected on the carriers of their modes, beside what was predicted of them."""

import numpy as np


def in_bands(made, carriers, times, least):
    """Whether amplitude and phase of each mode are within two deviations of the prediction.

    The measured ones are projections on 20 ms of the carrier, `carriers` [rad/s]. Amplitudes
    below `least` are left out.
    """
    y, t = made.record.signal[0], made.record.times
    for mode, omega in enumerate(carriers):
        for at in times:
            window = np.exp(-0.5 * ((t - at) / 0.015) ** 2)
            z = 2.0 * np.sum(window * y * np.exp(-1j * omega * (t - at))) / np.sum(window)
            if abs(z) < least:
                continue
            size, phase, size_deviation, phase_deviation = (
                np.interp(at, made.times, values[:, mode])
                for values in (
                    made.amplitude,
                    made.phase,
                    made.amplitude_deviation,
                    made.phase_deviation,
                )
            )
            yield abs(abs(z) - size) < 2.0 * size_deviation
            yield abs(np.angle(z * np.exp(-1j * phase))) < 2.0 * phase_deviation
