"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Intervals between grid lines are halved until the surface can be expected to be within the
tolerance: what it missed new samples by falls with this halving at least half as well as with the
last one, and nowhere is it trusted to fall below half. Those next to a poor one are halved too.
Every sample becomes a node; points that are no nodes measure the error of the finished table, see
check_points.py, and intervals where it is too large are halved again.

Where only a region of the plane is wanted, samples are taken at the corners of its cells and at
the nodes next to them, on whose values the slopes there depend most. At all other nodes stands
what the surface was before its grid lines were halved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import Order
from slipmode.rom.representable import round_up
from slipmode.rom.short_repr import short_repr
from slipmode.rom.table.check_points import (
    AROUND,
    around,
    at_cells,
    doubtful_points,
    holding_cells,
    largest_error,
    onset_points,
    spread_points,
    unpredicted,
    worst_points,
)
from slipmode.rom.table.hermite import Table, make_table
from slipmode.rom.table.region import Region, corners, widened, with_neighbours

_FIRST_INTERVALS = 8
_FIRST_INTERVALS_OF_A_PART = 4  # that are sampled everywhere, in the region or not
_MAX_ROUNDS = 40
_LESS_IN_DOUBT = 1 / 4  # of the largest doubt in a cell: an axis that has less is left alone
_MOST_NODES = 20_000
# Of the amplitude times the tolerance: nodes as close as that differ by what samples are off.
# Kinks and thresholds were seen to need 1/2.
_CLOSEST = 1 / 100
_IDLE_ROUNDS = 5  # in which the error does not fall to this part of the least: samples are off
_LESS = 0.8
_SLACK = 1.5  # of the tolerance that is advised: its lines lie elsewhere
_CAUTION = 2.0  # an error is expected to fall less than it did, by this factor
_LEAST_LEFT = 1 / 4  # of an error by halving: one that fell faster may have lost sight of a kink


@dataclass(frozen=True)
class Columns:
    """What a sample holds.

    Attributes
    ----------
    orders : tuple of (n, m)
        Harmonics behind the tabulated columns: S_j of the modes first, the power last.
    drives : tuple of int
        The mode that each column but the power drives: its largest |S_j| is the column's scale.
    swing : (modes,) ndarray
        2 Omega_j |a_j| at the largest amplitude: the scale of the power is what the largest S_j
        would take, not the power itself, which weak friction leaves to the rounding.
    least : (modes,) ndarray
        Below it |S_j| is rounding, which cannot be tabulated relative to itself.
    loss : (modes,) ndarray
        Structural loss of each mode, see `make_table`.
    carried : int
        Further columns that are kept at the nodes but neither tabulated nor refined.
    """

    orders: tuple[Order, ...]
    drives: tuple[int, ...]
    swing: Floats
    least: Floats
    loss: Floats
    carried: int = 0

    __repr__ = short_repr

    def error(self, difference: Floats, S: Complexes) -> Floats:
        """Largest |difference| over the tabulated columns, relative to their scales."""
        largest = np.abs(S[..., : self.swing.size]).max(axis=tuple(range(S.ndim - 1)))
        largest = np.maximum(largest, self.least)
        scale = np.append(largest[list(self.drives)], self.swing @ largest)
        return np.asarray((difference / np.where(scale > 0.0, scale, 1.0)).max(axis=-1))


