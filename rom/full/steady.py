"""Carrier amplitudes of the steady motion under constant forcing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import State
from slipmode.rom.full.window import Nonharmonic, Window
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.structure.structure import Structure

OFF_LATTICE = 0.01  # largest nonharmonic share of the contact motion of a periodic motion
_REFINED, _LESS = (1, 2, 4), 0.8  # divisions of the steps, and the reduction that they must give


@frozen
class SteadyAmplitude:
    """Hold steady amplitudes of x = sum_j 2 Re(amplitude_j exp(i theta_j)) + other harmonics.

    Attributes
    ----------
    amplitude : (modes, outputs) complex ndarray
        Amplitude of each carrier in each output [m].
    error : (modes, outputs) ndarray
        Estimated error [m]: change on halving the time step, plus change between the last windows.
    end : State
        State of the steady motion.
    """

    amplitude: Complexes
    error: Floats
    end: State


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
    """Return the steady carrier amplitudes, by time integration until they are constant.

    Parameters
    ----------
    structure : Structure
        Structure with free contacts.
    law : Tanh, Coulomb, or an elastic law
        Law of the contacts.
    excitation : Excitation
        Constant harmonic forces.
    outputs : sequence of int, or (outputs, n) array_like, optional
        DOFs, or rows that combine DOFs, for instance mode shapes times mass. Default: all DOFs.
    tolerance : float, default 1e-5
        Largest change from one window to the next, relative to the largest amplitude of the
        carrier among the outputs [-]. If a carrier has no force, relative to the largest amplitude
        of both carriers.
    steps_per_period : float, default 64
        Smallest number of steps per period of the fastest forcing.
    step : float, optional
        Largest time step [s], instead of `steps_per_period`.
    start : State, optional
        State near the steady motion, which shortens the transient. Default: undeformed and at
        rest.
    most_windows : int, default 100
        Largest number of windows for each time step.
    periods : float, optional
        Length of a window in periods of the slowest carrier. Default: see Notes.

    Returns
    -------
    SteadyAmplitude
        Complex amplitudes with an error estimate, and a state of the steady motion.

    Raises
    ------
    SlipmodeError
        If the excitation is not constant, or the amplitudes still change after the last window.

    Notes
    -----
    By default, every line n Omega_A + m Omega_B with |n| + |m| <= 7 is at least 12 resolution
    widths of the window from the carriers; a window has at most 1000 periods. Lines that coincide
    with a carrier (commensurate frequencies) are part of its amplitude.

    Strong contacts cause lines of higher order. A line close to a carrier makes its amplitude beat
    from window to window, unless `periods` is several beats long.
    """
    if not excitation.is_constant:
        raise SlipmodeError("excitation: must be constant for a steady amplitude")
    if not 0 < tolerance < 1:
        raise SlipmodeError(f"tolerance: must be between 0 and 1, got {tolerance}")
    if periods is not None and not (np.isfinite(periods) and periods >= 1):
        raise SlipmodeError(f"periods: must be a finite number, at least 1, got {periods}")
    integrator = Integrator(structure, law, excitation, outputs, steps_per_period, step)
    window = Window.of(excitation, periods)
    state = integrator.at_rest() if start is None else start
    found: list[Complexes] = []
    for refine in (1, 2):
        coarse, found = found[-1:], []
        for _ in range(most_windows):
            motion = integrator.run(window.times(state.time), state, refine)
            state = motion.end
            found.append(window.project(motion.time, motion.displacement, window.frequency))
            if len(found) > 1 and np.all(
                np.abs(found[-1] - found[-2]) <= tolerance * window.scale(found[-1])
            ):
                break
        else:
            rest = nonharmonic_motion(integrator, state)
            raise SlipmodeError(
                f"steady amplitude: still changes after {most_windows} windows of "
                f"{window.length:.4g} s. {percentage(rest.share)} of the contact motion is not at "
                f"harmonics of the forces, mostly at {rest.frequency:.4g} rad/s; increase "
                "most_windows, periods (longer windows) or the tolerance"
            )
    error = np.abs(found[-1] - coarse[-1]) + np.abs(found[-1] - found[-2])
    return SteadyAmplitude(found[-1], error, state)


def nonharmonic_motion(integrator: Integrator, begin: State) -> Nonharmonic:
    """Return the nonharmonic part of the contact motion in a long run from a state.

    Transitions between stick and slip inside a step are a noise: a part above OFF_LATTICE is
    computed again with finer steps, as long as these reduce it.
    """
    window = Window.of_lines(integrator.excitation)
    before = np.inf
    for refine in _REFINED:
        motion = integrator.run(window.times(begin.time), begin, refine)
        rest = window.nonharmonic(motion.contact_displacement)
        if rest.share <= OFF_LATTICE or rest.share > _LESS * before:
            break
        before = rest.share
    return rest
