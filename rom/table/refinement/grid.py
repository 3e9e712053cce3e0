"""Grid lines of a friction table, and the cells between them that are to be halved.

A cell is halved along one axis at a time, by a grid line through it. The line crosses all other
cells of that row, but samples are taken on it only where cells are to be halved. Its other nodes
have the values of the surface, which is accurate enough there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.refinement.sampling import Sampling, amplitude_pairs

# An error is expected to fall less by halving than it did before, and to be at least this part:
# a faster decay may come from a kink that no sample is close to.
_CAUTION, _LEAST_LEFT = 2.0, 1 / 4


@frozen
class NodeSamples:
    """Samples at the nodes of a grid, or at the nodes of some of its lines.

    There are many more carried columns than tabulated ones, and far fewer samples than nodes: the
    carried columns are rows, to which the nodes refer.
    """

    tabulated: Complexes  # (n_a, n_b, columns)
    row: NDArray[np.int64]  # (n_a, n_b), row of each node
    rows: Complexes  # (rows, carried)
    sampled: Flags  # (n_a, n_b), whether a sample was taken at the node

    @property
    def carried(self) -> Complexes:
        """The columns that are not tabulated, (n_a, n_b, carried)."""
        return np.asarray(self.rows[self.row])

    def taken(self, nodes: Flags, samples: Complexes) -> NodeSamples:
        """Return the samples with those (points, columns) at some of the nodes."""
        tabulated, row = self.tabulated.copy(), self.row.copy()
        tabulated[nodes], further = np.split(samples, [tabulated.shape[-1]], axis=1)
        row[nodes] = len(self.rows) + np.arange(len(samples))
        rows = np.concatenate((self.rows, further))
        return NodeSamples(tabulated, row, rows, self.sampled | nodes)

    def merged(self, lines: NodeSamples, mode: int, order: NDArray[np.intp]) -> NodeSamples:
        """Return the samples with lines, made from these, across a mode's axis, in this order."""

        def both(own: np.ndarray, added: np.ndarray) -> np.ndarray:
            return np.take(np.concatenate((own, added), axis=mode), order, axis=mode)

        names = ("tabulated", "row", "sampled")
        arrays = {name: both(getattr(self, name), getattr(lines, name)) for name in names}
        return NodeSamples(rows=lines.rows, **arrays)