@dataclass(frozen=True, eq=False)
class Axis:
    """Grid lines of one amplitude.

    Attributes
    ----------
    node : (n,) ndarray
        Where they are.
    poor : (n - 1,) ndarray of bool
        Intervals that are to be halved.
    missed : (n - 1,) ndarray
        Relative error of the surface in each interval before it was halved; inf: never was.
    closest : float
        Distance of nodes below which no interval is halved, relative to the amplitude there.
    """

    node: Floats
    poor: Flags
    missed: Floats
    closest: float

    __repr__ = short_repr

    @classmethod
    def upto(cls, end: float, intervals: int, closest: float) -> Axis:
        """The first, even intervals, all of them to be halved."""
        every, never = np.ones(intervals, dtype=bool), np.full(intervals, np.inf)
        return cls(np.linspace(0.0, end, intervals + 1), every, never, closest)

    def extended(self, beyond: int) -> Axis:
        """With intervals beyond the last node, as wide as the first ones were, to be halved."""
        further = self.node[-1] * (1.0 + np.arange(1, beyond + 1) / _FIRST_INTERVALS)
        every = np.ones(beyond, dtype=bool)
        return Axis(
            np.append(self.node, further),
            np.append(self.poor, every),
            np.append(self.missed, np.full(beyond, np.inf)),
            self.closest,
        )

    @property
    def middles(self) -> Floats:
        """Midpoints of the poor intervals."""
        return (0.5 * (self.node[:-1] + self.node[1:]))[self.poor]

    @property
    def order(self) -> NDArray[np.intp]:
        """What sorts the nodes and, after them, the midpoints."""
        return np.argsort(np.concatenate((self.node, self.middles)), kind="stable")

    @property
    def finer(self) -> Floats:
        """Nodes and midpoints in order."""
        return np.concatenate((self.node, self.middles))[self.order]

    def halved(self, error: Floats, tolerance: float) -> Axis:
        """With the midpoints as nodes, where the surface had errors (poor,)."""
        before = self.missed[self.poor]
        known = np.isfinite(before) & (before > 0.0)
        rate = np.divide(error, before, out=np.ones_like(error), where=known)
        left = error * np.minimum(_CAUTION * np.maximum(rate, _LEAST_LEFT), 1.0)
        still, missed = np.zeros_like(self.poor), self.missed.copy()
        still[self.poor] = left > tolerance
        missed[self.poor] = error
        parts = np.where(self.poor, 2, 1)
        # a kink beside an interval bends the surface in it too, and may be seen only there
        poor = widened(np.repeat(still, parts)) & _wide(self.finer, self.closest)
        return Axis(self.finer, poor, np.repeat(missed, parts), self.closest)

    def poor_at(self, points: Floats) -> Axis:
        """With the intervals that hold the points to be halved too."""
        held = np.zeros_like(self.poor)
        held[np.clip(np.searchsorted(self.node, points) - 1, 0, held.size - 1)] = True
        return replace(self, poor=self.poor | held & _wide(self.node, self.closest))


@dataclass(frozen=True, eq=False)
class Sampling:
    """Where samples come from: values (points, columns) at amplitudes (points, modes).

    `onset_lines` (lines, modes) is where they may have kinks, see `onset_lines`; `noise` by how
    much they are off by chance, as errors are; `region` the part of the plane where they are
    wanted; None: everywhere. `beyond` are the intervals past `amplitude_range`, besides
    _FIRST_INTERVALS up to it.
    """

    at: Callable[[Floats], Complexes]
    columns: Columns
    amplitude_range: Floats
    onset_lines: Floats
    noise: float
    region: Region | None = None
    beyond: int = 0

    __repr__ = short_repr

    def wanted(self, node_a: Floats, node_b: Floats) -> tuple[Flags, Flags]:
        """Nodes of a grid (n_a, n_b) where the error counts, and where samples are taken."""
        if self.region is None:
            every = np.ones((node_a.size, node_b.size), dtype=bool)
            return every, every
        ends = corners(self.region.cells(node_a, node_b))
        return ends, with_neighbours(ends)

    def doubts(self, table: Table) -> Floats:
        """How little its neighbours along each mode's axis tell of a node, (modes, n_a, n_b)."""
        S = table.nodes()
        parts = [unpredicted(table.node_a, S)]
        if table.modes == 2:
            parts.append(unpredicted(table.node_b, S.swapaxes(0, 1)).swapaxes(0, 1))
        return np.array([self.columns.error(part, self._within(table)) for part in parts])

    def table(self, axes: tuple[Floats, Floats], samples: Complexes) -> Table:
        """Table through the tabulated columns of samples on a grid."""
        orders = self.columns.orders
        tabulated = samples[..., : len(orders)]
        return make_table(axes[0], axes[1], tabulated, orders, self.columns.loss)

    def error_of(self, surface: Complexes, exact: Complexes, table: Table) -> Floats:
        """Relative error of values of a table where samples are `exact`, (points,)."""
        tabulated = exact[..., : len(self.columns.orders)]
        return self.columns.error(np.abs(surface - tabulated), self._within(table))

    def _within(self, table: Table) -> Complexes:
        """Values at the nodes up to the amplitude range: what errors are relative to."""
        inside = [
            np.searchsorted(node, end, "right")
            for node, end in zip(table.axes, self.amplitude_range, strict=True)
        ]
        return table.nodes()[tuple(slice(count) for count in inside)]


