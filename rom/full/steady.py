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
_SLOW = 0.5  # ratio of successive changes above which it measures the decay of a transient
_REFINED, _LESS = (1, 2, 4), 0.8  # divisions of the steps, and the reduction that they must give


@frozen
class SteadyAmplitude:
    """Hold steady amplitudes of x = sum_j 2 Re(amplitude_j exp(i theta_j)) + other harmonics.

    Attributes
    ----------
    amplitude : (modes, outputs) complex ndarray
        Amplitude of each carrier in each output [m].
    error : (modes, outputs) ndarray
        Estimated error [m]: change on halving the time step, plus the rest of the transient.
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
        Largest rest of the transient, relative to the largest amplitude of the carrier among the
        outputs [-]. If a carrier has no force, relative to the largest amplitude of both carriers.
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
    decay = float(np.exp(-integrator.slowest_decay() * window.length))
    state = integrator.at_rest() if start is None else start
    found: list[Complexes] = []
    for refine in (1, 2):
        coarse, found = found[-1:], []
        for _ in range(most_windows):
            motion = integrator.run(window.times(state.time), state, refine)
            state = motion.end
            found.append(window.project(motion.time, motion.displacement, window.frequency))
            rest = _rest_of_transient(np.array(found[-4:]), decay)
            if np.all(rest <= tolerance * window.scale(found[-1])):
                break
        else:
            other = nonharmonic_motion(integrator, state)
            raise SlipmodeError(
                f"steady amplitude: still changes after {most_windows} windows of "
                f"{window.length:.4g} s. {percentage(other.share)} of the contact motion is not "
                f"at harmonics of the forces, mostly at {other.frequency:.4g} rad/s; increase "
                "most_windows, periods (longer windows) or the tolerance"
            )
    return SteadyAmplitude(found[-1], np.abs(found[-1] - coarse[-1]) + rest, state)


def _rest_of_transient(found: Complexes, decay: float) -> Floats:
    """Return how far the last of several windows is from the steady amplitudes, (modes, outputs).

    `found` has the last amplitudes, (windows, modes, outputs), and `decay` is the factor by which
    structural damping reduces a transient from window to window. If the transient is multiplied
    by r in each window, the last change is multiplied by r / (1 - r) in total. Once the changes
    hardly fall, r is the complex ratio of successive changes. Changes that are a noise, or beats,
    have ratios that differ from 1. The rest is at least the last change.
    """
    if len(found) < 2:
        return np.full(found.shape[1:], np.inf)
    change = np.diff(found, axis=0)
    rounding = np.finfo(float).eps
    factor = np.full((found.shape[1], 1), decay / max(1.0 - decay, rounding))
    if len(change) == 3:
        before, after = change[:-1], change[1:]
        power = np.sum(np.abs(before) ** 2, axis=2, keepdims=True)
        product = np.sum(before.conj() * after, axis=2, keepdims=True)
        ratio = np.divide(product, power, out=np.zeros_like(product), where=power > 0.0)
        # Before, other modes may hide a slow one: their transients fall faster.
        falls_slowly = np.all(np.abs(ratio) > _SLOW, axis=0)
        measured = (np.abs(ratio) / np.maximum(np.abs(1.0 - ratio), rounding)).max(axis=0)
        usable = falls_slowly | (decay == 1.0)
        factor = np.where(usable, np.minimum(factor, measured), factor)
    return np.asarray(np.maximum(factor, 1.0) * np.abs(change[-1]))


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
