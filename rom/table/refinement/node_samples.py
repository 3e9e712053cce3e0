"""Samples at the nodes of a grid: what is tabulated, and what is carried along with it.

There are many more carried columns than tabulated ones, and far fewer samples than nodes: those
are kept in rows, to which the nodes refer.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.refinement.grid import Grid


@frozen
class NodeSamples:
    """Those of a grid, or of some of its lines.

    Attributes
    ----------
    tabulated : (n_a, n_b, columns) complex ndarray
    rows : (rows, carried) complex ndarray
    row : (n_a, n_b) ndarray of int
        Of `rows`, at each node.
    """

    tabulated: Complexes
    rows: Complexes
    row: NDArray[np.int64]

    @classmethod
    def of(cls, samples: Complexes, tabulated: int) -> Self:
        """From samples (n_a, n_b, columns) of which the first ones are `tabulated`."""
        *nodes, columns = samples.shape
        row = np.arange(samples[..., 0].size).reshape(nodes)
        rows = samples[..., tabulated:].reshape(row.size, columns - tabulated)
        return cls(samples[..., :tabulated], rows, row)

    @property
    def carried(self) -> Complexes:
        """The columns that are not tabulated, (n_a, n_b, carried)."""
        return np.asarray(self.rows[self.row])

    def taken(self, nodes: Flags, samples: Complexes) -> NodeSamples:
        """With samples (points, columns) at some of the nodes."""
        tabulated, row = self.tabulated.copy(), self.row.copy()
        own, further = np.split(samples, [tabulated.shape[-1]], axis=1)
        tabulated[nodes] = own
        row[nodes] = len(self.rows) + np.arange(len(samples))
        return NodeSamples(tabulated, np.concatenate((self.rows, further)), row)

    def middles(
        self, grid: Grid, mode: int, surface: Complexes, sampled: Flags, *, smooth: bool
    ) -> tuple[NodeSamples, Complexes]:
        """Lines of new nodes midway along a mode's axis, on the surface; about what they carry.

        The latter (points, carried) is for those that are to be `sampled`, the mean of their
        neighbours'; the others refer to the node before. Or `smooth`: cubics that keep their signs
        and go no further than they do.
        """
        (at,) = np.nonzero(grid.split(mode))
        before, after = self.row.take(at, mode), self.row.take(at + 1, mode)
        if not smooth:
            near = 0.5 * (self.rows[before[sampled]] + self.rows[after[sampled]])
            return NodeSamples(surface, self.rows, before), near
        from scipy.interpolate import PchipInterpolator  # takes long to import

        cubics = PchipInterpolator(grid.nodes[mode], self.carried.view(float), axis=mode)
        between = np.ascontiguousarray(cubics(grid.middles(mode))).view(complex)
        rows = np.concatenate((self.rows, between.reshape(before.size, -1)))
        row = len(self.rows) + np.arange(before.size).reshape(before.shape)
        return NodeSamples(surface, rows, row), between[sampled]

    def with_lines(self, mode: int, new: Flags, lines: NodeSamples) -> NodeSamples:
        """With new lines across a mode's axis, made from these; `new` are the flags of all."""

        def merged(own: np.ndarray, added: np.ndarray) -> np.ndarray:
            shape = list(own.shape)
            shape[mode] = new.size
            both = np.empty(shape, dtype=own.dtype)
            lines = np.moveaxis(both, mode, 0)
            lines[~new], lines[new] = np.moveaxis(own, mode, 0), np.moveaxis(added, mode, 0)
            return both

        row = merged(self.row, lines.row)
        return NodeSamples(merged(self.tabulated, lines.tabulated), lines.rows, row)
