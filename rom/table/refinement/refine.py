"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Cells between grid lines are halved until the expected error is within the tolerance. The expected
error follows from the errors at new samples in the last two halvings, see `Grid.halved`.
Neighbours of marked cells are halved too. Every sample becomes a node. Points that are no nodes
measure the error of the finished table, see check_points.py; cells where it is too large are
halved again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.error_budget import LARGEST_TOLERANCE, within_reach
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import round_up
from slipmode.rom.table.check_points import (
    AROUND,
    at_cells,
    first_onsets,
    indicated_points,
    largest_error,
    onset_points,
    places_around,
    points_beside,
    spread_points,
)
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.refinement.blocks import Blocks
from slipmode.rom.table.refinement.grid import Grid
from slipmode.rom.table.refinement.node_samples import NodeSamples
from slipmode.rom.table.refinement.sampling import Sampling, amplitude_pairs

_FIRST_INTERVALS = {1: 8, 2: 4}  # by modes
_MAX_ROUNDS = 40
_RINGS = 8  # of neighbouring blocks around large errors that are checked at once
_LEAST_SHARE = 1 / 4  # of the larger indicator of a cell: an axis with less is not halved
_MOST_SAMPLES = {1: 600, 2: 20_000}  # by modes
# Distance of nodes over amplitude and tolerance: closer nodes differ by the error of samples.
# Kinks and thresholds needed 1/2.
_CLOSEST = 1 / 100
# Successive rounds in which the error does not decrease to `_LESS` of the least: samples jump, or
# are not as exact as they should be.
_STAGNANT_ROUNDS = 8
_LESS = 0.8
# Of the tolerance: smaller errors are not refined further, and the true error was up to 1.51 times
# the first estimate (tests/rom/table/test_stated_error.py).
_LEAST_STATED = 0.5
_SLACK = 1.5  # of the tolerance that is advised: its grid lines differ


class _Checks:
    """Samples that are no nodes, and the errors of tables there.

    `gain` is the ratio of the largest error after points around it were checked to the one before.
    Errors in other blocks, around which no points were checked, would grow by about as much.
    """

    def __init__(self, sampling: Sampling, points: Floats, exact: Complexes) -> None:
        self._sampling = sampling
        self.gain = 1.0
        self.points, self._exact = points, exact

    def _add(self, points: Floats) -> None:
        """Add points and samples there.

        The initial guess of a solve is the solution at the point before: where contacts have two
        motions, solves from far away converge to another one. The table is no initial guess, since
        checks are to find a motion that it does not have.
        """
        if not len(points):
            return
        points = _in_order(points)
        self.points = np.concatenate((self.points, points))
        self._exact = np.concatenate((self._exact, self._sampling.at(points, None)))

    def errors(self, table: Table, indicators: Floats, grid: Grid, tolerance: float) -> Floats:
        """Add the points that the table needs; return the relative errors at all points."""
        sampling, axes = self._sampling, table.axes
        norm = sampling.norm(table)
        indicator = np.maximum(at_cells(indicators.max(axis=0)), grid.left.max(axis=0))
        blocks = Blocks.of(axes, grid.block, indicator)

        def add(points: Floats) -> tuple[Floats, NDArray[np.int64]]:
            """Add points; return the errors at all points, and their blocks."""
            self._add(points)
            errors = sampling.error_of(self.points, table.terms(self.points), self._exact, norm)
            return errors, grid.block[grid.cells(self.points)]

        onset = onset_points(blocks, sampling.onset_lines, self.points)
        checked = np.concatenate((self.points, onset))
        indicated = indicated_points(blocks, sampling.onset_lines, checked)
        errors, holding = add(np.concatenate((onset, indicated)))
        # Large errors cluster: the estimates in neighbouring blocks were as wrong.
        for _ in range(_RINGS):
            bad = holding[errors > self.limit(errors, tolerance)]
            if not bad.size or not len(beside := points_beside(blocks, bad, self.points)):
                break
            errors, holding = add(beside)
        first = errors.max()
        for share in AROUND:
            errors, holding = add(places_around(blocks, holding, self.points, errors, share))
        self.gain = float(errors.max() / first) if first > 0.0 else 1.0
        return errors

    def limit(self, errors: Floats, tolerance: float) -> float:
        """Return the largest error at check points for which `largest_error` is the tolerance."""
        worst = float(errors.max())
        return tolerance * worst / max(largest_error(errors, self._sampling.noise), tolerance)


