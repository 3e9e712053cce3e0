"""A steady state by integration in time from rest, of the structure that a reduced model has.

It takes as many steps as the transient does, however many harmonics the contacts have and however
abruptly they stick, slip and open. A steady motion with lines beside n Omega_A + m Omega_B is
refused.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.time_budget import contact_size
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.harmonic_fit import SAMPLES_PER_PERIOD, HarmonicFit
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.steady import OFF_LATTICE, nonharmonic_motion
from slipmode.rom.full.structures import ReducedStructure
from slipmode.rom.full.window import Nonharmonic
from slipmode.rom.laws.friction import Coulomb, Tanh
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.direct.steady_harmonics import (
    Receptance,
    SteadyHarmonics,
    SteadyProblem,
    relative_error,
)

# Windows to try: their length relative to the shortest, and their greatest number. Contacts cause
# lines of high order near the carriers, which short windows do not distinguish from these.
_WINDOWS = ((1.0, 30), (8.0, 12), (40.0, 8))
# |n| + |m| of the harmonics, by modes, in the shortest window and in longer ones.
_HIGHEST, _HIGHEST_LONG = {1: 31, 2: 9}, {1: 31, 2: 13}
_TRANSIENT = 0.2  # largest part of the tolerance for the rest of the transient
_STEP = 10.0  # work of a step on all modes, relative to a step of the contacts alone, about
_LESS = 0.5  # part to which changes must fall within the patience


def ends_soon(reduced: Reduced) -> bool:
    """Return whether structural damping alone ends a transient in 1000 periods."""
    damping = float(reduced.modal_damping.min())
    # seven e-folds leave a thousandth of a transient
    return bool(7.0 * reduced.carrier.min() <= np.pi * damping * 1000.0)


class _Steady(NamedTuple):
    """The last two windows: amplitudes (modes,), and the rest of the transient in them."""

    amplitude: Complexes
    rest: Floats
    motions: tuple[FullMotion, FullMotion]
    begin: float


class _Run:
    """A reduced model's structure under forces (modes, n) from rest on, window by window."""

    def __init__(self, problem: SteadyProblem) -> None:
        reduced, law, force = problem.reduced, problem.law, problem.force
        self._work = problem.work
        self._size = _STEP * contact_size(reduced.n_contacts, reduced.contacts)
        self.reduced = reduced
        self.force = force
        small = ReducedStructure.of(reduced)
        patterns = list(force @ small.shapes)
        excitation = Excitation.harmonic(small.structure, patterns, reduced.carrier)
        rows = np.eye(len(reduced.modes), small.structure.n_dofs)
        self.integrator = Integrator(small.structure, law, excitation, rows, SAMPLES_PER_PERIOD)
        self.state: State = self.integrator.at_rest()

    def window(self, fit: HarmonicFit, refine: int) -> tuple[FullMotion, Complexes]:
        """Return the next motion, in `refine` steps per sample, and its amplitudes (modes,)."""
        begin = self.state.time
        times = fit.times(begin)
        motion = self.integrator.run(times, self.state, refine)
        self._work.add(float(refine * times.size * self._size))
        self.state = motion.end
        return motion, np.diagonal(fit.lines(begin, motion.displacement)).copy()

    def until_steady(self, fit: HarmonicFit, refine: int, tolerance: float, most: int) -> _Steady:
        """Run windows until they repeat to a part of the tolerance, or come no closer to it."""
        decay = np.exp(-0.5 * max(float(self.reduced.modal_damping.min()), 0.0) * fit.length)
        decay = min(float(decay), 0.95)  # from window to window
        patience = max(4, int(np.log(_LESS) / np.log(decay)))
        changes: list[float] = []
        begin = self.state.time
        motion, amplitude = self.window(fit, refine)
        while True:
            before, last, first, begin = amplitude, motion, begin, self.state.time
            motion, amplitude = self.window(fit, refine)
            rest = max(decay / (1.0 - decay), 1.0) * np.abs(amplitude - before)
            changes.append(relative_error(self.reduced, rest, amplitude))
            idle = len(changes) > patience and (
                min(changes[-patience:]) > _LESS * min(changes[:-patience])
            )
            if changes[-1] <= _TRANSIENT * tolerance or idle or len(changes) >= most:
                return _Steady(amplitude, rest, (last, motion), first)

    def harmonics(self, fit: HarmonicFit, found: _Steady) -> SteadyHarmonics:
        """Return the harmonics of the last two windows, of a periodic motion."""
        moved, pushed = (
            np.vstack([getattr(motion, name) for motion in found.motions])
            for name in ("contact_displacement", "contact_force")
        )
        self._check_periodic(fit, found.motions[1].contact_displacement)
        if self.reduced.contacts is not None:
            moved = moved * self.reduced.contacts.reference - pushed
        P = fit.twice.lines(found.begin, moved)
        # The integrated structure represents the other modes only as far as contacts move them.
        modal = Receptance.of(self.reduced, fit.orders, 0.5 * self.force).modal(P)
        own = np.arange(len(self.reduced.modes))
        modal[own, own] = found.amplitude
        return SteadyHarmonics(found.amplitude, fit.orders, fit.frequency, modal, P)

    def _check_periodic(self, fit: HarmonicFit, moved: Floats) -> None:
        """Refuse a motion whose contacts move at other frequencies than harmonics of any order."""
        if fit.nonharmonic_share(moved) <= OFF_LATTICE:
            return
        modes = len(self.reduced.modes)
        orders = harmonic_orders(_HIGHEST_LONG[modes], modes, self.reduced.even)
        more = fit.with_lines(self.reduced.carrier, orders)
        if more.nonharmonic_share(moved) <= OFF_LATTICE:
            return
        rest = nonharmonic_motion(self.integrator, self.state)
        if rest.share > OFF_LATTICE:
            why = "is not periodic in the phases of the forces:"
            raise _refusal(why, "other frequencies", rest)


