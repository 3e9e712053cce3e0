"""How finely to resolve the torus: steps and lines are doubled until the answer stays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import SMALLEST_SHARE, ErrorNorm
from slipmode.rom.contact.higher_order_harmonics import LINES
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.contact.torus.grid import Discretisation, step_counts
from slipmode.rom.error_budget import LARGEST_TOLERANCE, ErrorBudget, within_reach
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.reduction.nonresonant import frictionless_force
from slipmode.rom.representable import round_up
from slipmode.rom.short_repr import frozen

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
_LEAST_STEPS = 64
_LINES = (4, 8, 16, 32, 64, 128)
_TASKS = {1: 1, 2: 3}  # that the probes are split into, whatever the number of threads
# Of the frictionless S_j: of one mode where contacts begin to slip, without damping.
_LEAST_PART = 1e-3
_FINEST_MARCH = 1e-10  # rounding keeps motion from repeating more closely

# Applies a function to several arguments, one after the other or on threads: as `map`.
Mapped = Callable[..., Iterable[Any]]


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
        March tolerance, relative to the frictionless motion.
    """

    grid: Discretisation
    error: float
    march: float

    @property
    def finer(self) -> Resolution:
        """A smaller march tolerance, and more steps."""
        grid = replace(self.grid, steps=4 * self.grid.steps)
        return replace(self, grid=grid, march=max(0.1 * self.march, _FINEST_MARCH))


def trial_grid(problem: ContactProblem, tolerance: float) -> Discretisation:
    """Return about as many steps as a tolerance of S takes, and lines that hide no harmonic."""
    counts = step_counts(problem.reduced.carrier, _LEAST_STEPS)
    # of second order; 64 steps were enough for 1e-2
    steps = next((count for count in counts if count**2 * tolerance >= 40.0), counts[-1])
    if len(problem.reduced.modes) == 1:
        return Discretisation(steps, 1)
    return Discretisation(steps, max(LINES, _distinguishing_lines(problem)[0]))


