"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Cells between grid lines are halved until the surface can be expected to be within the
tolerance: what it missed new samples by falls with this halving at least half as well as with the
last one, and nowhere is it trusted to fall below half. Those next to a poor one are halved too.
Every sample becomes a node; points that are no nodes measure the error of the finished table, see
check_points.py, and cells where it is too large are halved again.
"""

from __future__ import annotations

from collections.abc import Iterator
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
    doubtful_points,
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
_RINGS = 8  # of blocks around those of large errors that are checked at once
_LESS_IN_DOUBT = 1 / 4  # of the largest doubt in a cell: an axis that has less is left alone
_MOST_NODES = {1: 600, 2: 60_000}  # by modes
# Of the amplitude times the tolerance: nodes as close as that differ by what samples are off.
# Kinks and thresholds were seen to need 1/2.
_CLOSEST = 1 / 100
_IDLE_ROUNDS = 5  # in which the error does not fall to this part of the least: samples are off
_LESS = 0.8
_WITHIN = 0.5  # of an idle round, that is one whose errors found are within the tolerance
# Of the tolerance: an error below is not looked for any closer, and was seen to be 1.51 times what
# is found at first.
_LEAST_STATED = 0.5
_SLACK = 1.5  # of the tolerance that is advised: its lines lie elsewhere


class _Checks:
    """Samples that are no nodes, and the errors of tables there.

    `gain` is by how much going around the largest error made it larger. Those in other blocks,
    that were not gone around, would grow by about as much.
    """

    def __init__(self, sampling: Sampling, points: Floats, exact: Complexes) -> None:
        self._sampling = sampling
        self.gain = 1.0
        self.points, self._exact = points, exact

    def _sampled(self, points: Floats) -> tuple[Floats, Complexes]:
        """Points, in order, and samples there.

        Solves begin with what the point before came to: where contacts have two motions, from far
        away one comes to another one than from the nodes nearby. Not with what the table has:
        checks are to find a motion that it has missed.
        """
        points = _in_order(points)
        return points, self._sampling.at(points, None)

    def _add(self, points: Floats) -> None:
        if not len(points):
            return
        points, exact = self._sampled(points)
        self.points = np.concatenate((self.points, points))
        self._exact = np.concatenate((self._exact, exact))

    def errors(
        self, table: Table, doubts: Floats, grid: Grid, tolerance: float
    ) -> Iterator[Floats]:
        """Relative error at the points, to which those are added that the table needs.

        And then, should it be asked for, those around the largest errors.
        """
        sampling, axes = self._sampling, table.axes
        norm = sampling.norm(table)
        doubt = np.maximum(at_cells(doubts.max(axis=0)), grid.left.max(axis=0))
        blocks = Blocks.of(axes, grid.block, doubt)

        def add(points: Floats) -> tuple[Floats, NDArray[np.int64]]:
            """Add points; errors at all, and their blocks."""
            self._add(points)
            errors = sampling.error_of(self.points, table.terms(self.points), self._exact, norm)
            return errors, grid.block[grid.cells(self.points)]

        onset = onset_points(blocks, sampling.onset_lines, self.points)
        checked = np.concatenate((self.points, onset))
        doubtful = doubtful_points(blocks, sampling.onset_lines, checked)
        errors, holding = add(np.concatenate((onset, doubtful)))
        # errors too large are seldom alone: samples estimated those beside them as badly
        for _ in range(_RINGS):
            bad = holding[errors > self.limit(errors, tolerance)]
            if not bad.size or not len(beside := points_beside(blocks, bad, self.points)):
                break
            errors, holding = add(beside)
        yield errors
        first = errors.max()
        for share in AROUND:
            errors, holding = add(places_around(blocks, holding, self.points, errors, share))
        self.gain = float(errors.max() / first) if first > 0.0 else 1.0
        yield errors

    def limit(self, errors: Floats, tolerance: float) -> float:
        """What the largest error found may be if none at all is to be above the tolerance."""
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
        The columns that are not tabulated, at the nodes, if they are to be kept.
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
    """The first grid with its samples, and check points all over; samples are taken at once."""
    ends = sampling.amplitude_range
    spread = _in_order(spread_points(ends))
    grid = Grid.upto(ends, _FIRST_INTERVALS[ends.size], _CLOSEST * tolerance)
    nodes, tabulated = amplitude_pairs(*grid.nodes, grid.modes), len(sampling.columns.orders)
    if grid.modes == 2:
        exact = sampling.at(nodes, None).reshape(*grid.sampled.shape, -1)
        samples = NodeSamples.of(exact, tabulated)
        return grid, samples, _Checks(sampling, spread, sampling.at(spread, None))
    middles = grid.middles(0)[:, np.newaxis]  # that are sampled next whatever the nodes tell
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
    least, idle = np.inf, 0.0
    table: Table | None = None
    for _ in range(_MAX_ROUNDS):
        if grid.sampled.size > _MOST_NODES[grid.modes] or time_budget.spent:
            break
        for mode in range(grid.modes):
            if grid.poor[mode].any():
                grid, samples = _halve(sampling, grid, samples, table, mode, tolerance)
                table = None
        if grid.poor.any():
            continue
        table, stalled = sampling.table(grid.nodes, samples.tabulated), 0.0
        doubts = sampling.doubts(table)
        for gone_around, errors in enumerate(checks.errors(table, doubts, grid, tolerance)):
            if idle and not gone_around:
                continue  # the last halving was no use: more is to be seen before the next
            error = largest_error(errors, sampling.noise)
            # within it by what was found, it lacks what may lie beyond: seen less with every round
            waste = 1.0 if errors.max() > tolerance else _WITHIN
            stalled = 0.0 if error < _LESS * least else idle + waste
            if error > tolerance and stalled < _IDLE_ROUNDS:
                # what lies beyond the largest may be at any of those that are nearly as large
                missed = checks.points[errors > checks.limit(errors, tolerance) / checks.gain]
                grid = grid.poor_at(missed, doubts, _LESS_IN_DOUBT)
            if grid.poor.any():
                break
        else:
            return grid, samples, table, error
        idle, least = stalled, min(least, error)
    table = sampling.table(grid.nodes, samples.tabulated)
    *_, errors = checks.errors(table, sampling.doubts(table), grid, tolerance)
    error = largest_error(errors, sampling.noise)
    many = grid.modes == 2 and grid.sampled.size > _MOST_NODES[2]
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
    """Halve the poor cells along one axis; `known` are samples at their middles.

    `table` is that through the samples, where there is one.
    """
    lacking = grid.lacking(mode)
    if lacking.any():
        near = samples.rows[samples.row[lacking]]
        samples = _sampled_at(sampling, grid, samples, lacking, near)
        grid, table = replace(grid, sampled=grid.sampled | lacking), None
    order = grid.order(mode)
    points = amplitude_pairs(*grid.with_nodes(mode, grid.middles(mode)), grid.modes)
    table = table or sampling.table(grid.nodes, samples.tabulated)
    new = order >= grid.nodes[mode].size
    taken = grid.wanted(mode)
    surface = table.terms(points).reshape(*taken.shape, -1)
    # what is not sampled is as it was: on the surface, or between the nodes
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
    """With samples at some nodes of the grid, from about what is carried there, if it is known."""
    points = amplitude_pairs(*grid.nodes, grid.modes)[nodes.ravel()]
    return samples.taken(nodes, sampling.at(points, near))
