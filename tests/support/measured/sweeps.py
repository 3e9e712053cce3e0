"""Sine sweeps and stepped sines of an oscillator with a joint, as time signals in full order."""

from dataclasses import dataclass

import numpy as np

from slipmode import rom
from slipmode.rom import full

RATE = 640.0  # samples per second


@dataclass(frozen=True)
class JointedOscillator:
    """A mass on a spring and a damper, with an Iwan joint to the ground below macro-slip."""

    mass: float = 1.8  # [kg]
    frequency: float = 80.0  # with a stuck joint [Hz]
    zeta: float = 0.003  # with a stuck joint
    share: float = 0.05  # of the joint in the stiffness
    slip: float = 2e-4  # displacement at macro-slip [m]

    @property
    def omega(self):
        return 2.0 * np.pi * self.frequency

    @property
    def joint(self):
        k = self.share * self.mass * self.omega**2
        return rom.Iwan(force=0.58 * k * self.slip, stiffness=k, chi=0.0, beta=0.2)

    @property
    def structure(self):
        spring = self.mass * self.omega**2 - self.joint.stiffness
        damper = 2.0 * self.zeta * self.mass * self.omega
        return rom.Structure([[self.mass]], [[spring]], [[damper]], contact=[0])

    def stiffness(self, omega, x):
        """Complex F / x at displacement amplitudes, by the describing functions of the sliders."""
        limit, k = np.array(self.joint.elements(1).slider).T
        c = np.minimum(limit / k / np.asarray(x)[..., np.newaxis], 1.0)
        theta = np.arccos(1.0 - 2.0 * c)
        N = k * (theta - 0.5 * np.sin(2.0 * theta) + 4j * c * (1.0 - c)) / np.pi
        linear = self.mass * (self.omega**2 - omega**2 + 2j * self.zeta * self.omega * omega)
        return linear - self.joint.stiffness + N.sum(axis=-1)

    def damping(self, x):
        """Damping ratio delta / omega of steady vibration at displacement amplitudes."""
        natural = np.sqrt(self.stiffness(0.0, x).real / self.mass)
        return self.stiffness(natural, x).imag / (2.0 * self.mass * natural**2)

    def signals(self, excitation, duration, rng=None, noise=0.0):
        """Force [N] and velocity [m/s], (samples,); noise relative to their largest values."""
        times = np.arange(1, round(duration * RATE) + 1) / RATE
        motion = full.integrate(self.structure, self.joint, excitation, times, steps_per_period=24)
        made = excitation.at(times)[2][:, 0], motion.velocity[:, 0]
        if rng is None:
            return made
        return [y + noise * np.abs(y).max() * rng.standard_normal(y.size) for y in made]


def excitation(start, frequency, rate, amplitude, phase=None):
    """A force with a frequency [Hz] and rate [Hz/s] and an amplitude [N] in each segment."""
    start = np.asarray(start, float)
    ones = np.ones((start.size, 1))

    def column(values):
        return np.asarray(values, float).reshape(-1, 1) * ones

    return full.Excitation(
        np.ones((1, 1)),
        start,
        column(amplitude),
        0.0 * ones,
        2.0 * np.pi * column(frequency),
        2.0 * np.pi * column(rate),
        column(0.0 if phase is None else phase),
        0.0 * ones,
    )


def sweep(first, last, rate, amplitude):
    """Excitation and duration of a sweep between frequencies [Hz] at a rate [Hz/s]."""
    duration = abs(last - first) / rate
    return excitation([0.0], [first], [np.sign(last - first) * rate], [amplitude]), duration


def steps(frequencies, dwell, amplitude):
    """Excitation and duration of a stepped sine."""
    start = dwell * np.arange(len(frequencies))
    return excitation(start, frequencies, 0.0, amplitude), dwell * len(frequencies)


def controlled_sweep(oscillator, first, last, rate, x):
    """Excitation and duration of a sweep whose force keeps the displacement amplitude at x [m].

    Amplitude and phase of the force are adjusted every 0.1 s.
    """
    duration = abs(last - first) / rate
    start = np.arange(0.0, duration, 0.1)
    frequency = first + (last - first) / duration * start
    omega = 2.0 * np.pi * (frequency + 0.05 * (last - first) / duration)
    force = np.array([oscillator.stiffness(each, x) * x for each in omega])
    rates = (last - first) / duration
    return excitation(start, frequency, rates, np.abs(force), np.angle(force)), duration
