"""Grid lines of a friction table, and the cells between them that are to be halved.

A cell is halved along one axis at a time, by a grid line through it. The line crosses all other
cells of that row, but samples are taken on it only where cells are to be halved. Its other nodes
have the values of the surface, which is accurate enough there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.check_points import at_cells, holding_cells
from slipmode.rom.table.refinement.blocks import apart

_CAUTION = 2.0  # an error is expected to fall less than it did, by this factor
_LEAST_LEFT = 1 / 4  # of an error by halving: a faster decay may have missed a kink


@frozen
class Grid:
    """Nodes of each mode, and the cells between them, which are (cells_a, cells_b).

    Of one mode the second axis has the single node 0, and a cell there.

    Attributes
    ----------
    nodes : tuple of (n_a,) and (n_b,) ndarray
        Amplitudes [kg^1/2 m].
    marked : (modes, cells_a, cells_b) ndarray of bool
        Cells that are to be halved along the axis of a mode.
    missed : (modes, cells_a, cells_b) ndarray
        Relative error of the surface in each cell before it was halved; inf: was never halved.
    left : (modes, cells_a, cells_b) ndarray
        Error that is expected now.
    sampled : (n_a, n_b) ndarray of bool
        Nodes at which samples were taken.
    block : (cells_a, cells_b) ndarray of int
        Cells of one number form a rectangle without samples inside: its grid lines do not change
        the surface.
    closest : float
        Distance of nodes below which no cell is halved, relative to the amplitude there.
    """

    nodes: tuple[Floats, Floats]
    marked: Flags
    missed: Floats
    left: Floats
    sampled: Flags
    block: NDArray[np.int64]
    closest: float

    @classmethod
    def upto(cls, ends: Floats, intervals: int, closest: float) -> Grid:
        """Return the first grid of even cells, all of them to be halved."""
        node = [np.linspace(0.0, end, intervals + 1) for end in ends]
        cells = (ends.size, intervals, intervals if ends.size == 2 else 1)
        never = np.full(cells, np.inf)
        second = node[1] if ends.size == 2 else np.zeros(1)
        every = np.ones((node[0].size, second.size), dtype=bool)
        block = np.arange(never[0].size).reshape(cells[1:])
        marked = np.ones(cells, dtype=bool)
        return cls((node[0], second), marked, never, never, every, block, closest)

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.marked)

    def cells(self, points: Floats) -> tuple[NDArray[np.intp], ...]:
        """Return the indices of the cells that contain points (points, modes)."""
        cells = holding_cells(self.nodes[: self.modes], points)
        return cells if self.modes == 2 else (*cells, np.zeros_like(cells[0]))

    def split(self, mode: int) -> Flags:
        """Return the intervals of a mode's axis that contain a marked cell."""
        return np.asarray(self.marked[mode].any(axis=1 - mode))

    def middles(self, mode: int) -> Floats:
        """Return the midpoints of these intervals."""
        node = self.nodes[mode]
        return np.asarray((0.5 * (node[:-1] + node[1:]))[self.split(mode)])

    def order(self, mode: int) -> NDArray[np.intp]:
        """Return the order of a mode's nodes and, after them, the midpoints."""
        return np.argsort(np.append(self.nodes[mode], self.middles(mode)), kind="stable")

    def with_nodes(self, mode: int, node: Floats) -> tuple[Floats, Floats]:
        """Return the nodes of both modes, with others of one."""
        return (node, self.nodes[1]) if mode == 0 else (self.nodes[0], node)

    def unsampled(self, mode: int) -> Flags:
        """Return the corners without samples of cells to be halved, (n_a, n_b)."""
        ends = _touching(self.marked[mode], 0, self.nodes[0].size)
        return _touching(ends, 1, self.nodes[1].size) & ~self.sampled

    def wanted(self, mode: int) -> Flags:
        """Return the nodes on lines through the midpoints that are corners of halved cells."""
        marked = np.compress(self.split(mode), self.marked[mode], axis=mode)
        return _touching(marked, 1 - mode, self.nodes[1 - mode].size)

    def halved(self, mode: int, taken: Flags, error: Floats, tolerance: float) -> Grid:
        """Return the grid with the midpoints as nodes; `error` are those of samples there."""
        split, axis = self.split(mode), 1 + mode
        halved = (split, slice(None)) if mode == 0 else (slice(None), split)
        marked, before = self.marked[mode][halved], self.missed[mode][halved]
        worst = _in_cells(error, 1 - mode)
        known = np.isfinite(before) & (before > 0.0)
        rate = np.divide(worst, before, out=np.ones_like(worst), where=known)
        expected = worst * np.minimum(_CAUTION * np.maximum(rate, _LEAST_LEFT), 1.0)
        still, missed, left = self.marked.copy(), self.missed.copy(), self.left.copy()
        still[mode][halved] = marked & (expected > tolerance)
        missed[mode][halved] = np.where(marked, worst, before)
        left[mode][halved] = np.where(marked, expected, left[mode][halved])
        node = np.append(self.nodes[mode], self.middles(mode))[self.order(mode)]
        parts = np.where(split, 2, 1)
        still = np.repeat(still, parts, axis)
        # A kink next to a cell bends the surface in it too, and may be visible only there.
        still[mode] = _widened(_widened(still[mode]).T).T & self._wide(node, mode)
        both = np.concatenate((self.sampled, taken), axis=mode)
        return Grid(
            self.with_nodes(mode, node),
            still,
            np.repeat(missed, parts, axis),
            np.repeat(left, parts, axis),
            np.take(both, self.order(mode), axis=mode),
            apart(*(np.repeat(each, parts, mode) for each in (self.block, self.marked[mode]))),
            self.closest,
        )

    def marked_at(self, points: Floats, indicators: Floats, share: float) -> Grid:
        """Return the grid with cells that contain points (points, modes) marked, too.

        Along the axes whose indicator is at least a `share` of the larger one; `indicators`
        (modes, n_a, n_b) are those at nodes.
        """
        place = self.cells(points)
        there = np.array([at_cells(along)[place] for along in indicators])
        indicated = there >= share * there.max(axis=0)
        marked = self.marked.copy()
        for mode in range(self.modes):
            held = np.zeros_like(marked[mode])
            held[tuple(index[indicated[mode]] for index in place)] = True
            marked[mode] |= held & self._wide(self.nodes[mode], mode)
        return replace(self, marked=marked)

    def _wide(self, node: Floats, mode: int) -> Flags:
        """Return which intervals of a mode are wide enough to be halved, as a grid."""
        wide = np.diff(node) >= 2.0 * self.closest * node[1:]
        return np.asarray(wide[:, np.newaxis] if mode == 0 else wide)


def _widened(nodes: Flags) -> Flags:
    """Return marked cells and their neighbours along the first axis."""
    wide = nodes.copy()
    wide[1:] |= nodes[:-1]
    wide[:-1] |= nodes[1:]
    return wide


def _touching(cells: Flags, axis: int, nodes: int) -> Flags:
    """Return the nodes along an axis at which a marked cell begins or ends."""
    if nodes == 1:
        return cells
    along = cells.swapaxes(0, axis)
    touched = np.zeros((nodes, along.shape[1]), dtype=bool)
    touched[:-1] = along
    touched[1:] |= along
    return touched.swapaxes(0, axis)


def _in_cells(values: Floats, axis: int) -> Floats:
    """Return the larger of the values at the two ends of each cell along an axis."""
    if values.shape[axis] == 1:
        return values
    along = values.swapaxes(0, axis)
    return np.maximum(along[:-1], along[1:]).swapaxes(0, axis)
