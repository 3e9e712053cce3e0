"""A steady state by integration in time from rest, of the structure that a reduced model has.

It takes as many steps as the transient does, however many harmonics the contacts have and however
abruptly they stick, slip and part. What integration finds is steady, but need not be periodic: a
motion with lines beside n Omega_A + m Omega_B is refused.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.harmonic_fit import SAMPLES_PER_PERIOD, HarmonicFit
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.steady import OFF_LATTICE
from slipmode.rom.full.steady import nonharmonic_motion as beside_harmonics
from slipmode.rom.full.structures import ReducedStructure
from slipmode.rom.full.window import Nonharmonic as Elsewhere
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.slow.direct.receptance import Receptance
from slipmode.rom.slow.direct.steady_harmonics import SteadyHarmonics, relative_error

_SHORTEST, _LONGER = 20.0, 200.0  # window, in periods of the slowest carrier
_TOLD, _TURNS = (
    5,
    1.2,
)  # |n| + |m| of lines that it tells from the carriers; turns they drift apart
# To try: how many times the shortest, how many windows. Contacts draw lines of high order near the
# carriers, which short windows do not tell from them.
_WINDOWS = ((1.0, 30), (8.0, 12), (40.0, 8))
_HIGHEST, _MOST = {1: 31, 2: 9}, {1: 31, 2: 13}  # |n| + |m| of harmonics, also in long windows
_RIGID, _ELASTIC = (1, 2, 4, 8), (2, 4, 8, 16)  # time steps a sample: of fourth, of second order
_LEFT_BY_STEPS = 0.5  # of the change by twice as many, of rigid contacts; elastic settle slowly
_LEFT = 0.2  # of the tolerance, that may be left of a transient
_ROUGHLY = 4.0  # with the fewest time steps: how much more than that
_STEADY = 0.01  # change of a motion that is steady all the same
_PATIENCE, _LESS = 4, 0.5  # windows in which changes become so much less, or never do
_SLOWEST = 0.95  # decay of a transient from window to window that is counted on
_DECAYS, _MOST_PERIODS = 7.0, 1000.0  # e-folds of a transient, periods of the slowest carrier
_ROUNDING = 1e-9  # distance of lines that coincide
_FEW, _STAGES = 192, 6  # time steps in a period of the fastest carrier, stages of one
_ONE_STAGE = 150.0  # what it takes beside its contacts


def settles_soon(reduced: Reduced) -> bool:
    """Whether structural damping alone ends a transient before long."""
    return _transient_periods(reduced) <= _MOST_PERIODS


def _transient_periods(reduced: Reduced) -> float:
    """Of the slowest carrier."""
    damping = max(float(reduced.modal_damping.min()), np.finfo(float).tiny)
    return float(_DECAYS * reduced.carrier.min() / (np.pi * damping))


def integration_effort(reduced: Reduced) -> float:
    """What it takes, in the unit of `Effort`, until a transient has ended."""
    periods = min(_transient_periods(reduced), _MOST_PERIODS) + _MOST_PERIODS
    steps = periods * reduced.carrier.max() / reduced.carrier.min() * _FEW * _STAGES
    contacts, modes = reduced.n_contacts, len(reduced.damping_coupling)
    return float(steps * (_ONE_STAGE + contacts * (2 * contacts + modes)))


class _March:
    """A reduced model's structure under forces (modes, n), from rest on, window by window."""

    def __init__(self, reduced: Reduced, law: Friction, force: Floats) -> None:
        small = ReducedStructure.of(reduced)
        patterns = list(force @ small.shapes)
        excitation = Excitation.harmonic(small.structure, patterns, reduced.carrier)
        rows = np.eye(len(reduced.modes), small.structure.n_dofs)
        self.integrator = Integrator(small.structure, law, excitation, rows, SAMPLES_PER_PERIOD)
        self.state: State | None = None

    @property
    def time(self) -> float:
        """Where the next window begins [s]."""
        return 0.0 if self.state is None else self.state.time

    def window(self, fit: HarmonicFit, refine: int) -> FullMotion:
        """The next one, in so many time steps a sample."""
        motion = self.integrator.run(fit.times(self.time), self.state, refine)
        self.state = motion.end
        return motion


class _Settled(NamedTuple):
    """The last two windows: amplitudes (modes,), and what is left of a transient in them."""

    amplitude: Complexes
    left: Floats
    motions: tuple[FullMotion, FullMotion]
    begin: float