def refine(
    sampling: Sampling, tolerance: float, time_budget: TimeBudget
) -> tuple[Table, Complexes | None, float]:
    """Tabulate to a tolerance relative to the largest |S_j| up to the amplitude range.

    Parameters
    ----------
    sampling : Sampling
    tolerance : float
    time_budget : TimeBudget

    Returns
    -------
    table : Table
    carried : (n_a, n_b, carried) complex ndarray, optional
        The columns that are not tabulated, at the nodes, if they are kept.
    error : float
        Largest difference between the nodes, relative to the largest |S_j|: `largest_error`, or
        half the tolerance if that is less. Above the tolerance where samples jump or are not
        exact, so that more nodes would not help.

    Raises
    ------
    SlipmodeError
        If it takes too many nodes, or too long.
    """
    grid, samples, checks = _begun(sampling, tolerance)
    grid, samples, table, error = _refined(sampling, grid, samples, checks, tolerance, time_budget)
    carried = samples.carried if sampling.columns.kept else None
    return table, carried, max(error, _LEAST_STATED * tolerance)


def _begun(sampling: Sampling, tolerance: float) -> tuple[Grid, NodeSamples, _Checks]:
    """Return the first grid, its samples and spread check points, which are sampled at once."""
    ends = sampling.amplitude_range
    onsets = first_onsets(sampling.onset_lines, ends)
    spread = _in_order(np.concatenate((spread_points(ends), onsets)))
    grid = Grid.upto(ends, _FIRST_INTERVALS[ends.size], _CLOSEST * tolerance)
    nodes, tabulated = amplitude_pairs(*grid.nodes, grid.modes), len(sampling.columns.orders)
    if grid.modes == 2:
        exact = sampling.at(nodes, None).reshape(*grid.sampled.shape, -1)
        samples = NodeSamples.of(exact, tabulated)
        return grid, samples, _Checks(sampling, spread, sampling.at(spread, None))
    middles = grid.middles(0)[:, np.newaxis]  # sampled next in any case
    points = np.concatenate((nodes, middles, spread))
    order = np.argsort(points[:, 0], kind="stable")
    exact = sampling.at(points[order], None)[np.argsort(order)]
    of_nodes, of_middles, of_spread = np.split(exact, np.cumsum([len(nodes), len(middles)]))
    checks = _Checks(sampling, spread, of_spread)
    samples = NodeSamples.of(of_nodes[:, np.newaxis], tabulated)
    return *_halve(sampling, grid, samples, None, 0, tolerance, of_middles), checks