@frozen
class Grid:
    """Nodes of each mode, and the cells between them, which are (cells_a, cells_b).

    Of one mode the second axis has the single node 0, and a cell there.
    """

    nodes: tuple[Floats, Floats]  # (n_a,) and (n_b,), amplitudes [kg^1/2 m]
    marked: Flags  # (modes, cells_a, cells_b), cells to be halved along the axis of a mode
    # (modes, cells_a, cells_b), relative error in each cell before it was halved; inf: never
    error_before: Floats
    expected_error: Floats  # (modes, cells_a, cells_b), of each cell now
    # (cells_a, cells_b): cells of one number form a rectangle without samples inside, whose grid
    # lines do not change the surface
    block: NDArray[np.int64]
    samples: NodeSamples
    closest: float  # distance of nodes relative to amplitude below which no cell is halved

    @classmethod
    def of(cls, node: Sequence[Floats], samples: Complexes, columns: int, closest: float) -> Self:
        """Return a grid whose cells are all to be halved, of samples (n_a, n_b, columns, ...)."""
        second = node[1] if len(node) == 2 else np.zeros(1)
        cells = (len(node), node[0].size - 1, max(second.size - 1, 1))
        never, shape = np.full(cells, np.inf), samples.shape[:2]
        row = np.arange(samples[..., 0].size).reshape(shape)
        rows = samples[..., columns:].reshape(row.size, -1)
        known = NodeSamples(samples[..., :columns], row, rows, np.ones(shape, dtype=bool))
        block = np.arange(never[0].size).reshape(cells[1:])
        marked = np.ones(cells, dtype=bool)
        return cls((node[0], second), marked, never, never, block, known, closest)

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.marked)

    def cells(self, points: Floats) -> tuple[NDArray[np.intp], ...]:
        """Return the indices of the cells that contain points (points, modes)."""
        cells = tuple(
            np.searchsorted(node[1:-1], place)
            for node, place in zip(self.nodes, points.T, strict=False)
        )
        return cells if self.modes == 2 else (*cells, np.zeros_like(cells[0]))

    def halved(
        self,
        sampling: Sampling,
        mode: int,
        tolerance: float,
        table: Table | None = None,
        known: Complexes | None = None,
    ) -> Grid:
        """Return the grid with the marked cells of a mode halved, with samples at their corners.

        `table` is the table through the samples, `known` are the samples at the midpoints, if they
        are known.
        """
        samples = self.samples
        marked, node = self.marked[mode], self.nodes[mode]
        split, size = marked.any(axis=1 - mode), [each.size for each in self.nodes]
        corners = _touching(_touching(marked, 0, size[0]), 1, size[1]) & ~samples.sampled
        if corners.any():
            points = amplitude_pairs(*self.nodes, self.modes)[corners]
            near = samples.rows[samples.row[corners]]
            samples, table = samples.taken(corners, sampling.at(points, near)), None
        table = table or sampling.table(self.nodes, samples.tabulated)
        wanted = _touching(np.compress(split, marked, axis=mode), 1 - mode, size[1 - mode])
        middles = (0.5 * (node[:-1] + node[1:]))[split]
        points = amplitude_pairs(*self._with_nodes(mode, middles), self.modes)
        surface = table.terms(points)
        lines, near = _lines_between(self, samples, mode, surface, wanted, smooth=sampling.kept)
        if wanted.any():
            exact = sampling.at(points[wanted], near) if known is None else known
            lines = lines.taken(wanted, exact)
        off = surface - lines.tabulated
        error = sampling.errors(table, points, off, lines.tabulated)
        found = replace(self, samples=samples)
        return found._cut(mode, middles, lines, np.where(wanted, error, 0.0), tolerance)

    def _cut(
        self, mode: int, middles: Floats, lines: NodeSamples, error: Floats, tolerance: float
    ) -> Grid:
        """Return the grid with new lines at the midpoints, where samples have these errors."""
        split, axis = self.marked[mode].any(axis=1 - mode), 1 + mode
        halved = (split, slice(None)) if mode == 0 else (slice(None), split)
        marked, before = self.marked[mode][halved], self.error_before[mode][halved]
        worst = in_cells(error, 1 - mode)
        known = np.isfinite(before) & (before > 0.0)
        rate = np.divide(worst, before, out=np.ones_like(worst), where=known)
        expected = worst * np.minimum(_CAUTION * np.maximum(rate, _LEAST_LEFT), 1.0)
        still, errors = self.marked.copy(), self.error_before.copy()
        left = self.expected_error.copy()
        still[mode][halved] = marked & (expected > tolerance)
        errors[mode][halved] = np.where(marked, worst, before)
        left[mode][halved] = np.where(marked, expected, left[mode][halved])
        node = np.append(self.nodes[mode], middles)
        order = np.argsort(node, kind="stable")
        node, parts = node[order], np.where(split, 2, 1)
        still = np.repeat(still, parts, axis)
        # A kink next to a cell bends the surface in it too, and may be visible only there.
        still[mode] = _widened(_widened(still[mode]).T).T & self._wide(node, mode)
        return replace(
            self,
            nodes=self._with_nodes(mode, node),
            marked=still,
            error_before=np.repeat(errors, parts, axis),
            expected_error=np.repeat(left, parts, axis),
            block=apart(
                *(np.repeat(each, parts, mode) for each in (self.block, self.marked[mode]))
            ),
            samples=self.samples.merged(lines, mode, order),
        )

    def marked_at(self, points: Floats, indicators: Floats) -> Grid:
        """Return the grid with cells that contain points (points, modes) marked, too.

        `indicators` (modes, n_a, n_b) are those at nodes. An axis with less than a quarter of the
        larger one is not halved.
        """
        place = self.cells(points)
        there = np.array([in_cells(in_cells(along, 0), 1)[place] for along in indicators])
        indicated = there >= 0.25 * there.max(axis=0)
        marked = self.marked.copy()
        for mode in range(self.modes):
            held = np.zeros_like(marked[mode])
            held[tuple(index[indicated[mode]] for index in place)] = True
            marked[mode] |= held & self._wide(self.nodes[mode], mode)
        return replace(self, marked=marked)

    def _with_nodes(self, mode: int, node: Floats) -> tuple[Floats, Floats]:
        """Return the nodes of both modes, with others of one."""
        return (node, self.nodes[1]) if mode == 0 else (self.nodes[0], node)

    def _wide(self, node: Floats, mode: int) -> Flags:
        """Return which intervals of a mode are wide enough to be halved, as a grid."""
        wide = np.diff(node) >= 2.0 * self.closest * node[1:]
        return np.asarray(wide[:, np.newaxis] if mode == 0 else wide)


