"""Carrier amplitudes of the steady motion under constant forcing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.window import Elsewhere, Window
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.structure import Structure

OFF_LATTICE = 0.01  # RMS of the contacts' motion beside the harmonics: it is not periodic in them
_REFINED, _LESS = (1, 2, 4), 0.8  # steps to look at that in, while it becomes so much less


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
    window = Window.of(excitation, periods)
    coarse = _settle(integrator, window, start, 1, tolerance, most_windows)
    fine = _settle(integrator, window, coarse.end, 2, tolerance, most_windows)
    error = np.abs(fine.amplitude - coarse.amplitude) + fine.error
    return SteadyAmplitude(fine.amplitude, error, fine.end)


def _settle(
    integrator: Integrator,
    window: Window,
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
        state = motion.end
        amplitude = window.project(motion.time, motion.displacement, window.frequency)
        if last is not None:
            change = np.abs(amplitude - last)
            if np.all(change <= tolerance * window.scale(amplitude)):
                return SteadyAmplitude(amplitude, change, state)
        last = amplitude
    beside = beside_harmonics(integrator, state)[1]
    raise SlipmodeError(
        f"steady amplitude: still changing after {most_windows} windows of {window.length:.4g} s, "
        f"{beside.share:.2g} of the contacts' motion at frequencies beside the harmonics of the "
        f"forces, most at {beside.frequency:.4g} rad/s; raise most_windows, periods (longer "
        "windows) or the tolerance, or look at the motion itself"
    )


def beside_harmonics(integrator: Integrator, state: State | None) -> tuple[FullMotion, Elsewhere]:
    """A long stretch of motion from a state, and what its contacts do beside the harmonics.

    More than OFF_LATTICE is looked at in finer steps as long as these bring it down: where in a
    step contacts stick or slip is a noise of its own.
    """
    window = Window.of_lines(integrator.excitation)
    begin = float(integrator.excitation.start[0]) if state is None else state.time
    share = np.inf
    for refine in _REFINED:
        motion = integrator.run(window.times(begin), state, refine)
        beside = window.elsewhere(motion.contact_displacement)
        if beside.share <= OFF_LATTICE or beside.share > _LESS * share:
            break
        share = beside.share
    return motion, beside