def _refined(
    sampling: Sampling,
    grid: Grid,
    samples: NodeSamples,
    checks: _Checks,
    tolerance: float,
    time_budget: TimeBudget,
) -> tuple[Grid, NodeSamples, Table, float]:
    """Halve cells until samples and check points agree with the table to the tolerance.

    Or until that does not help: samples jump, or are not as exact as they are meant to be.
    """
    table: Table | None = None
    least, stagnant = np.inf, 0.0
    for _ in range(_MAX_ROUNDS):
        if grid.sampled.sum() > _MOST_SAMPLES[grid.modes] or time_budget.spent:
            break
        for mode in range(grid.modes):
            if grid.marked[mode].any():
                grid, samples = _halve(sampling, grid, samples, table, mode, tolerance)
                table = None
        if grid.marked.any():
            continue
        table = sampling.table(grid.nodes, samples.tabulated)
        indicators = sampling.indicators(table)
        errors = checks.errors(table, indicators, grid, tolerance)
        error = largest_error(errors, sampling.noise)
        # If only the extrapolated error is too large, it decreases with every round.
        waste = 1.0 if errors.max() > tolerance else 0.5
        stagnant = 0.0 if error < _LESS * least else stagnant + waste
        least = min(least, error)
        if error <= tolerance or stagnant >= _STAGNANT_ROUNDS:
            return grid, samples, table, error
        # The largest error may be close to any point whose error is nearly the largest.
        missed = checks.points[errors > checks.limit(errors, tolerance) / checks.gain]
        grid = grid.marked_at(missed, indicators, _LEAST_SHARE)
        if not grid.marked.any():
            return grid, samples, table, error
    table = sampling.table(grid.nodes, samples.tabulated)
    errors = checks.errors(table, sampling.indicators(table), grid, tolerance)
    error = largest_error(errors, sampling.noise)
    many = grid.modes == 2 and grid.sampled.sum() > _MOST_SAMPLES[2]
    if error <= LARGEST_TOLERANCE and not many and not time_budget.spent:
        return grid, samples, table, error  # samples jump: more nodes would not help
    reached = round_up(_SLACK * max(error, tolerance))
    nodes = "{} x {} nodes".format(*samples.row.shape)
    if time_budget.spent:
        raise SlipmodeError(
            f"budget: a friction table to {tolerance:g} takes longer than {time_budget.seconds:g} "
            f"s; with the {nodes} that it has by then {within_reach(reached)}"
        )
    raise SlipmodeError(
        f"tolerance: a friction table to {tolerance:g} needs more than {nodes}; with these "
        + within_reach(reached)
    )


def _in_order(points: Floats) -> Floats:
    return np.asarray(points[np.lexsort(points.T[::-1])])


def _halve(
    sampling: Sampling,
    grid: Grid,
    samples: NodeSamples,
    table: Table | None,
    mode: int,
    tolerance: float,
    known: Complexes | None = None,
) -> tuple[Grid, NodeSamples]:
    """Halve the marked cells along one axis; `known` are samples at their middles.

    `table` is the one through the samples, if it is known.
    """
    unsampled = grid.unsampled(mode)
    if unsampled.any():
        near = samples.rows[samples.row[unsampled]]
        samples = _sampled_at(sampling, grid, samples, unsampled, near)
        grid, table = replace(grid, sampled=grid.sampled | unsampled), None
    order = grid.order(mode)
    points = amplitude_pairs(*grid.with_nodes(mode, grid.middles(mode)), grid.modes)
    table = table or sampling.table(grid.nodes, samples.tabulated)
    new = order >= grid.nodes[mode].size
    taken = grid.wanted(mode)
    surface = table.terms(points).reshape(*taken.shape, -1)
    # Nodes without samples have the values of the surface.
    lines, near = samples.middles(grid, mode, surface, taken, smooth=sampling.columns.kept)
    if known is None and taken.any():
        known = sampling.at(points[taken.ravel()], near)
    if known is not None:
        lines = lines.taken(taken, known)
    places = points.reshape(*taken.shape, -1)
    error = sampling.error_of(places, surface, lines.tabulated, sampling.norm(table))
    finer = grid.halved(mode, taken, np.where(taken, error, 0.0), tolerance)
    return finer, samples.with_lines(mode, new, lines)


def _sampled_at(
    sampling: Sampling, grid: Grid, samples: NodeSamples, nodes: Flags, near: Complexes | None
) -> NodeSamples:
    """Return the samples with those at some nodes of the grid; `near` are initial guesses."""
    points = amplitude_pairs(*grid.nodes, grid.modes)[nodes.ravel()]
    return samples.taken(nodes, sampling.at(points, near))