@frozen
class Blocks:
    """Rectangles of cells without samples between them."""

    number: NDArray[np.int64]  # (blocks,), ascending
    low: Floats  # (blocks, modes)
    high: Floats  # (blocks, modes)
    indicator: Floats  # (blocks,), interpolation error indicator

    @property
    def width(self) -> Floats:
        """Width of each block, (blocks, modes)."""
        return self.high - self.low

    @property
    def middle(self) -> Floats:
        """Middle of each block, (blocks, modes)."""
        return 0.5 * (self.low + self.high)

    @classmethod
    def of(cls, axes: Sequence[Floats], block: NDArray[np.int64], indicator: Floats) -> Self:
        """Return the blocks from the block number of each cell and its indicator."""
        cells = np.indices(block.shape)[: len(axes)].reshape(len(axes), -1)
        start = np.stack([node[i] for node, i in zip(axes, cells, strict=True)], axis=-1)
        end = np.stack([node[i + 1] for node, i in zip(axes, cells, strict=True)], axis=-1)
        numbers, first, of_cell = np.unique(block, return_index=True, return_inverse=True)
        of_cell = of_cell.ravel()
        low, high, most = start[first], end[first], np.zeros(len(first))
        np.maximum.at(high, of_cell, end)
        np.maximum.at(most, of_cell, indicator.ravel())
        return cls(numbers, low, high, most)


def apart(block: NDArray[np.int64], cells: Flags) -> NDArray[np.int64]:
    """Return block numbers in which each of `cells` is a block of its own.

    The rest of the blocks that contained them is cut into rectangles.
    """
    block, most = block.copy(), int(block.max())
    for number in np.intersect1d(block[cells], block[~cells]):
        i, j = np.nonzero(block == number)
        window = np.s_[i[0] : i[-1] + 1, j[0] : j[-1] + 1]
        inside = cells[window]
        along = np.append(0, (inside[1:] != inside[:-1]).any(axis=1).cumsum())
        across = np.pad((inside[:, 1:] != inside[:, :-1]).cumsum(axis=1), ((0, 0), (1, 0)))
        block[window] = most + 1 + along[:, np.newaxis] * inside.shape[1] + across
        most += inside.size
    block[cells] = most + 1 + np.arange(cells.sum())
    return block


def in_cells(values: Floats, axis: int) -> Floats:
    """Return the larger of the values at the two ends of each cell along an axis."""
    if values.shape[axis] == 1:
        return values
    along = values.swapaxes(0, axis)
    return np.maximum(along[:-1], along[1:]).swapaxes(0, axis)


def _lines_between(
    grid: Grid,
    samples: NodeSamples,
    mode: int,
    surface: Complexes,
    wanted: Flags,
    *,
    smooth: bool,
) -> tuple[NodeSamples, Complexes]:
    """Return lines of nodes midway along a mode's axis, on the surface, and what they carry.

    The latter (points, carried) is for the nodes that are to be sampled: the mean of their
    neighbours', and the other nodes refer to the node before. Or `smooth`: from cubics that keep
    their signs and go no further than the neighbours.
    """
    (at,) = np.nonzero(grid.marked[mode].any(axis=1 - mode))
    before, after = samples.row.take(at, mode), samples.row.take(at + 1, mode)
    nothing = np.zeros_like(wanted)
    if not smooth:
        near = 0.5 * (samples.rows[before[wanted]] + samples.rows[after[wanted]])
        return NodeSamples(surface, before, samples.rows, nothing), near

    node = grid.nodes[mode]
    cubics = scipy.interpolate.PchipInterpolator(node, samples.carried.view(float), axis=mode)
    middles = (0.5 * (node[:-1] + node[1:]))[at]
    between = np.ascontiguousarray(cubics(middles)).view(complex)
    rows = np.concatenate((samples.rows, between.reshape(before.size, -1)))
    row = len(samples.rows) + np.arange(before.size).reshape(before.shape)
    return NodeSamples(surface, row, rows, nothing), between[wanted]


def _widened(cells: Flags) -> Flags:
    """Return marked cells and their neighbours along the first axis."""
    padded = np.pad(cells, ((1, 1), (0, 0)))
    return np.asarray(padded[:-2] | padded[1:-1] | padded[2:])


def _touching(cells: Flags, axis: int, nodes: int) -> Flags:
    """Return the nodes along an axis at which a marked cell begins or ends."""
    if nodes == 1:
        return cells
    padded = np.pad(cells.swapaxes(0, axis), ((1, 1), (0, 0)))
    return np.asarray(padded[:-1] | padded[1:]).swapaxes(0, axis)
