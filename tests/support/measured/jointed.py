"""Drawn structures with a joint, and their decays in full order.

A structure is drawn by its modes with a stuck joint. Its linear damping rates and frequencies are
therefore known exactly.
"""

from dataclasses import dataclass

import numpy as np

from slipmode import rom
from slipmode.rom import full

RATE = 2000.0  # samples per second
NOISE = 0.01  # of the largest sample of a record
JOINTS = ("jenkins", "iwan")


@dataclass(frozen=True)
class Jointed:
    """Three masses of 1 kg; the first has a joint to the ground, the second a sensor."""

    omega: np.ndarray  # of the modes with a stuck joint [rad/s]
    delta: np.ndarray  # their damping rates [1/s]
    shapes: np.ndarray  # (dofs, modes) [kg^-1/2]
    stiffness: float  # of the stuck joint [N/m]
    law: rom.Jenkins | rom.Iwan
    exponent: float  # p of the law of the slow flow; NaN if it is no power law

    @classmethod
    def drawn(cls, rng, joint):
        # Modes A and B away from 1:2 and 1:3; the third mode decays unseen.
        ratio = rng.choice([rng.uniform(1.4, 1.65), rng.uniform(2.4, 2.8)])
        omega = 2.0 * np.pi * rng.uniform(70.0, 110.0) * np.array([1.0, ratio, 4.3])
        delta = rng.uniform(0.001, 0.003, 3) * omega
        shapes = np.zeros((3, 3))
        while np.abs(shapes[:2, :2]).min() < 0.35:  # joint and sensor take part in both modes
            shapes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        # Without the joint the frequency of the mode that it moves more falls by this share.
        share = rng.uniform(0.003, 0.015)
        stiffness = float(2.0 * share * (omega[:2] ** 2 / shapes[0, :2] ** 2).min())
        # of the joint, where both modes have 1 m/s at the sensor
        largest = float(np.abs(shapes[0, :2] / shapes[1, :2] / omega[:2]).sum())
        if joint == "jenkins":
            slip = rng.uniform(0.1, 0.5) * largest
            law, exponent = rom.Jenkins(stiffness * slip, stiffness), np.nan
        else:
            chi, beta = rng.uniform(-0.6, 0.4), rng.uniform(0.0, 2.0)
            macro = rng.uniform(0.7, 3.0)
            force = (beta + (chi + 1.0) / (chi + 2.0)) / (1.0 + beta) * macro * largest * stiffness
            law = rom.Iwan(force, stiffness, chi, beta)
            exponent = chi + 1.0 if macro > 1.0 else np.nan
        return cls(omega, delta, shapes, stiffness, law, exponent)

    @property
    def bands(self):
        """Bands around the modes [Hz]."""
        return [(0.9 * f, 1.08 * f) for f in self.omega[:2] / (2.0 * np.pi)]

    @property
    def parameters(self):
        """True values of the parameters that have one."""
        natural = np.sqrt(self.omega**2 - self.delta**2)
        values = {}
        for mode, delta, omega in zip("AB", self.delta[:2], natural[:2], strict=True):
            values |= {f"delta_0_{mode}": delta, f"omega_0_{mode}": omega}
            if np.isfinite(self.exponent):
                values[f"p_{mode}"] = self.exponent
        return values

    def decay(self, amplitude, duration=2.5):
        """Motion after a blow by which both modes have amplitudes (2,) at the sensor [m/s]."""
        shapes, joint = self.shapes, np.diag([self.stiffness, 0.0, 0.0])
        K = (shapes * self.omega**2) @ shapes.T - joint
        structure = rom.Structure(
            np.eye(3), K, (shapes * 2.0 * self.delta) @ shapes.T, contact=[0]
        )
        silent = full.Excitation.harmonic(structure, [{0: 0.0}, {1: 0.0}], self.omega[:2])
        velocity = shapes[:, :2] @ (amplitude / shapes[1, :2])
        start = full.State(0.0, np.zeros(3), velocity)
        times = np.arange(1, round(duration * RATE) + 1) / RATE
        return full.integrate(structure, self.law, silent, times, steps_per_period=24, start=start)

    def measurement(self, rng, records=6):
        made = []
        for k in range(1, records + 1):
            size = rng.uniform(0.4, 1.0, 2) * rng.choice([-1.0, 1.0], 2)
            y = self.decay(size).velocity[:, 1]
            y = y + NOISE * np.abs(y).max() * rng.standard_normal(y.size)
            made.append(rom.Record(f"hit{k}", y[np.newaxis], RATE))
        return rom.Measurement(made, "velocity", "m/s", ("velocity",))

    def rates(self, amplitude):
        """Amplitudes [m/s], damping rates and frequencies of both modes in one decay, (2, n) each.

        From modal displacements and velocities without noise, averaged over 80 ms against the
        responses to harmonics of the joint, by differences over 100 ms. Nothing of
        rom.identification is used.
        """
        motion = self.decay(amplitude)
        q, v = (each @ self.shapes[:, :2] for each in (motion.displacement, motion.velocity))
        omega = self.omega[:2]
        z = (v + 1j * omega * q) * np.exp(-1j * np.multiply.outer(motion.time, omega))
        window = np.hanning(162) / np.hanning(162).sum()
        z = np.array([np.convolve(each, window, "valid") for each in z.T])
        half = 100
        at = np.arange(half, z.shape[1] - half, 300)
        slope = np.log(z[:, at + half] / z[:, at - half]) * RATE / (2 * half)
        size = np.abs(z[:, at]) * np.abs(self.shapes[1, :2, np.newaxis])
        return size, -slope.real, omega[:, np.newaxis] + slope.imag
