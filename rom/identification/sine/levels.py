"""Levels of a sine test: natural frequency, modal mass, damping, and phase error of the channels.

With x the displacement at the sensor, F the force and a the amplitude of the sensor,

    F / x = m (omega_n(a)^2 - Omega^2 + 2 i delta(a) Omega) e^{i theta}.

theta is the phase error of the channels. How omega_n and delta change with the amplitude within a
level comes from a law. A response-controlled level hardly needs it: its amplitude is constant.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Floats, frozen
from slipmode.rom.identification.first_look import LocalRates
from slipmode.rom.identification.sine.responses import SineTest
from slipmode.rom.identification.slow_laws import SlowLaw

# Largest relative rates of change of the response at resonance, in damping rates. Sweeps then have
# errors of damping of 0.3 %, and of 4 % at 1.8 times the rate. Transients of steps do not cancel:
# errors are 2 % at 0.05, and 8 % at 0.2.
STEADY_SWEEP, STEADY_STEPS = 0.3, 0.05
SETTLED = 4.6  # -log(0.01): damping rate times the time in which a transient decays to 1 %


@frozen
class SineLevel:
    """Hold the properties of a mode fitted to one level of a sine test.

    Attributes
    ----------
    name : str
        Name of the level.
    amplitude : float
        Amplitude at resonance [sensor unit].
    frequency : float
        Frequency of free vibration at this amplitude, sqrt(omega_n^2 - delta^2) [rad/s].
    modal_mass : float
        Modal mass [kg] of a mode shape that is 1 at sensor and force. Its sign is the polarity of
        the channels.
    damping : float
        Damping ratio delta / omega at this amplitude [-].
    damping_without_phase : float
        Damping ratio of a fit without phase error [-].
    phase_error : float
        Phase of the force channel relative to the response channel [rad], -pi/2 to pi/2. It is
        fitted, and `damping` is corrected for it.
    residual : float
        RMS of the misfit of F / x relative to the RMS of F / x [-].
    left_out_damping : float
        Damping ratio predicted by a law of the other levels [-].
    """

    name: str
    amplitude: float
    frequency: float
    modal_mass: float
    damping: float
    damping_without_phase: float
    phase_error: float
    residual: float
    left_out_damping: float = np.nan

    @property
    def damping_rate(self) -> float:
        """Damping rate [1/s]."""
        return self.damping * self.frequency

    @property
    def local_rates(self) -> LocalRates:
        """Amplitude, damping rate and frequency, as of one window of a decay."""
        values = (0.0, self.amplitude, self.damping_rate, self.frequency)
        return LocalRates(*(np.array([each]) for each in values))


def complex_rate(law: SlowLaw, amplitude: Floats | float) -> Complexes:
    """Return -delta + i omega of a law of one mode at amplitudes of any shape [sensor unit]."""
    a = np.asarray(amplitude, float)
    return np.asarray(1j * law.frequencies(a)[0] - law.damping_rates(a)[0])


def stiffness(test: SineTest, order: int) -> Complexes:
    """Return F / x, (points,) [N/m], for a response of `order` time derivatives of x."""
    omega = 2.0 * np.pi * test.frequency
    return np.asarray(test.force * (1j * omega) ** order / test.response)


def fit_level(test: SineTest, order: int, law: SlowLaw | None) -> SineLevel:
    """Return the level of a test; `law` gives the changes with the amplitude within it.

    For a given theta the fit is linear in k = m omega_n^2, m and c = 2 m delta: the real part of
    F e^{-i theta} / x depends on k and m, the imaginary part on c. The sum of squares left is a
    quadratic form in (cos theta, sin theta), so the best theta is its eigenvector.

    Raises
    ------
    SlipmodeError
        If the test has no resonance, or its phase has the opposite sign.
    """
    omega, y = 2.0 * np.pi * test.frequency, stiffness(test, order)
    unit = omega.mean()
    resonance = np.argmin(np.abs(y))
    # Contacts follow the displacement, so a law of accelerations takes it at one frequency.
    amplitude = np.abs(test.response) * (omega[resonance] / omega) ** order
    at = amplitude[resonance]
    shape_k, shape_c = np.ones(omega.size), np.ones(omega.size)
    if law is not None:
        rates, here = complex_rate(law, amplitude), complex_rate(law, at)
        shape_k, shape_c = (np.abs(rates / here) ** 2, rates.real / here.real)
    elastic = np.stack([shape_k, -((omega / unit) ** 2)], axis=1)
    damped = (shape_c * omega / unit)[:, np.newaxis]
    # Real and imaginary part of y e^{-i theta} are these times (cos theta, sin theta).
    real, imaginary = np.stack([y.real, y.imag], axis=1), np.stack([y.imag, -y.real], axis=1)
    rest = [
        values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
        for basis, values in ((elastic, real), (damped, imaginary))
    ]
    form = sum(each.T @ each for each in rest)
    squares, vectors = np.linalg.eigh(form)
    turn = vectors[:, 0] * (1.0 if vectors[0, 0] >= 0.0 else -1.0)
    k, m = np.linalg.lstsq(elastic, real @ turn, rcond=None)[0]
    c = np.linalg.lstsq(damped, imaginary @ turn, rcond=None)[0][0]
    natural = unit * np.sqrt(k / m) if k * m > 0.0 else np.nan
    if not omega.min() < natural < omega.max():
        raise no_resonance(test)
    if c * m < 0.0:
        raise SlipmodeError(
            f"tests: {test.name} has negative damping: the phase of response / force must fall "
            "through the resonance; give the complex conjugate of the response"
        )
    ratio = 0.5 * abs(c) / np.sqrt(k * m)  # delta / omega_n
    # Without phase error, relative to the same k and m: these hardly depend on it.
    plain = abs(np.linalg.lstsq(damped, y.imag, rcond=None)[0][0] / c)
    free = np.sqrt(max(1.0 - ratio**2, 0.0))
    return SineLevel(
        name=test.name,
        amplitude=float(at),
        frequency=float(natural * free),
        modal_mass=float(m / unit**2),
        damping=float(ratio / free),
        damping_without_phase=float(plain * ratio / free),
        phase_error=float(np.arctan2(turn[1], turn[0])),
        residual=float(np.sqrt(max(squares[0], 0.0) / np.sum(np.abs(y) ** 2))),
    )


def check_level(test: SineTest, level: SineLevel) -> None:
    """Refuse tests that change too fast, do not follow one mode, or have too few points."""
    _check_change(test, level)
    # Noise alone leaves 1, the measured beam of tests/rom/identification/sine at most 0.17.
    if level.residual > 0.3:
        raise no_resonance(test)
    if abs(level.phase_error) > 0.25 * np.pi:  # nearer to another derivative of the displacement
        raise SlipmodeError(
            f"tests: {test.name} has a phase error of {level.phase_error:.2f} rad; check that the "
            "unit of the response (m, m/s or m/s^2) fits its phase"
        )
    frequency = level.frequency / (2.0 * np.pi)
    count = np.count_nonzero(np.abs(test.frequency / frequency - 1.0) < level.damping)
    if count < 3:  # six numbers for the four unknowns
        raise SlipmodeError(
            f"tests: {test.name} has {count} points within the half-power bandwidth of "
            f"{2.0 * level.damping * frequency:.2g} Hz around {frequency:.5g} Hz, must have at "
            "least 3; use smaller steps"
        )


def _check_change(test: SineTest, level: SineLevel) -> None:
    """Refuse sweeps and steps in which the response at resonance is not steady."""
    if test.change is None:
        return
    off, delta = 2.0 * np.pi * test.frequency - level.frequency, level.damping_rate
    near = np.abs(off) < delta
    # A sweep by r [rad/s^2] at constant force changes the response by r / |delta + i off|.
    at_resonance = test.change[near] * np.hypot(off[near], delta) / delta
    change = float(np.median(at_resonance)) if near.any() else 0.0
    limit = (STEADY_STEPS if test.stepped else STEADY_SWEEP) * delta
    if change > limit:
        slower = f"sweep by at most {limit * delta / (2.0 * np.pi):.2g} Hz/s"
        if test.stepped:
            slower = f"use steps of at least {SETTLED / delta:.2g} s"
        raise SlipmodeError(
            f"tests: {test.name} changes too fast. At resonance the response changes by "
            f"{change:.2g} 1/s, and the damping rate of {delta:.2g} 1/s allows {limit:.2g} 1/s; "
            f"{slower}"
        )


def no_resonance(test: SineTest) -> SlipmodeError:
    """Return the refusal of a test without a resonance of one mode."""
    slower = "" if test.change is None else ", or sweep more slowly"
    return SlipmodeError(
        f"tests: {test.name} has no resonance of one mode between {test.frequency.min():.5g} and "
        f"{test.frequency.max():.5g} Hz; check the band, the force channel and the unit{slower}"
    )
