"""Amplitudes of signals that are known."""

import numpy as np
import pytest

from slipmode.runner.transients.demodulation import (
    amplitudes,
    carrier_signal,
    slow_parts,
    window_length,
)

OMEGA = np.array([1.0, 1.7])
GROWTH = np.array([-0.01 + 0.005j, -0.02])
START = np.array([1.0 - 0.5j, 0.4])


def signal(time):
    """Decaying carriers, each with a third harmonic and some of the other carrier."""
    theta = np.outer(time, OMEGA)
    a = START * np.exp(np.outer(time, GROWTH))
    turning = a * np.exp(1j * theta)
    third = 0.05 * a * np.exp(3j * theta)
    other = 0.1 * turning[:, ::-1]
    return 2 * np.real(turning + third + other), a, theta


@pytest.mark.parametrize(("at", "bound"), [((40.0, 60.0, 80.0), 2e-3), ((0.0, 120.0), 6e-2)])
def test_amplitude_and_rate(at, bound):
    """Inside; and at the ends, where a window has one side only."""
    h = 0.05
    time = np.arange(0.0, 120.0 + h / 2, h)
    q, _, theta = signal(time)
    velocity = (signal(time + 1e-5)[0] - signal(time - 1e-5)[0]) / 2e-5
    z = carrier_signal(q, velocity, theta, OMEGA)
    points = np.array(at)
    a, rate = amplitudes(
        *slow_parts(time, z, theta, points, window_length(OMEGA[np.newaxis])), OMEGA
    )
    exact = signal(points)[1]
    np.testing.assert_allclose(np.abs(a - exact) / np.abs(exact), 0.0, atol=bound)
    np.testing.assert_allclose(np.abs(rate - GROWTH * exact) / np.abs(exact), 0.0, atol=bound)