class _Checks:
    """Samples that are no nodes, and the errors of tables there."""

    def __init__(self, sampling: Sampling) -> None:
        self._sampling = sampling
        amplitude_range = sampling.amplitude_range
        onset = onset_points(sampling.onset_lines, amplitude_range)
        inside = None if sampling.region is None else sampling.region.holds
        if inside is not None:
            onset = onset[inside(onset)]
        self.points, self._exact = self._sampled(
            np.concatenate((spread_points(amplitude_range, inside), onset))
        )

    def add_beyond(self) -> None:
        """Check past the amplitude range, too."""
        sampling, end = self._sampling, self._sampling.amplitude_range
        furthest = (1.0 + sampling.beyond / _FIRST_INTERVALS) * end
        onset = onset_points(sampling.onset_lines, furthest)
        points = np.concatenate((spread_points(furthest), onset))
        self._add(points[(points > end).any(axis=1)])

    def _sampled(self, points: Floats) -> tuple[Floats, Complexes]:
        """Points, in order, and samples there.

        Solves begin with what the point before came to: where contacts have two motions, from far
        away one comes to another one than from the nodes nearby.
        """
        points = points[np.lexsort(points.T[::-1])]
        return points, self._sampling.at(points)

    def _add(self, points: Floats) -> None:
        if not len(points):
            return
        points, exact = self._sampled(points)
        self.points = np.concatenate((self.points, points))
        self._exact = np.concatenate((self._exact, exact))

    def errors(self, table: Table) -> Floats:
        """Relative error at the points, to which those are added that the table needs."""
        sampling = self._sampling
        doubt = at_cells(sampling.doubts(table).max(axis=0))
        if sampling.region is not None:
            doubt = np.where(sampling.region.cells(table.node_a, table.node_b), doubt, 0.0)
        self._add(doubtful_points(table.axes, doubt, sampling.onset_lines, self.points))
        errors = self._errors(table)
        for share in AROUND:
            worst = worst_points(table.axes, self.points, errors)
            self._add(np.concatenate([around(table.axes, point, share) for point in worst]))
            errors = self._errors(table)
        return errors

    def _errors(self, table: Table) -> Floats:
        return self._sampling.error_of(table.terms(self.points), self._exact, table)


def refine(sampling: Sampling, tolerance: float) -> tuple[Table, Complexes, float]:
    """Tabulate to a tolerance relative to the largest |S_j| up to the amplitude range.

    Parameters
    ----------
    sampling : Sampling
    tolerance : float

    Returns
    -------
    table : Table
    carried : (n_a, n_b, carried) complex ndarray
        The columns that are not tabulated, at the nodes.
    error : float
        Largest difference between the nodes, relative to the largest |S_j|: `largest_error`. Above
        the tolerance where samples jump or are not exact, so that more nodes would not help.

    Raises
    ------
    SlipmodeError
        If it takes too many nodes.
    """
    intervals = _FIRST_INTERVALS if sampling.region is None else _FIRST_INTERVALS_OF_A_PART
    closest = _CLOSEST * tolerance
    axes = [Axis.upto(end, intervals, closest) for end in sampling.amplitude_range]
    node_a, node_b = _lines(axes)
    samples = sampling.at(amplitude_pairs(node_a, node_b, len(axes)))
    samples = samples.reshape(node_a.size, node_b.size, -1)
    checks = _Checks(sampling)
    axes, samples, table, error = _refined(sampling, axes, samples, checks, tolerance)
    if sampling.beyond:
        axes, samples = _extended(sampling, axes, samples)
        checks.add_beyond()
        axes, samples, table, error = _refined(sampling, axes, samples, checks, tolerance)
    if sampling.region is not None:
        table = replace(table, region=sampling.region.cells(*_lines(axes)))
    return table, samples[..., len(sampling.columns.orders) :], error


def _refined(
    sampling: Sampling,
    axes: list[Axis],
    samples: Complexes,
    checks: _Checks,
    tolerance: float,
) -> tuple[list[Axis], Complexes, Table, float]:
    """Halve intervals until samples and check points agree with the table to the tolerance.

    Or until that does not help: samples jump, or are not as exact as they are meant to be.
    """
    least, idle = np.inf, 0
    for _ in range(_MAX_ROUNDS):
        if samples.shape[0] * samples.shape[1] > _MOST_NODES:
            break
        for number in range(len(axes)):
            axes, samples = _halve(sampling, axes, samples, number, tolerance)
        if any(axis.poor.any() for axis in axes):
            continue
        table = sampling.table(_lines(axes), samples)
        errors = checks.errors(table)
        error = largest_error(errors, sampling.noise)
        idle = 0 if error < _LESS * least else idle + 1
        least = min(least, error)
        if error > tolerance and idle < _IDLE_ROUNDS:
            # what lies beyond the largest error may be at any of those that are nearly as large
            missed = checks.points[errors > tolerance * errors.max() / error]
            axes = _poor_at(axes, missed, sampling.doubts(table))
        if not any(axis.poor.any() for axis in axes):
            return axes, samples, table, error
    error = largest_error(checks.errors(sampling.table(_lines(axes), samples)), sampling.noise)
    reached = round_up(_SLACK * max(error, tolerance))
    raise SlipmodeError(
        f"tolerance: a friction table to {tolerance:g} needs more than {samples.shape[0]} x "
        f"{samples.shape[1]} nodes; with these a tolerance of {reached:g} is within reach"
    )