def _distinguishing_lines(problem: ContactProblem) -> list[int]:
    """Return numbers of phase lines that distinguish all harmonics to which modes respond.

    Fewer would alias one harmonic m to another. Each is twice the one before.
    """
    highest = max(abs(m) for _, m in problem.orders)
    if problem.reduced.contacts is None:
        return [count for count in _LINES if count > 2 * highest]
    fewest = 4 * (highest // 2 + 1)
    return [fewest << k for k in range(((2 * _LINES[-1] - 1) // fewest).bit_length())]


class _UnresolvedError(Exception):
    """No number of steps or lines up to `count` suffices; that many would do for `tolerance`."""

    def __init__(self, count: int, tolerance: float) -> None:
        super().__init__()
        self.count = count
        self.tolerance = tolerance


@frozen
class _Trial:
    """S (points, modes) and T (points, combinations) on a grid, and the steps times lines marched.

    `repeats`: whether the motion repeats to the march tolerance at all points.
    """

    S: Complexes
    T: Complexes
    work: int
    repeats: bool


@frozen
class ResolutionSearch:
    """Search for the coarsest discretisation that meets a tolerance, at a few amplitudes.

    Attributes
    ----------
    problem : ContactProblem
    amplitude_range : (modes,) ndarray
        Largest amplitudes [kg^1/2 m].
    budget : ErrorBudget
    mapped : callable
    time_budget : TimeBudget
    is_optional : bool
        Whether there is a simpler problem for a table: without higher-order harmonics.
    """

    problem: ContactProblem
    amplitude_range: Floats
    budget: ErrorBudget
    mapped: Mapped
    time_budget: TimeBudget
    is_optional: bool = False
    _known: dict[tuple[int, int], _Trial] = field(default_factory=dict, init=False)

    def choose(self) -> Resolution:
        """Return the coarsest discretisation whose answer changes within its share when doubled.

        Raises
        ------
        SlipmodeError
            If the finest discretisation does not suffice; it names a tolerance that was tried. If
            the time budget is spent before one does.
        UnsettledError
            If contacts do not come to a periodic motion, or if the finest discretisation does not
            suffice for an optional problem.
        """
        try:
            return self._resolution()
        except _UnresolvedError as failure:
            if self.is_optional:
                raise UnsettledError(
                    "contacts: the modes' response to higher-order harmonics changes with the grid"
                ) from None
            raise SlipmodeError(
                f"tolerance: the contact problem needs more than {failure.count} steps or phase "
                f"lines per period; {self._advice(failure)}"
            ) from None

    def _advice(self, failure: _UnresolvedError) -> str:
        """Try larger tolerances: their marches converge less well, so none is certain to do."""
        tolerance = round_up(failure.tolerance)
        while tolerance <= LARGEST_TOLERANCE:
            try:
                replace(self, budget=ErrorBudget(tolerance))._resolution()
            except _UnresolvedError as again:
                tolerance = round_up(max(1.5 * tolerance, again.tolerance))
            else:
                break
        return within_reach(tolerance)

    def _resolution(self) -> Resolution:
        """Return what `choose` does, or raise `_UnresolvedError`."""
        reduced, budget = self.problem.reduced, self.budget
        rigid, counts = reduced.contacts is None, step_counts(reduced.carrier, _LEAST_STEPS)
        numbers, by_lines = [1], 0.0
        if len(reduced.modes) == 2:
            share = budget.steps if rigid else budget.closed_lines
            enough = _distinguishing_lines(self.problem)
            grids = [Discretisation(counts[0], lines) for lines in enough]
            if self.is_optional:
                # On few lines, motion with higher-order harmonics may not repeat
                # (test_of_elastic_contacts). The lines on which the harmonics were found stay.
                grids = [grid for grid in grids if grid.lines >= LINES or self._repeats(grid)]
            found, by_lines = self._coarsest(grids, share)
            numbers = [grid.lines for grid in found]
        left = min(budget.steps, budget.resolution - by_lines)
        (grid, *_), by_steps = self._coarsest(
            [Discretisation(steps, numbers[0]) for steps in counts], left
        )
        if not rigid:  # on so many steps fewer lines may take less work
            grids = [replace(grid, lines=lines) for lines in numbers]
            grid = min(grids, key=lambda each: self._solved(each).work)
        S, points = self._solved(grid).S, self._points
        free = frictionless_force(reduced)
        moved = free > 0.0
        part = (self._norm.known(S).scale(points, S) / points)[:, moved] / free[moved]
        least = float(part.min(initial=1.0))
        if reduced.ratio:  # the motion by the stronger mode drives the weaker one
            by_mode = np.linalg.norm(reduced.coupling, axis=1) * self.amplitude_range
            least *= float(by_mode.min() / by_mode.max())
        march = max(budget.march * least, _FINEST_MARCH)
        return Resolution(grid, by_steps + by_lines, march)

    @cached_property
    def _norm(self) -> ErrorNorm:
        return ErrorNorm.of(self.problem.reduced, self.amplitude_range)

    @cached_property
    def _points(self) -> Floats:
        """Amplitudes (points, modes) at which resolution is tried."""
        ends = self.amplitude_range
        points = _PROBES[ends.size] * ends
        onset = onset_lines(self.problem.reduced, self.problem.law)
        if ends.size == 1 and onset.size:
            past = _PAST_ONSET[:, np.newaxis] / onset.max()
            inside = points.min() <= past[0, 0] and past[-1, 0] <= ends[0]
            points = np.concatenate((points, past)) if inside else points
        return np.asarray(points)

    @cached_property
    def _march_tolerance(self) -> float:
        """Marches repeat relative to the frictionless motion; S_j may be a small part of that."""
        reduced = self.problem.reduced
        free, least = frictionless_force(reduced), 1.0
        if len(reduced.modes) == 1 and (free > 0.0).all():
            least = float(np.clip(self._norm.loss[0] / free[0], _LEAST_PART, 1.0))
        return max(self.budget.trial_march * least, _FINEST_MARCH)

    def _solved(self, grid: Discretisation) -> _Trial:
        key = grid.steps, grid.lines
        if key not in self._known:
            self._known[key] = self._solve(grid)
        return self._known[key]

    def _repeats(self, grid: Discretisation) -> bool:
        try:
            return self._solved(grid).repeats
        except UnsettledError:
            return False

    def _solve(self, grid: Discretisation) -> _Trial:
        tolerance, modes = self._march_tolerance, self.amplitude_range.size
        torus = self.problem.on(grid, tolerance, _TRIED_SCALE[modes] * self.amplitude_range)
        parts = list(self.mapped(torus.solve, np.array_split(self._points, _TASKS[modes])))
        for part in parts:
            part.check_periodic()
        work = grid.lines * sum(int(part.marched.sum()) for part in parts)
        S, T = (np.concatenate([getattr(part, name) for part in parts]) for name in "ST")
        repeats = all(part.residual.max() <= tolerance for part in parts)
        return _Trial(S, T, work, repeats)

    def _change(self, coarse: _Trial, fine: _Trial) -> float:
        """Return the largest error of the coarse trial relative to the fine one."""
        modes, combinations = self.amplitude_range.size, self.problem.combinations
        driven = [*range(modes), *(term.mode for term in combinations)]
        scale = self._norm.known(fine.S).scale(self._points, fine.S)[:, driven]
        difference = np.abs(np.hstack((fine.S - coarse.S, fine.T - coarse.T)))
        return float((difference / scale).max())

    def _coarsest(
        self, grids: Sequence[Discretisation], allowed: float
    ) -> tuple[list[Discretisation], float]:
        """Return the first grid whose answer the next one changes within `allowed`; the change.

        With it the next two grids, the least work first: on coarse grids marches may not
        converge. The second is tried only where the first was less work already. An optional
        problem is given up where the motion does not repeat.
        """
        changes: list[float] = []
        for k, (grid, finer) in enumerate(pairwise(grids)):
            if changes and self.time_budget.spent:
                reached = round_up(min(changes) / allowed * self.budget.tolerance)
                raise SlipmodeError(
                    f"budget: the contact problem needs more than {_count(grids, grid)} steps or "
                    "phase lines per period, and the budget of "
                    f"{self.time_budget.seconds:g} s is spent; with these " + within_reach(reached)
                )
            coarse = self._solved(grid)
            if self.is_optional and not coarse.repeats:
                break
            fine = self._solved(finer)
            changes.append(self._change(coarse, fine))
            if changes[-1] <= allowed:
                tried = [grid, finer]
                if fine.work < coarse.work:
                    tried += grids[k + 2 : k + 3]
                return sorted(tried, key=lambda each: self._solved(each).work), changes[-1]
        reached = min(changes, default=np.inf) / allowed * self.budget.tolerance
        raise _UnresolvedError(_count(grids, grids[-2]), reached)


def _count(grids: Sequence[Discretisation], grid: Discretisation) -> int:
    """Return the steps or the lines of a grid, whichever the grids differ in."""
    return grid.lines if grids[0].steps == grids[-1].steps else grid.steps
