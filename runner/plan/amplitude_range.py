"""How far the amplitudes of a scene go: found by a dry run, so that no more is tabulated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.fmu import Component, StoppedError
from slipmode.rom import Friction, Model, Reduced, SlipmodeError
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.force_response import off_resonance_shift, phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.transient import TransientError, friction_threshold
from slipmode.rom.table.cache import cached_model
from slipmode.runner.plan.settling import Stretches, shortened
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import LIMIT_SCALE, Schedule

_TOLERANCE = 0.05  # of the coarse table
_FIRST_GUESS = 4.0  # times the amplitude at which the first contact slips
_PATH_TOLERANCE = 5e-10  # of the slow flow: short steps show peaks and changes within a cycle
_MARGIN = 0.15  # of the table over the largest amplitude of the dry run
_LARGEST_GROWTH = 2.0**40
_LARGEST_FLUTTER = 2.0**8  # contacts slip freely long before, and what they take grows no more


@dataclass(frozen=True, eq=False)
class Excited:
    """The modes of a scene that move, and what moves them.

    Attributes
    ----------
    modes : tuple of str
        Of "A" and "B".
    reduced : Reduced
    law : Friction
    force_patterns : tuple of (n,) ndarray
        Force on every DOF per unit of the scripted amplitude, of each mode.
    initial : tuple of complex
        Motion of the modes at t = 0, as amplitudes.
    amplitude : tuple of complex
        Amplitudes at t = 0: `initial` less what the modes respond to forces that then act.
    """

    modes: tuple[Mode, ...]
    reduced: Reduced
    law: Friction
    force_patterns: tuple[Floats, ...]
    initial: tuple[complex, ...]
    amplitude: tuple[complex, ...]

    __repr__ = short_repr

    def modal_forces(
        self, schedule: Schedule, steps: slice = slice(None)
    ) -> tuple[Complexes, Complexes]:
        """F_j exp(i phase_j) at the start and at the end of steps, (steps, modes)."""
        modal = np.array(
            [self.reduced.modal_force(j, f) for j, f in enumerate(self.force_patterns)]
        )
        start, end = schedule.forces(self.modes, steps)
        return modal * start, modal * end

    def component(self, model: Model, tolerance: float) -> Component:
        """A component at t = 0 of the scene."""
        component = Component(
            model, self.force_patterns, mode_names=self.modes, tolerance=tolerance, warned=False
        )
        component.reset(amplitude=self.amplitude)
        return component

    def start(self) -> dict[str, float]:
        """Amplitudes at t = 0 by name of the component's outputs."""
        start = {}
        for mode, amplitude in zip(self.modes, self.amplitude, strict=True):
            start[f"{mode}_re"] = complex(amplitude).real
            start[f"{mode}_im"] = complex(amplitude).imag
        return start


@dataclass(frozen=True, eq=False)
class DryRun:
    """What a run on a coarse table shows.

    Attributes
    ----------
    amplitude : tuple of float
        Range that the friction table needs [kg^1/2 m].
    reached : (modes,) ndarray
        The largest effective amplitudes at the contacts, relative to the scale of the friction
        limits at their time [kg^1/2 m].
    reason : str
    contact_share : (modes,) ndarray
        |Q_j| / omega_j^2 at the largest amplitudes: how much of a mode's stiffness is at stake
        at the contacts.
    time : (points,) ndarray
        Points of the run, in the time of the scene [s].
    transient_error : (points - 1, modes) ndarray
        `TransientError` between the points, like `reached` [kg^1/2 m].
    """

    amplitude: tuple[float, ...]
    reached: Floats
    reason: str
    contact_share: Floats
    time: Floats
    transient_error: Floats

    __repr__ = short_repr


def dry_run(
    excited: Excited,
    schedule: Schedule,
    combinations: Sequence[CombinationResonance] = (),
    *,
    progress: bool = False,
) -> DryRun:
    """Run a schedule on a coarse table, which is doubled in range until the run stays inside.

    Where contacts do not settle at amplitudes of the first guess, which the run need not reach,
    the range is halved instead.

    Raises
    ------
    SlipmodeError
        If the amplitudes grow without bound, a step cannot be taken on any table, or contacts do
        not settle at amplitudes that the run reaches.
    """
    tried = _first_guess(excited, schedule)
    smallest = np.maximum(0.5 * tried / _FIRST_GUESS, np.abs(np.array(excited.amplitude)))
    unsettled: UnsettledError | None = None
    self_excited = excited.reduced.modal_damping < 0.0
    largest = np.where(self_excited, _LARGEST_FLUTTER, _LARGEST_GROWTH) * tried
    while True:
        try:
            coarse, _ = cached_model(
                *(excited.reduced, excited.law, tried.tolist(), _TOLERANCE),
                combinations=combinations,
                detuning=False,
                progress=progress,
            )
        except UnsettledError as refusal:
            if np.any(0.5 * tried < smallest):
                raise
            unsettled, tried = refusal, 0.5 * tried
            continue
        reached, transient, complete = _path(excited, coarse, schedule)
        if complete:
            break
        if unsettled is not None:
            raise unsettled
        tried = np.where(reached > 0.5 * tried, 2.0 * tried, tried)
        if np.any(tried > largest):
            raise SlipmodeError(_unbounded(excited))
    # a self-excited mode that is at rest may be started from outside
    rests = (reached == 0.0) & self_excited
    least = np.maximum((1.0 + _MARGIN) * reached, np.where(rests, 1.0, 1e-2) * tried)
    amplitude = tuple(_round_up(value) for value in least)
    shown = ", ".join(f"|{m}| = {r:.3g}" for m, r in zip(excited.modes, reached, strict=True))
    reason = f"a dry run on a coarse table reaches {shown}; {_MARGIN:.0%} margin"
    share = np.abs(coarse.table(reached)) / np.where(reached > 0, reached, 1.0)
    share = share / excited.reduced.frequency**2
    return DryRun(amplitude, reached, reason, share, *transient)


