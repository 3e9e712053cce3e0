"""Steady sine tests of one oscillator, by formulas and solvers that slipmode does not use.

    m x'' + (c + c3 x^2) x' + k x + k3 x^3 = F cos(Omega t)

Harmonic balance gives damping c + c3 X^2 / 4 and stiffness k + 3/4 k3 X^2 at the displacement
amplitude X: a law with the exponent 2.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from slipmode import rom


@dataclass(frozen=True)
class Oscillator:
    """Parameters in SI units."""

    m: float = 1.8
    frequency: float = 80.0  # at rest [Hz]
    zeta: float = 0.004  # at rest
    c3: float = 0.0
    k3: float = 0.0

    @property
    def omega(self):
        return 2.0 * np.pi * self.frequency

    def stiffness(self, omega, x):
        """Complex F / x at displacement amplitudes."""
        c = 2.0 * self.zeta * self.m * self.omega + 0.25 * self.c3 * x**2
        k = self.m * self.omega**2 + 0.75 * self.k3 * x**2
        return k - self.m * omega**2 + 1j * omega * c

    def marched(self, frequency, force, periods=250):
        """Complex displacement amplitudes (points,) after a transient from rest, by DOP853."""
        omega = 2.0 * np.pi * frequency
        c = 2.0 * self.zeta * self.m * self.omega

        def rates(tau, y):  # tau = Omega t; v = dx / dtau
            x, v = y.reshape(2, -1)
            speed = omega * v
            forces = force * np.cos(tau) - (c + self.c3 * x**2) * speed
            forces -= self.m * self.omega**2 * x + self.k3 * x**3
            return np.concatenate([v, forces / (self.m * omega**2)])

        end = 2.0 * np.pi * periods
        times = end + 2.0 * np.pi * np.arange(32) / 32
        found = solve_ivp(
            rates,
            (0.0, times[-1]),
            np.zeros(2 * frequency.size),
            method="DOP853",
            t_eval=times,
            rtol=1e-8,
            atol=1e-12,
        )
        return 2.0 * np.mean(found.y[: frequency.size] * np.exp(-1j * times), axis=1)


def response_controlled(oscillator, amplitude, frequency, phase_error=0.0, rng=None, noise=0.0):
    """A test at a constant acceleration amplitude, with the force that this needs."""
    omega = 2.0 * np.pi * frequency
    x = amplitude / omega**2
    force = oscillator.stiffness(omega, x) * -x
    response = np.full(frequency.size, amplitude * np.exp(-1j * phase_error))
    if rng is not None:
        response = response * (
            1.0 + noise * (rng.standard_normal((2, frequency.size)).T @ [1, 1j])
        )
    return rom.SineTest(f"a_{amplitude:g}", frequency, force, response)


def response_controlled_set(rng, amplitudes, scatter=0.0, noise=0.0):
    """Tests at several amplitudes; frequency, mass and damping scatter between them."""
    tests = []
    for a in amplitudes:
        change = 1.0 + scatter * rng.standard_normal(2)
        own = Oscillator(
            m=1.8 * change[0],
            frequency=80.0 + 5.0 * scatter * rng.standard_normal(),
            zeta=0.002 * change[1],
            c3=1.5e8 * change[1] * change[0],
        )
        frequency = np.linspace(79.0, 81.0, 41)
        phase = 0.1 + 0.02 * rng.standard_normal()
        tests.append(response_controlled(own, a, frequency, phase, rng, noise))
    return rom.SineTests(tests, "m/s^2")
