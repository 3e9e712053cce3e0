"""Models of given rates, saved for scenes, and their steady states written out."""

import numpy as np
from scipy.optimize import root

from slipmode import rom

RANGE = 2e-3
REST, NATURAL = 1.5, 2.0 * np.pi * 120.0  # damping [1/s] and frequency [rad/s] at rest
GROWTH, DROP = 2.0, 7.5  # change of either at the end of the range
ONE_SHAPE = np.array([[1.2], [0.5]])
TWO_SHAPES = np.array([[1.2, 0.7], [0.4, -1.1], [0.9, 0.2]])


def one_rate(amplitudes):
    share = amplitudes / RANGE
    return REST + GROWTH * share, NATURAL - DROP * share


def two_rates(amplitudes):
    a, b = np.asarray(amplitudes).T / RANGE
    s_A, s_B = np.sqrt(a**2 + 0.2 * b**2), np.sqrt(b**2 + 0.8 * a**2)
    damping = np.stack((1.5 + 2.0 * s_A, 2.2 + 3.0 * s_B), axis=-1)
    frequency = np.stack((122.0 - s_A, 243.0 - 1.4 * s_B), axis=-1)
    return damping, 2.0 * np.pi * frequency


def one_mode():
    return rom.model_of_rates(one_rate, (RANGE,), mode_shapes=ONE_SHAPE)


def two_modes():
    return rom.model_of_rates(two_rates, (RANGE, RANGE), mode_shapes=TWO_SHAPES)


def steady_sizes(rates, modal_force, frequency):
    """|a_j| with |D_j - Q_j| |a_j| = F_j / 2, Q_j = (s_j - s_0j) (s_j - conj(s_0j))."""
    modal_force, Omega = np.array(modal_force), np.array(frequency)

    def s(size):
        damping, omega = (each[0] for each in rates(np.abs(size)[np.newaxis]))
        return -damping + 1j * omega

    rest = s(np.zeros(len(Omega)))

    def deficit(share):
        size = RANGE * share
        Q = (s(size) - rest) * (s(size) - rest.conj())
        D = np.abs(rest) ** 2 - Omega**2 - 2j * rest.real * Omega
        return (np.abs(D - Q) * size / modal_force - 0.5) * 2.0

    found = root(deficit, np.full(len(Omega), 0.1), tol=1e-12)
    assert found.success
    return RANGE * np.abs(found.x)