def _unbounded(excited: Excited) -> str:
    """Why the amplitudes of a scene grow without bound."""
    for mode, damping in zip(excited.modes, excited.reduced.modal_damping, strict=True):
        if damping < 0.0:
            return (
                f"aerodynamics.{mode}: friction does not hold mode {mode}, which grows without "
                "bound; excite it less or give structure.damping more; or give model.amplitude, "
                "and the run ends there"
            )
    return "forcing: the amplitudes grow without bound; give structure.damping a value > 0"


def _largest_force(excited: Excited, schedule: Schedule) -> Floats:
    names = [f"force_{mode}" for mode in excited.modes]
    return np.asarray(np.abs(schedule.extremes(names)).max(axis=0))


def _first_guess(excited: Excited, schedule: Schedule) -> Floats:
    """Several times the amplitude at which the first contact slips, or opens.

    Or, where that is more, what the force does statically: no amplitude stays far below it.
    """
    first = friction_threshold(excited.reduced, excited.law)
    initial = np.abs(np.array(excited.amplitude))
    frequency = np.maximum(excited.reduced.frequency, excited.reduced.carrier)
    factor = [excited.reduced.modal_force(j, f) for j, f in enumerate(excited.force_patterns)]
    force = np.abs(factor) * _largest_force(excited, schedule)
    static = np.maximum(0.5 * force / frequency**2, 1.5 * initial)
    return np.asarray(np.maximum(np.where(np.isfinite(first), _FIRST_GUESS * first, 0.0), static))


def _path(
    excited: Excited, model: Model, schedule: Schedule
) -> tuple[Floats, tuple[Floats, Floats], bool]:
    """The largest effective amplitudes (modes,) on a coarse table.

    They are relative to the limits at their time, as the table is looked up. Then the times of the
    points in the scene and the transient errors between them; and whether the run stayed inside.
    """
    component = excited.component(model, _PATH_TOLERANCE)
    names = component.input_names
    durations, inputs = shortened(schedule, model, excited.modes, names)
    start = np.append(0.0, np.array([excited.amplitude]).view(float))
    rows, complete = [start[np.newaxis]], True

    def keep(outputs: Floats) -> None:
        rows.append(outputs[:, : start.size].copy())

    try:
        for outputs in component.trace(durations, inputs):
            keep(outputs)
    except StoppedError as stop:
        if not stop.left_table:
            raise SlipmodeError(f"run: {stop}") from None
        keep(stop.outputs)
        complete = False
    traced = np.concatenate(rows)
    time, amplitude = traced[:, 0], traced[:, 1::2] + 1j * traced[:, 2::2]
    stretches = Stretches(durations, inputs, schedule.stretches().durations(), names)
    scaled, path = _effective(excited, model, stretches, time, amplitude)
    reached: Floats = path.max(axis=0)
    if not complete and not np.any(reached > 0.5 * model.table.amplitude_range):
        reached = model.table.amplitude_range  # it left within one step: no telling which way
    error = _transient_error(excited, stretches, time, scaled, path)
    return reached, (stretches.in_scene(time), error), complete


def _effective(
    excited: Excited, model: Model, stretches: Stretches, time: Floats, amplitude: Complexes
) -> tuple[Complexes, Floats]:
    """Amplitudes (points, modes) by the scale of the limits, and the effective ones.

    At a jump the scale is the smaller one, and the effective amplitude the larger one.
    """
    sides = stretches.around(time)
    scale = np.minimum(*(stretches.values(LIMIT_SCALE, time, k) for k in sides))[:, np.newaxis]
    shift = off_resonance_shift(model.reduced, excited.force_patterns)
    effective = []
    for number in sides:
        force = np.empty_like(amplitude)
        for j, mode in enumerate(excited.modes):
            factor = excited.reduced.modal_force(j, excited.force_patterns[j])
            size, phase = (
                stretches.values(f"{name}_{mode}", time, number) for name in ("force", "phase")
            )
            force[:, j] = phasor(factor * size, phase)
        effective.append(np.abs(amplitude + shift * force) / scale)
    return amplitude / scale, np.maximum(*effective)


def _transient_error(
    excited: Excited, stretches: Stretches, time: Floats, amplitude: Complexes, path: Floats
) -> Floats:
    """Transient errors (points - 1, modes) between points, without jumps of amplitudes."""
    before, after = stretches.around(time)
    moving = (np.diff(time) > 0.0) & (after[:-1] == before[1:]) & (after == before)[:-1]
    error = np.zeros((time.size - 1, len(excited.modes)))
    rate = np.diff(amplitude, axis=0)[moving] / np.diff(time)[moving, np.newaxis]
    estimate = TransientError.of(excited.reduced, excited.law)
    error[moving] = estimate.at(rate, excited.reduced.carrier, path[:-1][moving])
    return error


def _round_up(value: float) -> float:
    """Up to two significant digits, so that small changes of a scene share a table."""
    exponent = int(np.floor(np.log10(value))) - 1
    return float(f"{np.ceil(value / 10.0**exponent - 1e-9):g}e{exponent}")
