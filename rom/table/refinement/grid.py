"""Grid lines of a friction table, and the cells between them that are to be halved.

A cell is halved along one axis at a time, by a grid line through it. The line goes on through all
cells beside it, but samples are taken on it only where cells are to be halved: elsewhere the
surface is good enough as it is, and stands at the nodes of the line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.rom.table.check_points import at_cells, holding_cells
from slipmode.rom.table.refinement.blocks import apart

_CAUTION = 2.0  # an error is expected to fall less than it did, by this factor
_LEAST_LEFT = 1 / 4  # of an error by halving: one that fell faster may have lost sight of a kink


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of each mode, and the cells between them, which are (cells_a, cells_b).

    Of one mode the second axis has the single node 0, and a cell there.

    Attributes
    ----------
    nodes : tuple of (n_a,) and (n_b,) ndarray
        Amplitudes [kg^1/2 m].
    poor : (modes, cells_a, cells_b) ndarray of bool
        Cells that are to be halved along the axis of a mode.
    missed : (modes, cells_a, cells_b) ndarray
        Relative error of the surface in each cell before it was halved so; inf: never was.
    left : (modes, cells_a, cells_b) ndarray
        What is expected to be left of it.
    sampled : (n_a, n_b) ndarray of bool
        Nodes at which samples were taken.
    block : (cells_a, cells_b) ndarray of int
        Cells of one number have no samples between them: the surface is as good, or bad, as if
        no grid lines went through the rectangle that they are.
    closest : float
        Distance of nodes below which no cell is halved, relative to the amplitude there.
    """

    nodes: tuple[Floats, Floats]
    poor: Flags
    missed: Floats
    left: Floats
    sampled: Flags
    block: NDArray[np.int64]
    closest: float

    __repr__ = short_repr

    @classmethod
    def upto(cls, ends: Floats, intervals: int, closest: float) -> Grid:
        """The first, even cells, all of them to be halved."""
        node = [np.linspace(0.0, end, intervals + 1) for end in ends]
        cells = (ends.size, intervals, intervals if ends.size == 2 else 1)
        never = np.full(cells, np.inf)
        second = node[1] if ends.size == 2 else np.zeros(1)
        every = np.ones((node[0].size, second.size), dtype=bool)
        block = np.arange(never[0].size).reshape(cells[1:])
        poor = np.ones(cells, dtype=bool)
        return cls((node[0], second), poor, never, never, every, block, closest)

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.poor)

    def cells(self, points: Floats) -> tuple[NDArray[np.intp], ...]:
        """Indices of the cells that hold points (points, modes)."""
        cells = holding_cells(self.nodes[: self.modes], points)
        return cells if self.modes == 2 else (*cells, np.zeros_like(cells[0]))

    def split(self, mode: int) -> Flags:
        """Intervals of a mode's axis that a poor cell is in."""
        return np.asarray(self.poor[mode].any(axis=1 - mode))

    def middles(self, mode: int) -> Floats:
        """Their midpoints."""
        node = self.nodes[mode]
        return np.asarray((0.5 * (node[:-1] + node[1:]))[self.split(mode)])

    def order(self, mode: int) -> NDArray[np.intp]:
        """What sorts a mode's nodes and, after them, the midpoints."""
        return np.argsort(np.append(self.nodes[mode], self.middles(mode)), kind="stable")

    def with_nodes(self, mode: int, node: Floats) -> tuple[Floats, Floats]:
        """Nodes of both modes, with others of one."""
        return (node, self.nodes[1]) if mode == 0 else (self.nodes[0], node)

    def lacking(self, mode: int) -> Flags:
        """Corners of cells that are to be halved without a sample, (n_a, n_b)."""
        ends = _touching(self.poor[mode], 0, self.nodes[0].size)
        return _touching(ends, 1, self.nodes[1].size) & ~self.sampled

    def wanted(self, mode: int) -> Flags:
        """Nodes on the lines through the midpoints that are corners of halved cells, as a grid."""
        poor = np.compress(self.split(mode), self.poor[mode], axis=mode)
        return _touching(poor, 1 - mode, self.nodes[1 - mode].size)

    def halved(self, mode: int, taken: Flags, error: Floats, tolerance: float) -> Grid:
        """With the midpoints as nodes; on their lines samples were taken, and found errors."""
        split, axis = self.split(mode), 1 + mode
        halved = (split, slice(None)) if mode == 0 else (slice(None), split)
        poor, before = self.poor[mode][halved], self.missed[mode][halved]
        worst = _in_cells(error, 1 - mode)
        known = np.isfinite(before) & (before > 0.0)
        rate = np.divide(worst, before, out=np.ones_like(worst), where=known)
        expected = worst * np.minimum(_CAUTION * np.maximum(rate, _LEAST_LEFT), 1.0)
        still, missed, left = self.poor.copy(), self.missed.copy(), self.left.copy()
        still[mode][halved] = poor & (expected > tolerance)
        missed[mode][halved] = np.where(poor, worst, before)
        left[mode][halved] = np.where(poor, expected, left[mode][halved])
        node = np.append(self.nodes[mode], self.middles(mode))[self.order(mode)]
        parts = np.where(split, 2, 1)
        still = np.repeat(still, parts, axis)
        # a kink beside a cell bends the surface in it too, and may be seen only there
        still[mode] = _widened(_widened(still[mode]).T).T & self._wide(node, mode)
        both = np.concatenate((self.sampled, taken), axis=mode)
        return Grid(
            self.with_nodes(mode, node),
            still,
            np.repeat(missed, parts, axis),
            np.repeat(left, parts, axis),
            np.take(both, self.order(mode), axis=mode),
            apart(*(np.repeat(each, parts, mode) for each in (self.block, self.poor[mode]))),
            self.closest,
        )

    def poor_at(self, points: Floats, doubts: Floats, share: float) -> Grid:
        """With cells that hold points (points, modes) to be halved, too.

        Along the axes of which neighbours tell at least a `share` as little as of the other;
        `doubts` (modes, n_a, n_b) is how little they tell of nodes.
        """
        place = self.cells(points)
        there = np.array([at_cells(along)[place] for along in doubts])
        doubted = there >= share * there.max(axis=0)
        poor = self.poor.copy()
        for mode in range(self.modes):
            held = np.zeros_like(poor[mode])
            held[tuple(index[doubted[mode]] for index in place)] = True
            poor[mode] |= held & self._wide(self.nodes[mode], mode)
        return replace(self, poor=poor)

    def _wide(self, node: Floats, mode: int) -> Flags:
        """Which intervals of a mode may be halved, as a grid."""
        wide = np.diff(node) >= 2.0 * self.closest * node[1:]
        return np.asarray(wide[:, np.newaxis] if mode == 0 else wide)


def _widened(nodes: Flags) -> Flags:
    """Marked nodes and those next to them along the first axis."""
    wide = nodes.copy()
    wide[1:] |= nodes[:-1]
    wide[:-1] |= nodes[1:]
    return wide


def _touching(cells: Flags, axis: int, nodes: int) -> Flags:
    """Nodes along an axis at which a marked cell begins or ends."""
    if nodes == 1:
        return cells
    along = cells.swapaxes(0, axis)
    touched = np.zeros((nodes, along.shape[1]), dtype=bool)
    touched[:-1] = along
    touched[1:] |= along
    return touched.swapaxes(0, axis)


def _in_cells(values: Floats, axis: int) -> Floats:
    """The larger of the values at the two ends of each cell along an axis."""
    if values.shape[axis] == 1:
        return values
    along = values.swapaxes(0, axis)
    return np.maximum(along[:-1], along[1:]).swapaxes(0, axis)
