"""The amplitude range of a scene, from a dry run on a coarse table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from slipmode.fmu.inputs import rate_of
from slipmode.rom import Model, SlipmodeError
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.representable import round_up
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.transient import TransientError, friction_threshold
from slipmode.runner.plan.excited import Excited, Path
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.wear import worn
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import Schedule


@frozen
class DryRun:
    """Results of a run on a coarse table."""

    # (modes,): The largest effective amplitudes at the contacts, relative to the scale of the
    # friction limits at their time [kg^1/2 m]
    reached: Floats
    inside: bool  # Whether the run stayed inside the table
    # (modes,): |Q_j| / omega_j^2 at the largest amplitudes: the share of a mode's stiffness due to
    # contacts
    contact_share: Floats
    time: Floats  # (points,): Points of the run, in the time of the scene [s]
    # (points - 1, modes): `TransientError` between the points, relative to the scale like
    # `reached` [kg^1/2 m]
    transient_error: Floats


def dry_run(plan: ModesPlan, progress: bool) -> tuple[tuple[float, ...], DryRun]:
    """Run a scene on a coarse table, whose range is doubled until the run stays inside.

    Returns the range (modes,) that the friction table needs [kg^1/2 m], and the run. If contacts
    do not settle at amplitudes of the first guess, which the run need not reach, the range is
    halved instead. Raises SlipmodeError if the amplitudes grow without bound, a step cannot be
    taken on any table, or contacts do not settle at amplitudes that the run reaches.
    """
    excited, schedule = plan.excited, plan.schedule
    tried = _first_guess(excited, schedule)
    smallest = np.maximum(tried / 8.0, np.abs(excited.amplitude))  # half the onset of slip
    self_excited = excited.reduced.modal_damping < 0.0
    # self-excited contacts slip freely at 2^8 times the first guess, and take no more energy
    largest = np.where(self_excited, 2.0**8, 2.0**40) * tried
    unsettled: UnsettledError | None = None
    while True:
        try:
            coarse, _ = excited.model(
                tried.tolist(),
                0.05,  # the error in amplitude is well inside the margin
                combinations=plan.combinations,
                detuning=False,
                progress=progress,
            )
        except UnsettledError as refusal:
            if np.any(0.5 * tried < smallest):
                raise
            unsettled, tried = refusal, 0.5 * tried
            continue
        seen = run_on(excited, worn(excited, schedule, coarse, plan.scene), coarse)
        if seen.inside:
            break
        if unsettled is not None:
            raise unsettled
        tried = np.where(seen.reached > 0.5 * tried, 2.0 * tried, tried)
        if np.any(tried > largest):
            raise _unbounded(excited)
    # a self-excited mode that stays at rest may be started by an importer of its FMU
    rests = (seen.reached == 0.0) & self_excited
    least = np.maximum(1.15 * seen.reached, np.where(rests, 1.0, 1e-2) * tried)
    # two digits: small changes of a scene share a table
    return tuple(round_up(float(value)) for value in least), seen


def run_on(excited: Excited, schedule: Schedule, model: Model) -> DryRun:
    """Run a schedule on the table of a model."""
    short, ends = shortened(schedule, model, excited.modes), model.table.amplitude_range
    # steps are then short enough to show peaks and changes within a cycle
    path = excited.follow(model, short, 5e-10)
    effective, error = along_run(excited, model, short, path)
    reached: Floats = effective.max(axis=0)
    # close to the edge of the table a run may find no step that stays inside
    near = bool(np.any(reached > 0.9 * ends))
    if path.stop is not None and not (path.stop.left_table or near):
        raise SlipmodeError(f"run: {path.stop}")
    if path.stop is not None and not np.any(reached > 0.5 * ends):
        reached = ends  # it left within one step, in an unknown direction
    within = np.minimum(reached, ends)
    share = np.abs(model.table(within)) / np.where(within > 0, within, 1.0)
    share /= excited.reduced.frequency**2
    return DryRun(reached, path.stop is None, share, _in_scene(path.time, short, schedule), error)


def _unbounded(excited: Excited) -> SlipmodeError:
    """Return the refusal of a scene whose amplitudes grow without bound."""
    for mode, damping in zip(excited.modes, excited.reduced.modal_damping, strict=True):
        if damping < 0.0:
            return SlipmodeError(
                f"aerodynamics.{mode}: friction does not limit mode {mode}, which grows without "
                "bound; reduce the excitation, increase structure.damping, or give "
                "model.amplitude, at which the run ends"
            )
    return SlipmodeError(
        "forcing: the amplitudes grow without bound; give structure.damping a value > 0"
    )


def _first_guess(excited: Excited, schedule: Schedule) -> Floats:
    """Return four times the amplitude at which the first contact slips, or opens, (modes,).

    It is at least the quasi-static response to the forces, which amplitudes do not stay far below.
    """
    first = friction_threshold(*excited.contacts)
    frequency = np.maximum(excited.reduced.frequency, excited.reduced.carrier)
    scripted = schedule.extremes([f"force_{mode}" for mode in excited.modes])
    force = np.abs(excited.modal_force) * np.abs(scripted).max(axis=0)
    static = np.maximum(0.5 * force / frequency**2, 1.5 * np.abs(excited.amplitude))
    return np.asarray(np.maximum(np.where(np.isfinite(first), 4.0 * first, 0.0), static))


def along_run(
    excited: Excited, model: Model, schedule: Schedule, path: Path
) -> tuple[Floats, Floats]:
    """Return effective amplitudes and transient errors along a run [kg^1/2 m].

    Effective amplitudes (points, modes) are divided by the scale of the limits, and so are the
    errors (points - 1, modes), estimated between the points.
    At a jump of inputs the larger effective amplitude counts, and the smaller scale. A jump of
    amplitudes is no error.
    """
    time = schedule.at_breaks(path.time)
    sides = [
        excited.loads(partial(schedule.around, times=time, after=after)) for after in (False, True)
    ]
    scale = np.minimum(*(loads.scale for loads in sides))
    shift = AppliedForces.of(model.reduced, excited.force_patterns).shift
    effective = (
        np.maximum(*(np.abs(path.amplitude + shift * each.force) for each in sides)) / scale
    )
    moving = (np.diff(path.time) > 0.0) & ~np.isin(time[:-1], schedule.breaks[1:])
    error = np.zeros((time.size - 1, len(excited.modes)))
    rate = np.diff(path.amplitude / scale, axis=0)[moving]
    rate /= np.diff(path.time)[moving, np.newaxis]
    estimate = TransientError.of(*excited.contacts)
    error[moving] = estimate.at(rate, excited.reduced.carrier, effective[:-1][moving])
    return effective, error


def shortened(schedule: Schedule, model: Model, modes: Sequence[Mode]) -> Schedule:
    """Return the stretches of a schedule, none longer than its motion changes.

    A ramp that is shortened goes as far as before, but faster.
    """
    straight = schedule.stretches()
    longest = _settling_time(straight, model, modes)
    return straight.retimed(np.minimum(straight.durations(), longest))


def _in_scene(time: Floats, short: Schedule, schedule: Schedule) -> Floats:
    """Return the times in a schedule (n,) [s] of times in its `shortened` stretches.

    Ramps are slower there by the factor of their duration; constant inputs last longer.
    """
    straight = schedule.stretches()
    ramps = straight.inputs([rate_of(name) for name in straight.scripts]).any(axis=1)
    starts, ends = schedule.breaks[:-1], schedule.breaks[1:]
    ends = np.where(ramps, ends, starts + np.diff(short.breaks))
    edges = np.repeat(short.breaks, 2)[1:-1]
    return np.interp(short.at_breaks(time), edges, np.column_stack((starts, ends)).ravel())


def _settling_time(straight: Schedule, model: Model, modes: Sequence[Mode]) -> Floats:
    """Return how long the motion of each stretch changes at most, (stretches,) [s].

    Friction takes energy out of the difference of any two motions, so that the influence of a
    breakpoint decays at least as fast as the damping of the modes. Many decay times later,
    constant inputs only produce beats, which repeat. Inputs that are slow compared with the decay
    may as well move faster: the amplitudes are steady all along.
    """
    damping = model.reduced.modal_damping.min()
    if damping <= 0.0:
        return np.full(straight.steps, np.inf)
    decay = 2.0 / damping
    frequencies, phases = ([f"{name}_{m}" for m in modes] for name in ("frequency", "phase"))
    start, end = straight.inputs(frequencies), straight.at_ends(frequencies)
    moved = np.abs(end - start).max(axis=1)
    turned = np.abs(straight.at_ends(phases) - straight.inputs(phases)).max(axis=1)
    longest = np.zeros(straight.steps)
    for term in model.combinations:
        beat = np.maximum(*(np.abs(f @ (term.n, term.m) - f[:, term.mode]) for f in (start, end)))
        turns = beat * straight.durations() > 1e-2  # [rad], below which a beat has no influence
        period = 2.0 * np.pi / np.where(turns, beat, np.inf)
        longest = np.maximum(longest, 3.0 * period)
    # 50 decay times, and as many for each width of a peak that a frequency moves: ramps lag by a
    # fiftieth of their height (tests/runner/plan/test_plan.py)
    return np.asarray(50.0 * decay * (1.0 + moved * decay + turned) + longest)