def _poor_at(axes: Sequence[Axis], points: Floats, doubts: Floats) -> list[Axis]:
    """Axes with the intervals that hold points to be halved, where nodes along them tell least."""
    cells = holding_cells([axis.node for axis in axes], points)
    there = np.array(
        [at_cells(along)[cells if len(axes) == 2 else (*cells, 0)] for along in doubts]
    )
    doubted = there >= _LESS_IN_DOUBT * there.max(axis=0)
    return [axis.poor_at(points[doubted[j], j]) for j, axis in enumerate(axes)]


def headroom_intervals(headroom: float) -> int:
    """Intervals beyond the amplitude range that take a table to `headroom` times it."""
    if not (np.isfinite(headroom) and headroom >= 1.0):
        raise SlipmodeError(f"headroom: must be a finite number >= 1, got {headroom:g}")
    return int(np.ceil((headroom - 1.0) * _FIRST_INTERVALS - 1e-9))


def least_everywhere(table: Table) -> int:
    """Contact problems that a table of the whole plane takes at least, instead of one of a part.

    It needs the grid lines that the part needs, and halves each of its first intervals.
    """
    first = 2 * _FIRST_INTERVALS + 1
    nodes = max(table.node_a.size, first) * max(table.node_b.size, first)
    return nodes + len(spread_points(table.amplitude_range))


def _halve(
    sampling: Sampling, axes: list[Axis], samples: Complexes, number: int, tolerance: float
) -> tuple[list[Axis], Complexes]:
    """Halve the poor intervals of one axis."""
    axis = axes[number]
    if not axis.poor.any():
        return axes, samples
    lines, order = _lines(axes), axis.order
    between, finer = (_replaced(lines, number, node) for node in (axis.middles, axis.finer))
    points = amplitude_pairs(*between, len(axes))
    table = sampling.table(lines, samples)
    surface = table.terms(points)
    # what is not sampled is as it was: on the surface, or what is linear between the nodes
    (left,) = np.nonzero(axis.poor)
    beside = np.take(samples, left, axis=number), np.take(samples, left + 1, axis=number)
    shape = beside[0].shape
    fresh = (0.5 * (beside[0] + beside[1])).reshape(len(points), -1)
    fresh[:, : surface.shape[1]] = surface
    new = order >= axis.node.size
    counts, taken = (
        np.compress(new, flags, axis=number).ravel() for flags in sampling.wanted(*finer)
    )
    if taken.any():
        fresh[taken] = sampling.at(points[taken])
    error = np.where(counts, sampling.error_of(surface, fresh, table), 0.0)
    worst = error.reshape(shape[:2]).max(axis=1 - number)
    both = np.concatenate((samples, fresh.reshape(shape)), axis=number)
    merged = np.take(both, order, axis=number)
    return [*axes[:number], axis.halved(worst, tolerance), *axes[number + 1 :]], merged


def _extended(
    sampling: Sampling, axes: list[Axis], samples: Complexes
) -> tuple[list[Axis], Complexes]:
    """With samples at the nodes of the headroom too."""
    longer = [axis.extended(sampling.beyond) for axis in axes]
    node_a, node_b = _lines(longer)
    fresh = np.ones((node_a.size, node_b.size), dtype=bool)
    known = tuple(slice(count) for count in samples.shape[:2])
    fresh[known] = False
    everywhere = np.empty((*fresh.shape, samples.shape[-1]), dtype=complex)
    everywhere[known] = samples
    points = amplitude_pairs(node_a, node_b, len(axes))
    everywhere[fresh] = sampling.at(points[fresh.ravel()])
    return longer, everywhere


def _wide(node: Floats, closest: float) -> Flags:
    """Which intervals may be halved."""
    return np.asarray(np.diff(node) >= 2.0 * closest * node[1:])


def _lines(axes: Sequence[Axis]) -> tuple[Floats, Floats]:
    """Grid lines of both amplitudes, the single 0 for a mode that is not there."""
    return axes[0].node, axes[1].node if len(axes) == 2 else np.zeros(1)


def _replaced(lines: tuple[Floats, Floats], number: int, node: Floats) -> tuple[Floats, Floats]:
    """Grid lines of both amplitudes, with others for one of them."""
    return (node, lines[1]) if number == 0 else (lines[0], node)


def amplitude_pairs(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Amplitudes (n_a n_b, modes) of a grid; of one mode, those of the first axis."""
    grid = np.stack(np.meshgrid(node_a, node_b, indexing="ij"), axis=-1)
    return grid.reshape(-1, 2)[:, :modes]
