"""Blocks of a grid: rectangles sampled at their corners only, whatever grid lines cross them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import frozen


@frozen
class Blocks:
    """Rectangles of cells without samples between them.

    Attributes
    ----------
    number : (blocks,) ndarray of int
        Ascending.
    low, width : (blocks, modes) ndarray
    middle : (blocks, modes) ndarray
    indicator : (blocks,) ndarray
        Interpolation error indicator.
    """

    number: NDArray[np.int64]
    low: Floats
    width: Floats
    middle: Floats
    indicator: Floats

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
        return cls(numbers, low, high - low, 0.5 * (low + high), most)


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
