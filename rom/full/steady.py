"""Carrier amplitudes of the steady motion under constant forcing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.structure import Structure

_WINDOW_POWER = 8  # of sin(pi t / T): zero leakage from harmonics of the window beyond the 4th
_BINS = 12  # distance from a carrier to the next line of the spectrum, in 1 / T
_ORDER = 7  # |n| + |m| of the lines that are kept apart from the carriers
_SHORTEST, _LONGEST = 40, 1000  # window in periods of the slowest carrier
# of the fastest carrier: no whole number, so that no harmonic aliases onto a carrier and the steps
# fall on every phase of it within a window
_SAMPLES_PER_PERIOD = 32.618


@dataclass(frozen=True, eq=False)
class SteadyAmplitude:
    """x = sum_j 2 Re(amplitude_j exp(i theta_j)) + other harmonics.

    Attributes
    ----------
    amplitude : (modes, outputs) complex ndarray
        Of each carrier in each output [m].
    error : (modes, outputs) ndarray
        Estimate: change on halving the time step, plus what is left of the transient [m].
    end : State
        A state on the steady motion.
    """

    amplitude: Complexes
    error: Floats
    end: State

    __repr__ = short_repr


def steady_amplitude(
    structure: Structure,
    law: Friction | Elastic,
    excitation: Excitation,
    *,
    outputs: Sequence[int] | ArrayLike | None = None,
    tolerance: float = 1e-5,
    steps_per_period: float = 64,
    step: float | None = None,
    start: State | None = None,
    most_windows: int = 100,
    periods: float | None = None,
) -> SteadyAmplitude:
    """Integrate until the carrier amplitudes no longer change.

    Parameters
    ----------
    structure : Structure
    law : Friction or elastic law
        Of its contacts.
    excitation : Excitation
        Constant.
    outputs : sequence of int, or (outputs, n) array_like, optional
        DOFs, or rows that combine them, like mode shapes times mass; all DOFs by default.
    tolerance : float, default 1e-5
        Largest change from one window to the next, relative to the largest amplitude of the
        carrier among the outputs (of both carriers where one is not forced).
    steps_per_period, step
        Largest time step, as in `integrate`.
    start : State, optional
        A state near the steady motion, with its time and so the angles theta_j, saves the
        transient; by default at rest.
    most_windows : int, default 100
        Windows to try before giving up.
    periods : float, optional
        Length of a window in periods of the slowest carrier, instead of the one below. Strong
        contacts draw lines of higher order than those: one close beside a carrier makes its
        amplitude beat from window to window, until these are several beats long.

    Raises
    ------
    SlipmodeError
        If the excitation is not constant, or the amplitudes still change after the last window.

    Notes
    -----
    A window is long enough for every line n Omega_A + m Omega_B, |n| + |m| <= 7, to lie 12
    resolution widths from the carriers, at most 1000 periods; lines that coincide with a carrier
    (commensurate frequencies) belong to its amplitude.
    """
    if not excitation.is_constant:
        raise SlipmodeError("excitation: must be constant for a steady amplitude")
    if not 0 < tolerance < 1:
        raise SlipmodeError(f"tolerance: must be between 0 and 1, got {tolerance}")
    if periods is not None and not (np.isfinite(periods) and periods >= 1):
        raise SlipmodeError(f"periods: must be a finite number, at least 1, got {periods}")
    integrator = Integrator(structure, law, excitation, outputs, steps_per_period, step)
    window = _Window.of(excitation, periods)
    coarse = _settle(integrator, window, start, 1, tolerance, most_windows)
    fine = _settle(integrator, window, coarse.end, 2, tolerance, most_windows)
    error = np.abs(fine.amplitude - coarse.amplitude) + fine.error
    return SteadyAmplitude(fine.amplitude, error, fine.end)


@dataclass(frozen=True)
class _Window:
    """Stretch of time over which a carrier is projected out of a signal."""

    frequency: Floats  # (modes,) of the carriers
    forced: Flags  # (modes,) whether there is any force
    length: float
    samples: int

    @classmethod
    def of(cls, excitation: Excitation, periods: float | None) -> _Window:
        frequency = excitation.frequency[0]
        forced = np.any(excitation.patterns != 0, axis=1) & (excitation.amplitude[0] != 0)
        slowest = frequency.min()
        if periods is None:
            needed = _BINS / _line_spacing(frequency[forced] if forced.any() else frequency)
            periods = float(np.clip(needed * slowest, _SHORTEST, _LONGEST))
        length = 2 * np.pi * periods / slowest
        samples = int(np.ceil(length * frequency.max() * _SAMPLES_PER_PERIOD / (2 * np.pi)))
        return cls(frequency, forced, length, samples)

    def times(self, begin: float) -> Floats:
        return begin + self.length * np.arange(1, self.samples + 1) / self.samples

    def project(self, motion: FullMotion, begin: float) -> Complexes:
        """Amplitude of every carrier in every output, (modes, outputs)."""
        weight = np.sin(np.pi * (motion.time - begin) / self.length) ** _WINDOW_POWER
        carrier = np.exp(-1j * np.outer(self.frequency, motion.time))
        return np.asarray((carrier * (weight / weight.sum())) @ motion.displacement)

    def scale(self, amplitude: Complexes) -> Floats:
        """Largest amplitude of each carrier, of any where it is not forced, (modes, 1)."""
        largest = np.abs(amplitude).max(axis=1, keepdims=True)
        return np.asarray(np.where(self.forced[:, np.newaxis], largest, largest.max()))


def _line_spacing(frequency: Floats) -> float:
    """Least distance from a carrier to another line of the spectrum [rad/s]."""
    orders = np.arange(-_ORDER, _ORDER + 1)
    n, m = np.meshgrid(orders, orders if frequency.size == 2 else [0])
    listed = np.abs(n) + np.abs(m) <= _ORDER
    lines = n[listed] * frequency[0] + m[listed] * frequency[-1]
    distance = np.abs(lines[:, np.newaxis] - frequency)
    return float(distance[distance > 1e-9 * frequency.max()].min())


def _settle(
    integrator: Integrator,
    window: _Window,
    start: State | None,
    refine: int,
    tolerance: float,
    most_windows: int,
) -> SteadyAmplitude:
    """Window after window until the amplitudes repeat."""
    state, last = start, None
    for _ in range(most_windows):
        begin = float(integrator.excitation.start[0]) if state is None else state.time
        motion = integrator.run(window.times(begin), state, refine)
        state, amplitude = motion.end, window.project(motion, begin)
        if last is not None:
            change = np.abs(amplitude - last)
            if np.all(change <= tolerance * window.scale(amplitude)):
                return SteadyAmplitude(amplitude, change, state)
        last = amplitude
    raise SlipmodeError(
        f"steady amplitude: still changing after {most_windows} windows of {window.length:.4g} s; "
        "raise most_windows, periods (longer windows) or the tolerance, or look at the motion "
        "itself"
    )
