"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Cells between grid lines are halved until the expected error is within the tolerance. The expected
error follows from the errors at new samples in the last two halvings, see `Grid.halved`.
Neighbours of marked cells are halved too. Every sample becomes a node. Points that are no nodes
measure the error of the finished table, see check_points.py; cells where it is too large are
halved again.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.error_budget import LARGEST_TOLERANCE, within_reach
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import round_up
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.refinement.check_points import Checks, first_points, largest_error
from slipmode.rom.table.refinement.grid import Grid
from slipmode.rom.table.refinement.sampling import Sampling, amplitude_pairs

_MOST_SAMPLES = {1: 600, 2: 20_000}  # by modes
# Successive rounds in which the error does not decrease to `_LESS` of the least: samples jump, or
# are not as exact as they should be.
_STAGNANT_ROUNDS, _LESS = 8, 0.8
# Of the tolerance: smaller errors are not refined further, and the true error was up to 1.51 times
# the first estimate (tests/rom/table/test_stated_error.py).
_LEAST_STATED = 0.5


def refine(
    sampling: Sampling, tolerance: float, time_budget: TimeBudget
) -> tuple[Table, Complexes | None, float]:
    """Tabulate to a tolerance relative to the largest |S_j| up to the amplitude range.

    Cells are halved until samples and check points agree with the table to the tolerance, or until
    that does not help: samples jump, or are not as exact as they are meant to be.

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
    grid, checks = _first_grid(sampling, tolerance)
    most, table = _MOST_SAMPLES[grid.modes], None
    least, stagnant, ended = np.inf, 0.0, False
    for _ in range(40):
        if grid.samples.sampled.sum() > most or time_budget.spent:
            break
        for mode in range(grid.modes):
            if grid.marked[mode].any():
                grid, table = grid.halved(sampling, mode, tolerance, table), None
        if grid.marked.any():
            continue
        table, indicators, errors = checks.errors(grid, tolerance)
        error = largest_error(errors, sampling.noise)
        # If only the extrapolated error is too large, it decreases with every round.
        waste = 1.0 if errors.max() > tolerance else 0.5
        stagnant = 0.0 if error < _LESS * least else stagnant + waste
        least = min(least, error)
        ended = error <= tolerance or stagnant >= _STAGNANT_ROUNDS
        if not ended:
            # The largest error may be close to any point whose error is nearly the largest.
            large = errors > checks.limit(errors, tolerance) / checks.gain
            grid = grid.marked_at(checks.points[large], indicators)
            ended = not grid.marked.any()
        if ended:
            break
    if table is None or not ended:
        table, _, errors = checks.errors(grid, tolerance)
        error = largest_error(errors, sampling.noise)
        _check_end(grid, error, tolerance, time_budget)
    carried = grid.samples.carried if sampling.kept else None
    return table, carried, max(error, _LEAST_STATED * tolerance)


def _check_end(grid: Grid, error: float, tolerance: float, time_budget: TimeBudget) -> None:
    """Refuse a table whose refinement was ended by samples, rounds or time, unless it jumps."""
    many = grid.modes == 2 and grid.samples.sampled.sum() > _MOST_SAMPLES[2]
    if error <= LARGEST_TOLERANCE and not many and not time_budget.spent:
        return  # samples jump: more nodes would not help
    # A half more is advised, for its grid lines differ.
    reached = within_reach(round_up(1.5 * max(error, tolerance)))
    nodes = "{} x {} nodes".format(*grid.samples.row.shape)
    if time_budget.spent:
        raise SlipmodeError(
            f"budget: a friction table with tolerance {tolerance:g} takes longer than "
            f"{time_budget.seconds:g} s; with the {nodes} of that time {reached}"
        )
    raise SlipmodeError(
        f"tolerance: a friction table with tolerance {tolerance:g} needs more than {nodes}; "
        f"with these {reached}"
    )


def _first_grid(sampling: Sampling, tolerance: float) -> tuple[Grid, Checks]:
    """Return the first grid with its samples, and check points, which are sampled at once."""
    # Nodes that are closer, relative to their amplitude, differ by the error of samples. Half the
    # tolerance was close enough for kinks and thresholds.
    ends, closest = sampling.amplitude_range, 0.01 * tolerance
    spread, columns = first_points(sampling.onset_lines, ends), len(sampling.orders)
    if ends.size == 2:
        node = [np.linspace(0.0, end, 5) for end in ends]
        pairs = amplitude_pairs(node[0], node[1], 2)
        samples = sampling.at(pairs.reshape(-1, 2), None).reshape(*pairs.shape[:2], -1)
        checks = Checks(sampling, spread, sampling.at(spread, None))
        return Grid.of(node, samples, columns, closest), checks
    node = [np.linspace(0.0, ends[0], 9)]
    middles = 0.5 * (node[0][:-1] + node[0][1:])  # sampled next in any case
    points = np.concatenate((node[0], middles, spread[:, 0]))[:, np.newaxis]
    order = np.argsort(points[:, 0], kind="stable")
    exact = sampling.at(points[order], None)[np.argsort(order)]
    of_nodes, of_middles, of_spread = np.split(exact, np.cumsum([node[0].size, middles.size]))
    grid = Grid.of(node, of_nodes[:, np.newaxis], columns, closest)
    checks = Checks(sampling, spread, of_spread)
    return grid.halved(sampling, 0, tolerance, known=of_middles), checks
