"""Sine sweeps and stepped sines of a mass with a joint, as time signals by the oracle."""

import numpy as np
from oracles.closed_forms import jenkins_first_harmonic
from oracles.system import Sliders, System
from oracles.time_integration import integrate

RATE = 640.0  # samples per second
MASS, FREQUENCY, ZETA = 1.8, 80.0, 0.003  # [kg], with a stuck joint [Hz]
OMEGA = 2.0 * np.pi * FREQUENCY
SLIP = 2e-4  # displacement at macro-slip [m]


def joint(share=0.05, sliders=30, beta=0.2):
    """Return sliders of Iwan's uniform density, with a share of the stiffness of the mass."""
    k = share * MASS * OMEGA**2 / (1.0 + beta)
    reach = SLIP * np.append((np.arange(sliders) + 0.5) / sliders, 1.0)
    each = np.append(np.full(sliders, k / sliders), beta * k)
    return Sliders(tuple(each * reach), tuple(each))


def stiffness(omega, x, law):
    """Return the complex F / x at a displacement amplitude."""
    N = sum(
        jenkins_first_harmonic(x, limit, k)
        for limit, k in zip(law.limits, law.stiffnesses, strict=True)
    )
    return MASS * (OMEGA**2 - omega**2 + 2j * ZETA * OMEGA * omega) - law.stuck + N / x


def damping(x, law):
    """Return the damping ratio of steady vibration at a displacement amplitude."""
    natural = np.sqrt(stiffness(0.0, x, law).real / MASS)
    return stiffness(natural, x, law).imag / (2.0 * MASS * natural**2)


def driven(start, frequency, rate, force, duration, law=None):
    """Return force and velocity (samples,) of segments with complex forces [N], from rest.

    Frequencies [Hz] are those at the start of each segment, and change by `rate` [Hz/s]. The
    phase is continuous.
    """
    law = joint() if law is None else law
    start, frequency, force = (np.atleast_1d(each) for each in (start, frequency, force))
    length = np.diff(start)
    before = np.append(0.0, np.cumsum((frequency[:-1] + 0.5 * rate * length) * length))

    def signal(t):
        k = np.searchsorted(start, t, "right") - 1
        tau = t - start[k]
        turns = before[k] + (frequency[k] + 0.5 * rate * tau) * tau
        return (force[k] * np.exp(2j * np.pi * turns)).real[:, np.newaxis]

    spring = [[MASS * OMEGA**2 - law.stuck]]
    damper = [[2.0 * ZETA * MASS * OMEGA]]
    one = np.ones((1, 1))
    system = System(MASS * one, np.array(damper), np.array(spring), one, [law])
    samples = round(duration * RATE)
    motion = integrate(system, one, signal, samples / RATE, 8 * samples, every=8)
    return signal(motion.t)[:, 0], motion.v[:, 0]


def sweep(first, last, rate, amplitude, law=None):
    """Return force and velocity of a sweep between frequencies [Hz] at a rate [Hz/s]."""
    rate = np.sign(last - first) * rate
    return driven(0.0, first, rate, amplitude, (last - first) / rate, law)


def steps(frequencies, dwell, amplitude):
    """Return force and velocity of a stepped sine."""
    start = dwell * np.arange(len(frequencies))
    force = np.full(len(frequencies), amplitude)
    return driven(start, frequencies, 0.0, force, dwell * len(frequencies))