def integrated(
    reduced: Reduced, law: Friction, force: Floats, tolerance: float
) -> tuple[Floats, SteadyHarmonics]:
    """Error (modes,) and harmonics of the steady motion under forces (modes, n).

    Raises
    ------
    SlipmodeError
        If a mode is self-excited, or the motion is not periodic in the phases of the carriers or
        does not become steady.
    """
    if (reduced.modal_damping < 0.0).any():
        mode = "AB"[int(np.argmin(reduced.modal_damping))]
        raise SlipmodeError(
            f"aerodynamics: mode {mode} is self-excited, and no steady state was found in which "
            "its force holds it; rom.limit_cycles finds the limit cycles of a tabulated model"
        )
    march, modes, shortest = _March(reduced, law, force), len(reduced.modes), _shortest(reduced)
    rigid = reduced.contacts is None
    refined, by_steps = (list(_RIGID), _LEFT_BY_STEPS) if rigid else (list(_ELASTIC), 1.0)
    for times, most in _WINDOWS:
        highest = (_HIGHEST if times == 1.0 else _MOST)[modes]
        orders = harmonic_orders(highest, modes, reduced.even)
        fit = HarmonicFit.over(times * shortest, reduced.carrier, orders)
        before = _settled(reduced, march, fit, refined[0], _ROUGHLY * tolerance, most)
        while True:
            found = _settled(reduced, march, fit, refined[1], tolerance, most)
            error = by_steps * np.abs(found.amplitude - before.amplitude) + found.left
            off = relative_error(reduced, error, found.amplitude)
            moving = relative_error(reduced, found.left, found.amplitude)
            still, finest = moving <= _LEFT * tolerance, len(refined) == 2
            steady = still or (times == _WINDOWS[-1][0] and moving <= _STEADY)
            if off <= tolerance or (finest and steady):
                return error, _harmonics(reduced, force, march, fit, found)
            of_steps = still or np.any(found.left <= _LESS * before.left)
            if finest or not of_steps:
                break
            before = found
            del refined[0]
    beside = beside_harmonics(march.integrator, march.state)[1]
    raise _refusal(
        "does not become steady;", "frequencies beside the harmonics of the forces", beside
    )


def _shortest(reduced: Reduced) -> float:
    """Periods of the slowest carrier in which lines drift apart from the carriers."""
    carrier, modes = reduced.carrier, len(reduced.modes)
    orders = np.array(harmonic_orders(_TOLD, modes, reduced.even), dtype=float)[:, :modes]
    apart = np.abs(np.abs(orders @ carrier)[:, np.newaxis] - carrier) / carrier.min()
    needed = _TURNS / float(apart[apart > _ROUNDING].min(initial=1.0))
    told = _TURNS / float(np.ptp(carrier) / carrier.min()) if modes == 2 else 0.0
    return max(_SHORTEST, min(needed, _LONGER), told)


def _settled(
    reduced: Reduced, march: _March, fit: HarmonicFit, refine: int, tolerance: float, most: int
) -> _Settled:
    """Windows until they repeat to a part of the tolerance, or as closely as they ever do."""
    decay = np.exp(-0.5 * max(float(reduced.modal_damping.min()), 0.0) * fit.length)
    decay = min(float(decay), _SLOWEST)
    patience = max(_PATIENCE, int(np.log(_LESS) / np.log(decay)))
    changes: list[float] = []
    begin, motion = march.time, march.window(fit, refine)
    amplitude = _amplitude(fit, begin, motion)
    while True:
        before, last, first, begin = amplitude, motion, begin, march.time
        motion = march.window(fit, refine)
        amplitude = _amplitude(fit, begin, motion)
        left = max(decay / (1.0 - decay), 1.0) * np.abs(amplitude - before)
        changes.append(relative_error(reduced, left, amplitude))
        idle = len(changes) > patience and (
            min(changes[-patience:]) > _LESS * min(changes[:-patience])
        )
        if changes[-1] <= _LEFT * tolerance or idle or len(changes) >= most:
            return _Settled(amplitude, left, (last, motion), first)


def _amplitude(fit: HarmonicFit, begin: float, motion: FullMotion) -> Complexes:
    """Of the retained modes at their carriers, (modes,)."""
    return np.diagonal(fit.lines(begin, motion.displacement)).copy()


def _harmonics(
    reduced: Reduced, force: Floats, march: _March, fit: HarmonicFit, found: _Settled
) -> SteadyHarmonics:
    """Of the last two windows."""
    moved, pushed = (
        np.vstack([getattr(motion, name) for motion in found.motions])
        for name in ("contact_displacement", "contact_force")
    )
    _check_periodic(reduced, march, fit, found.motions[1].contact_displacement)
    if reduced.contacts is not None:
        moved = moved * reduced.contacts.reference - pushed
    P = fit.twice.lines(found.begin, moved)
    # of what was integrated the other modes are only a part of what moves with the contacts
    modal = Receptance.of(reduced, fit.orders, 0.5 * force).modal(P)
    own = np.arange(len(reduced.modes))
    modal[own, own] = found.amplitude
    return SteadyHarmonics(found.amplitude, fit.orders, fit.frequency, modal, P)


def _check_periodic(reduced: Reduced, march: _March, fit: HarmonicFit, moved: Floats) -> None:
    """Refuse a motion whose contacts have more than harmonics, of any order."""
    if fit.nonharmonic_share(moved) <= OFF_LATTICE:
        return
    orders = harmonic_orders(_MOST[len(reduced.modes)], len(reduced.modes), reduced.even)
    if fit.with_lines(reduced.carrier, orders).nonharmonic_share(moved) <= OFF_LATTICE:
        return
    beside = beside_harmonics(march.integrator, march.state)[1]
    if beside.share > OFF_LATTICE:
        why = "is not periodic in the phases of the forces:"
        raise _refusal(why, "other frequencies", beside)


def _refusal(why: str, where: str, beside: Elsewhere) -> SlipmodeError:
    return SlipmodeError(
        f"frequency: the motion from rest {why} {beside.share:.0%} of the contacts' is at "
        f"{where}, most at {beside.frequency:.4g} rad/s; move the forcing, give damping to the "
        "modes near by, or integrate in time (rom.full)"
    )
