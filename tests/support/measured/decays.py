"""Measured decays of known laws, in closed form or integrated by scipy."""

import numpy as np
from scipy.integrate import solve_ivp

from slipmode import rom

BANDS = [(100.0, 140.0), (225.0, 260.0)]
RATE = 2000.0
# delta_0 [1/s], omega_0 [rad/s], g [1/s], h [rad/s], p of each mode, at the amplitude 1.
TRUE = np.array([[0.4, 770.0, 0.6, 2.0, 1.2], [2.5, 1530.0, 1.2, 4.0, 1.4]])
NAMES = ("delta_0", "omega_0", "g", "h", "p")
# The same, and kappa, where A affects B.
OWN_A, OWN_B = (*TRUE[0], 0.0), (*TRUE[1], 0.8)


def power_law_amplitude(t, a0, delta_0, omega_0, g, h, p):
    """a(t) of a' = (-delta_0 - g |a|^p + i omega_0 - i h |a|^p) a, in closed form."""
    grown = 1.0 + g / delta_0 * np.abs(a0) ** p * -np.expm1(-p * delta_0 * t)
    phase = omega_0 * t - h / (p * g) * np.log(grown)
    return a0 * np.exp(-delta_0 * t) * grown ** (-1.0 / p) * np.exp(1j * phase)


def amplitudes(rng, records, modes=2):
    """Initial amplitudes of 0.4 to 1, (records, modes)."""
    size = rng.uniform(0.4, 1.0, (records, modes))
    return size * np.exp(2j * np.pi * rng.random((records, modes)))


def times(duration=2.5, rate=RATE):
    return np.arange(round(duration * rate)) / rate


def parameters(found, modes=TRUE):
    """True parameters for the reference amplitudes of an identification."""
    values = {}
    for mode, own, reference in zip("AB", modes, found.law.reference, strict=False):
        size = reference ** own[4]
        scaled = (own[0], own[1], own[2] * size, own[3] * size, own[4])
        values |= {f"{name}_{mode}": v for name, v in zip(NAMES, scaled, strict=True)}
    return values


def decay(rng, modes=TRUE, t=None, noise=1e-3, start=None):
    """A record of modes that do not affect each other."""
    t = times() if t is None else t
    start = amplitudes(rng, 1, len(modes))[0] if start is None else start
    y = noise * rng.standard_normal(t.size)
    for a0, mode in zip(start, modes, strict=True):
        y += power_law_amplitude(t, a0, *mode).real
    return y


def decays(seed, records=6, **options):
    rng = np.random.default_rng(seed)
    return [decay(rng, **options) for _ in range(records)]


def coupled_amplitudes(t, start, own_A, own_B, q_1=0.0, q_2=0.0):
    """Amplitudes of two modes with cross effects and quadratic coupling, (2, n), by scipy.

    `own` are delta_0, omega_0, g, h, p, kappa.
    """

    def rate(own, size, other):
        delta_0, _, g, h, p, kappa = own
        power = (abs(size) ** 2 + kappa * abs(other) ** 2) ** (p / 2)
        return -delta_0 - (g + 1j * h) * power

    omega = np.array([own_A[1], own_B[1]])

    def slope(time, z):  # in the frame of omega_0
        a, b = z
        beat = np.exp(1j * (omega[1] - 2.0 * omega[0]) * time)
        return [
            rate(own_A, a, b) * a + q_1 * beat * np.conj(a) * b,
            rate(own_B, b, a) * b + q_2 / beat * a * a,
        ]

    z0 = np.array(start, complex)
    z = solve_ivp(slope, (0, t[-1]), z0, "DOP853", t, rtol=1e-10, atol=1e-11).y
    return z * np.exp(1j * np.multiply.outer(omega, t))


def measurement(signals, rate=RATE, unit="m/s"):
    """Records of one channel; of more where signals are (channels, samples)."""
    records = [
        rom.Record(f"hit{k}", np.atleast_2d(signal), rate) for k, signal in enumerate(signals, 1)
    ]
    channels = tuple(f"channel {k}" for k in range(len(records[0].signal)))
    return rom.Measurement(records, "velocity", unit, channels)
