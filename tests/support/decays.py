"""Measured decays of known laws, in closed form and by general integration."""

import numpy as np
from scipy.integrate import solve_ivp
from slipmode import rom

BANDS = [(100.0, 140.0), (225.0, 260.0)]
RATE = 2000.0
# delta_0 [1/s], omega_0 [rad/s], g [1/s], h [rad/s], p of each mode, at the amplitude 1.
TRUE = np.array([[0.4, 770.0, 0.6, 2.0, 1.2], [2.5, 1530.0, 1.2, 4.0, 1.4]])


def power_law_decay(t, a0, delta_0, omega_0, g, h, p):
    """The signal Re a of a' = (-delta_0 - g |a|^p + i omega_0 - i h |a|^p) a, in closed form."""
    grown = 1.0 + g / delta_0 * np.abs(a0) ** p * -np.expm1(-p * delta_0 * t)
    size = np.abs(a0) * np.exp(-delta_0 * t) * grown ** (-1.0 / p)
    phase = np.angle(a0) + omega_0 * t - h / (p * g) * np.log(grown)
    return size * np.cos(phase)


def drawn_amplitudes(rng, records, modes=2):
    """Complex initial amplitudes, (records, modes)."""
    size = rng.uniform(0.4, 1.0, (records, modes))
    return size * np.exp(2j * np.pi * rng.random((records, modes)))


def power_law_signals(rng, records=6, modes=TRUE, duration=2.5, noise=1e-3, scatter=0.0):
    """Records of modes without effects on each other; `scatter` of rates between records."""
    t = np.arange(round(duration * RATE)) / RATE
    signals = []
    for start in drawn_amplitudes(rng, records, len(modes)):
        y = noise * rng.standard_normal(t.size)
        for a0, mode in zip(start, modes, strict=True):
            own = np.array(mode)
            own[[0, 2, 3]] *= 1.0 + scatter * rng.standard_normal(3)
            y += power_law_decay(t, a0, *own)
        signals.append(y)
    return signals


def coupled_signal(start, law, duration=2.5):
    """A record of two modes with cross effects and quadratic coupling, integrated by scipy.

    `law` has delta_0, omega_0, g, h, p, kappa of each mode, and q_1, q_2.
    """
    own_A, own_B, q_1, q_2 = law

    def rate(own, size, other):
        delta_0, omega_0, g, h, p, kappa = own
        power = (abs(size) ** 2 + kappa * abs(other) ** 2) ** (p / 2)
        return -delta_0 - g * power + 1j * (omega_0 - h * power)

    def slope(_, z):
        a, b = z
        return [
            rate(own_A, a, b) * a + q_1 * np.conj(a) * b,
            rate(own_B, b, a) * b + q_2 * a * a,
        ]

    t = np.arange(round(duration * RATE)) / RATE
    found = solve_ivp(
        slope, (0, t[-1]), np.array(start, complex), "DOP853", t, rtol=1e-9, atol=1e-10
    )
    return found.y.sum(axis=0).real


def measurement(signals, rate=RATE, unit="m/s"):
    """Records of one channel; of more where signals are (channels, samples)."""
    records = [
        rom.Record(f"hit{k}", np.atleast_2d(signal), rate) for k, signal in enumerate(signals, 1)
    ]
    channels = tuple(f"channel {k}" for k in range(len(records[0].signal)))
    return rom.Measurement(records, "velocity", unit, channels)
