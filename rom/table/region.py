"""The region of the amplitude plane where a friction table has to hold: along a trajectory.

The plane is divided evenly into tiles, and those that the trajectory comes near are marked. Tiles,
not the trajectory itself, say what is tabulated, so that like trajectories share a table. Grid
lines of a table halve an even grid again and again, so cells are made of tiles or tiles of cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr

_TILES = 32  # per amplitude


@dataclass(frozen=True, eq=False)
class Region:
    """Marked tiles of [0, range_A] x [0, range_B].

    Attributes
    ----------
    tiles : (n, n) ndarray of bool
    amplitude_range : (2,) ndarray
        Largest amplitudes of the plane [kg^1/2 m].
    """

    tiles: Flags
    amplitude_range: Floats

    __repr__ = short_repr

    @classmethod
    def along(cls, path: Floats, amplitude_range: Sequence[float], reach: Floats) -> Region:
        """Tiles within `reach` (2,) of a path (points, 2) of amplitudes, at least two.

        Between two points the path stays in the box that has them as corners. A component is made
        at rest, wherever it is started then: the tile at the origin is marked as well.
        """
        scale = _TILES / np.asarray(amplitude_range, dtype=float)
        first = np.floor(scale * (np.minimum(path[:-1], path[1:]) - reach)).astype(int)
        end = np.floor(scale * (np.maximum(path[:-1], path[1:]) + reach)).astype(int) + 1
        (a, b), (end_a, end_b) = np.clip(first, 0, _TILES).T, np.clip(end, 0, _TILES).T
        # each box as four steps of a function, which is summed up along both axes
        steps = np.zeros((_TILES + 1, _TILES + 1), dtype=int)
        for rows, columns, sign in ((a, b, 1), (end_a, end_b, 1), (a, end_b, -1), (end_a, b, -1)):
            np.add.at(steps, (rows, columns), sign)
        tiles = steps.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0
        tiles[0, 0] = True
        return cls(tiles, np.array(amplitude_range, dtype=float))

    @property
    def share(self) -> float:
        """Marked part of the plane."""
        return float(self.tiles.mean())

    def cells(self, node_a: Floats, node_b: Floats) -> Flags:
        """Cells of a grid that overlap a marked tile, (n_a - 1, n_b - 1)."""
        marked = np.zeros((_TILES + 1, _TILES + 1), dtype=int)
        marked[1:, 1:] = self.tiles.cumsum(axis=0).cumsum(axis=1)
        (low_a, high_a), (low_b, high_b) = (
            _tile_range(node * (_TILES / end))
            for node, end in zip((node_a, node_b), self.amplitude_range, strict=True)
        )
        count = marked[np.ix_(high_a, high_b)] - marked[np.ix_(low_a, high_b)]
        count += marked[np.ix_(low_a, low_b)] - marked[np.ix_(high_a, low_b)]
        return np.asarray(count > 0)

    def holds(self, points: Floats) -> Flags:
        """Whether points (n, 2) of the plane lie in marked tiles, (n,)."""
        tile = np.minimum((points * (_TILES / self.amplitude_range)).astype(int), _TILES - 1)
        return np.asarray(self.tiles[tile[:, 0], tile[:, 1]])


def corners(cells: Flags) -> Flags:
    """Nodes (n_a, n_b) at the corners of marked cells (n_a - 1, n_b - 1)."""
    around = np.pad(cells, 1)
    return np.asarray(around[:-1, :-1] | around[:-1, 1:] | around[1:, :-1] | around[1:, 1:])


def with_neighbours(nodes: Flags) -> Flags:
    """Marked nodes and the eight around each."""
    along = widened(nodes)
    return widened(along.T).T


def widened(nodes: Flags) -> Flags:
    """Marked nodes and those next to them along the first axis."""
    wide = nodes.copy()
    wide[1:] |= nodes[:-1]
    wide[:-1] |= nodes[1:]
    return wide


def _tile_range(node: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First tile of each interval and the one after its last, for nodes in units of tiles."""
    place = np.round(node, 6)  # a line on the edge of a tile is in neither
    return np.floor(place[:-1]).astype(int), np.ceil(place[1:]).astype(int)
