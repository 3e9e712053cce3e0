"""How finely to resolve the torus: steps and lines by doubling, until the answer stays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import SMALLEST_SHARE, ErrorNorm, frictionless_force
from slipmode.rom.contact.friction_terms import ContactTerms, contact_orders, contact_terms
from slipmode.rom.contact.further_harmonics import LINES
from slipmode.rom.contact.settled import check_settled
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.contact.torus.grid import Discretisation, step_counts
from slipmode.rom.error_budget import LARGEST_TOLERANCE, ErrorBudget, within_reach
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CombinationResonance, Order
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.representable import round_up

# Fractions of the largest amplitudes at which resolution is tried. One mode: down to small ones.
# Two: both strong, each strong over a weak one, and both near the slip threshold.
_PROBES = {
    1: np.array([[1.0], [0.6], [0.35], [0.2], [0.1], [0.03], [0.01], [0.003]]),
    2: np.array([[1.0, 1.0], [1.0, 0.3], [0.3, 1.0], [0.6, 0.6], [0.35, 0.35], [0.25, 0.1]]),
}
# Of the amplitude at which the first contact begins to slip: for a fraction of a step there.
_PAST_ONSET = np.array([1.006, 1.03])
# Of the range: marches of trials repeat relative to these amplitudes at least.
_TRIED_SCALE = {1: SMALLEST_SHARE, 2: 1.0}
_LEAST_STEPS = 32
_STEPS = 40.0  # squared, times a tolerance: of second order, 64 were seen to do for 1e-2
_LINES = (4, 8, 16, 32, 64, 128)
_TASKS = {1: 1, 2: 3}  # that the probes are split into; fixed, whatever the number of threads
_LEAST_PART = (
    1e-3  # of the frictionless S_j: of one mode where contacts begin to slip, without damping
)
_CLOSER, _MORE_STEPS = 0.1, 4
_FINEST_MARCH = 1e-10  # nearer than this rounding keeps motion from repeating
_MOST_LINES = 8  # times those of the grid, where the motion does not settle on it


# Of a function and what it is called with, one after the other or on threads: as `map`.
Mapped = Callable[..., Iterable[Any]]


@dataclass(frozen=True, eq=False)
class _Trial:
    """S (points, modes) and T (points, combinations) on a grid; the steps times lines they took.

    And whether the motion repeats at all points.
    """

    S: Complexes
    T: Complexes
    work: int
    repeats: bool


@dataclass(frozen=True)
class Resolution:
    """A discretisation and the error it was measured to have.

    Attributes
    ----------
    grid : Discretisation
    error : float
        Change of S, and of the T of combination resonances, on doubling steps and on doubling
        lines, in terms of `ErrorNorm`.
    march : float
        How well marches have to repeat, relative to the frictionless motion.
    """

    grid: Discretisation
    error: float
    march: float

    @property
    def closer(self) -> Resolution:
        """With marches that go on for longer, in more steps."""
        grid = replace(self.grid, steps=_MORE_STEPS * self.grid.steps)
        return replace(self, grid=grid, march=max(_CLOSER * self.march, _FINEST_MARCH))


def choose_resolution(
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    budget: ErrorBudget,
    combinations: Sequence[CombinationResonance],
    mapped: Mapped,
    time_budget: TimeBudget,
    further: Sequence[Order] = (),
) -> Resolution:
    """Coarsest discretisation whose answer changes by no more than its share when doubled.

    `further` are harmonics that modes respond to beside those of contact_orders, as far as phase
    lines tell them apart: what more lines change has what fewer hide.

    Raises
    ------
    SlipmodeError
        If the finest discretisation does not suffice; it names a tolerance that was tried. If the
        time budget is spent before one does.
    UnsettledError
        If contacts do not come to a periodic motion, or not with further harmonics.
    """
    known = reduced, law, amplitude_range, combinations, further, mapped, time_budget
    resolve = partial(_resolution, *known)
    try:
        return resolve(budget)
    except _UnresolvedError as failure:
        if further:
            raise UnsettledError(
                "contacts: the modes' response to further harmonics changes with the grid"
            ) from None
        advice = _advice(resolve, failure)
        raise SlipmodeError(
            f"tolerance: the contact problem needs more than {failure.count} steps or phase lines "
            f"per period; {advice}"
        ) from None


def trial_grid(
    reduced: Reduced, combinations: Sequence[CombinationResonance], tolerance: float
) -> Discretisation:
    """About as many steps as a tolerance of S takes, and lines that hide no harmonic."""
    counts = step_counts(reduced.carrier, _LEAST_STEPS)
    steps = next((count for count in counts if count**2 * tolerance >= _STEPS), counts[-1])
    if len(reduced.modes) == 1:
        return Discretisation(steps, 1)
    return Discretisation(steps, max(LINES, _enough_lines(reduced, combinations)[0]))


def resolved_terms(
    reduced: Reduced,
    law: Friction,
    resolution: Resolution,
    amplitudes: Floats,
    smallest_scale: Floats,
    combinations: Sequence[CombinationResonance],
    highest: int,
    further: Sequence[Order] = (),
    near: Complexes | None = None,
) -> ContactTerms:
    """See contact_terms; with more phase lines where the motion does not repeat on the grid.

    Lines of rigid contacts drift against the grid. Where a contact slips on few of them, its
    harmonics keep moving by the error of the grid, at some amplitudes and not at the next.
    """

    def solve(points: Floats, grid: Discretisation, near: Complexes | None = None) -> ContactTerms:
        return contact_terms(
            *(reduced, law, points, grid, resolution.march, smallest_scale, combinations),
            *(highest, further, near),
        )

    grid = resolution.grid
    terms = solve(amplitudes, grid, near)
    drifts = reduced.contacts is None and len(reduced.modes) == 2
    while drifts and grid.lines < _MOST_LINES * resolution.grid.lines:
        (moving,) = np.nonzero(terms.residual > resolution.march)
        if not moving.size:
            break
        grid = replace(grid, lines=2 * grid.lines)
        terms.take(moving, solve(amplitudes[moving], grid))
    return terms


class _UnresolvedError(Exception):
    """Of so many steps or lines no number sufficed; what tolerance they would do for."""

    def __init__(self, count: int, tolerance: float) -> None:
        super().__init__()
        self.count = count
        self.tolerance = tolerance


def _advice(resolve: Callable[[ErrorBudget], Resolution], failure: _UnresolvedError) -> str:
    """Marches to a coarser tolerance settle less well, so one that would do has to be tried."""
    tolerance = round_up(failure.tolerance)
    while tolerance <= LARGEST_TOLERANCE:
        try:
            resolve(ErrorBudget(tolerance))
        except _UnresolvedError as again:
            tolerance = round_up(max(1.5 * tolerance, again.tolerance))
        else:
            break
    return within_reach(tolerance)


def _resolution(
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    combinations: Sequence[CombinationResonance],
    further: Sequence[Order],
    mapped: Mapped,
    time_budget: TimeBudget,
    budget: ErrorBudget,
) -> Resolution:
    """As choose_resolution, but for the advice."""
    modes = amplitude_range.size
    points, norm = _probes(reduced, law, amplitude_range), ErrorNorm.of(reduced, amplitude_range)
    # marches repeat to a tolerance of the frictionless motion, of which S_j may be a small part
    free = frictionless_force(reduced)
    moved = free > 0.0
    least = 1.0
    if modes == 1 and moved.all():
        least = float(np.clip(norm.loss[0] / free[0], _LEAST_PART, 1.0))
    trial_march = max(budget.trial_march * least, _FINEST_MARCH)

    @cache
    def solve(steps: int, lines: int) -> _Trial:
        grid = Discretisation(steps, lines)

        def terms(part: Floats) -> ContactTerms:
            return contact_terms(
                *(reduced, law, part, grid, trial_march),
                *(_TRIED_SCALE[modes] * amplitude_range, combinations),
                further=further,
            )

        parts = list(mapped(terms, np.array_split(points, _TASKS[modes])))
        for part in parts:
            check_settled(reduced, combinations, part)
        work = lines * sum(int(part.marched.sum()) for part in parts)
        S, T = (np.concatenate([getattr(part, name) for part in parts]) for name in "ST")
        repeats = all(part.residual.max() <= trial_march for part in parts)
        return _Trial(S, T, work, repeats)

    driven = [*range(modes), *(term.mode for term in combinations)]

    def change(coarse: _Trial, fine: _Trial) -> float:
        scale = norm.known(fine.S).scale(points, fine.S)[:, driven]
        apart = np.abs(np.hstack((fine.S - coarse.S, fine.T - coarse.T)))
        return float((apart / scale).max())

    settled = partial(
        _settled,
        change=change,
        tolerance=budget.tolerance,
        time_budget=time_budget,
        finest=not further,
    )
    rigid, counts = reduced.contacts is None, step_counts(reduced.carrier, _LEAST_STEPS)
    numbers, by_lines = [1], 0.0
    if modes == 2:
        enough = _enough_lines(reduced, combinations)
        share = budget.steps if rigid else budget.closed_lines
        numbers, by_lines = settled(enough, lambda number: solve(counts[1], number), share)
    left = min(budget.steps, budget.resolution - by_lines)
    (steps, *_), by_steps = settled(counts, lambda count: solve(count, numbers[0]), left)
    lines = numbers[0]
    if not rigid:  # in so many steps fewer may take less work
        lines = min(numbers, key=lambda number: solve(steps, number).work)
    S = solve(steps, lines).S
    part = (norm.known(S).scale(points, S) / points)[:, moved] / free[moved]
    of_free = part.min(initial=1.0)
    march = max(budget.march * float(of_free), _FINEST_MARCH)
    return Resolution(Discretisation(steps, lines), by_steps + by_lines, march)


def _probes(reduced: Reduced, law: Friction, amplitude_range: Floats) -> Floats:
    """Amplitudes (points, modes) at which resolution is tried."""
    points = _PROBES[amplitude_range.size] * amplitude_range
    onset = onset_lines(reduced, law)
    if amplitude_range.size == 1 and onset.size:
        past = _PAST_ONSET[:, np.newaxis] / onset.max()
        inside = points.min() <= past[0, 0] and past[-1, 0] <= amplitude_range[0]
        points = np.concatenate((points, past)) if inside else points
    return np.asarray(points)


def _enough_lines(reduced: Reduced, combinations: Sequence[CombinationResonance]) -> list[int]:
    """Numbers of phase lines to try.

    Fewer would take one harmonic m for another, and the modes always respond to both.
    """
    highest = max(abs(m) for _, m in contact_orders(reduced, combinations))
    return [count for count in _LINES if count > 2 * highest]


def _settled(
    counts: Sequence[int],
    solve: Callable[[int], _Trial],
    allowed: float,
    *,
    change: Callable[[_Trial, _Trial], float],
    tolerance: float,
    time_budget: TimeBudget,
    finest: bool,
) -> tuple[list[int], float]:
    """The first count whose answer the next one changes by no more than is allowed; the change.

    And with it the next two, the least work first: on coarse grids marches may not settle. The
    second is tried only where the first was less work already. Where the motion repeats on neither
    of two grids the `finest` are only tried if that is wanted.
    """
    changes: list[float] = []
    for k, (count, finer) in enumerate(pairwise(counts)):
        if changes and time_budget.spent:
            reached = round_up(min(changes) / allowed * tolerance)
            raise SlipmodeError(
                f"budget: the contact problem takes more than {count} steps or phase lines per "
                f"period, and longer than {time_budget.seconds:g} s to find how many; with these "
                + within_reach(reached)
            )
        changes.append(change(solve(count), solve(finer)))
        if changes[-1] <= allowed:
            tried = [count, finer]
            if solve(finer).work < solve(count).work:
                tried += counts[k + 2 : k + 3]
            return sorted(tried, key=lambda each: solve(each).work), changes[-1]
        if not (finest or solve(count).repeats or solve(finer).repeats):
            break
    raise _UnresolvedError(counts[-2], min(changes) / allowed * tolerance)