def integrated(problem: SteadyProblem) -> tuple[Floats, SteadyHarmonics]:
    """Return the error (modes,) and harmonics of the steady motion.

    Raises
    ------
    SlipmodeError
        If the motion is not periodic in the phases of the carriers, or does not become steady.
    """
    # the shortest window, in periods of the slowest carrier
    reduced, tolerance = problem.reduced, problem.tolerance
    run, modes, shortest = _Run(problem), len(reduced.modes), 20.0
    if modes == 2:
        # two carriers drift apart by more than a period in it
        shortest = max(shortest, float(1.2 * reduced.carrier.min() / np.ptp(reduced.carrier)))
    # Time steps per sample to try. The error of elastic contacts falls irregularly, with the
    # second order, where contacts turn between two steps. The error of Coulomb friction was 0.9 to
    # 1.8 times the change by half the step (tests/evidence, direct 27, 42, 50).
    refined = [2, 4, 8, 16] if reduced.contacts is not None else [1, 2, 4, 8, 16]
    by_steps = {Coulomb: 2.0, Tanh: 0.5}.get(type(problem.law), 1.0)
    for times, most in _WINDOWS:
        highest = (_HIGHEST if times == 1.0 else _HIGHEST_LONG)[modes]
        orders = harmonic_orders(highest, modes, reduced.even)
        fit = HarmonicFit.over(times * shortest, reduced.carrier, orders)
        # The transient of the coarsest steps may end later: finer steps continue it.
        before = run.until_steady(fit, refined[0], 4.0 * tolerance, most)
        while True:
            found = run.until_steady(fit, refined[1], tolerance, most)
            error = by_steps * np.abs(found.amplitude - before.amplitude) + found.rest
            off = relative_error(reduced, error, found.amplitude)
            moving = relative_error(reduced, found.rest, found.amplitude)
            still, finest = moving <= _TRANSIENT * tolerance, len(refined) == 2
            # in the longest windows, a motion that hardly changes is taken for steady
            steady = still or (times == _WINDOWS[-1][0] and moving <= 0.01)
            if off <= tolerance or (finest and steady):
                return error, run.harmonics(fit, found)
            due_to_steps = still or np.any(found.rest <= _LESS * before.rest)
            if finest or not due_to_steps:
                break
            before = found
            del refined[0]
    rest = nonharmonic_motion(run.integrator, run.state)
    where = "frequencies other than harmonics of the forces"
    raise _refusal("does not become steady", where, rest)


def _refusal(why: str, where: str, rest: Nonharmonic) -> SlipmodeError:
    return SlipmodeError(
        f"frequency: the motion from rest {why}. {percentage(rest.share)} of the contact motion "
        f"is at {where}, mostly at {rest.frequency:.4g} rad/s; move the forcing, give damping to "
        "the modes at this frequency, or integrate in time (rom.full)"
    )
