"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Grid lines are halved where the surface through the present nodes misses new samples by more than
the tolerance. Every sample becomes a node, so nothing is computed only to be checked; an
independent set of points measures the error of the finished table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rom.errors import SlipmodeError
from rom.matrices import Floats
from rom.near import Order
from rom.tables import Complexes, Table, make_table

Flags = NDArray[np.bool_]

_FIRST_INTERVALS = 8
_MAX_ROUNDS = 14
_CHECK_POINTS = 64
_MOST_NODES = 20_000


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
    loss : (modes,) ndarray
        Structural loss of each mode, see `make_table`.
    carried : int
        Further columns that are kept at the nodes but neither tabulated nor refined.
    """

    orders: tuple[Order, ...]
    drives: tuple[int, ...]
    swing: Floats
    loss: Floats
    carried: int = 0

    def error(self, difference: Floats, S: Complexes) -> Floats:
        """Largest |difference| over the tabulated columns, relative to their scales."""
        largest = np.abs(S[..., : self.swing.size]).max(axis=tuple(range(S.ndim - 1)))
        scale = np.append(largest[list(self.drives)], self.swing @ largest)
        return np.asarray((difference / np.where(scale > 0.0, scale, 1.0)).max(axis=-1))


@dataclass(frozen=True, eq=False)
class Sampling:
    """Where samples come from: values (points, columns) at amplitudes (points, modes)."""

    at: Callable[[Floats], Complexes]
    columns: Columns

    def on_grid(self, node_a: Floats, node_b: Floats, modes: int) -> Complexes:
        """Samples (n_a, n_b, columns) on a grid."""
        return self.at(_product(node_a, node_b, modes)).reshape(node_a.size, node_b.size, -1)

    def table(self, axes: list[Floats], samples: Complexes) -> Table:
        """Table through the tabulated columns of samples on a grid."""
        orders = self.columns.orders
        tabulated = samples[..., : len(orders)]
        return make_table(axes[0], axes[1], tabulated, orders, self.columns.loss)

    def error_of(self, table: Table, points: Floats, exact: Complexes) -> Floats:
        """Relative error of a table at points with samples `exact`, (points,)."""
        tabulated = exact[..., : len(self.columns.orders)]
        difference = np.abs(table.terms(points) - tabulated)
        return self.columns.error(difference, table.nodes())


def refine(sampling: Sampling, limit: Floats, tolerance: float) -> tuple[Table, Complexes, float]:
    """Tabulate over [0, limit] to a tolerance relative to the largest |S_j|.

    Parameters
    ----------
    sampling : Sampling
    limit : (modes,) ndarray
    tolerance : float

    Returns
    -------
    table : Table
    carried : (n_a, n_b, carried) complex ndarray
        The columns that are not tabulated, at the nodes.
    error : float
        Largest difference found at points that are no nodes, relative to the largest |S_j|.

    Raises
    ------
    SlipmodeError
        If halving the grid lines does not reach the tolerance.
    """
    modes = limit.size
    axes = [np.linspace(0.0, end, _FIRST_INTERVALS + 1) for end in limit]
    axes += [np.zeros(1)] * (2 - modes)
    samples = sampling.on_grid(axes[0], axes[1], modes)
    flagged = [np.ones(axis.size - 1, dtype=bool) for axis in axes[:modes]]
    check_points = _halton(_CHECK_POINTS, modes) * limit
    checks = sampling.at(check_points)
    for _ in range(_MAX_ROUNDS):
        if samples.shape[0] * samples.shape[1] > _MOST_NODES:
            break
        for axis in range(modes):
            axes, samples, flagged[axis] = _halve(
                sampling, axes, samples, axis, flagged[axis], tolerance
            )
        table = sampling.table(axes, samples)
        errors = sampling.error_of(table, check_points, checks)
        if not any(flags.any() for flags in flagged):
            missed = errors > tolerance
            if not missed.any():
                carried = samples[..., len(sampling.columns.orders) :]
                return table, carried, float(errors.max())
            for axis in range(modes):
                flagged[axis] |= _cells_of(check_points[missed, axis], axes[axis])
    raise SlipmodeError(
        f"tolerance: the friction table still misses {tolerance:g} with {samples.shape[0]} x "
        f"{samples.shape[1]} nodes (error {errors.max():.2g}); allow a larger tolerance, or a "
        "larger alpha, or make the contacts stiffer against the modes"
    )


def _halve(
    sampling: Sampling,
    axes: list[Floats],
    samples: Complexes,
    axis: int,
    flagged: Flags,
    tolerance: float,
) -> tuple[list[Floats], Complexes, Flags]:
    """Insert the midpoints of flagged intervals along one axis; flag the halves that need more."""
    if not flagged.any():
        return axes, samples, flagged
    node = axes[axis]
    middle = 0.5 * (node[:-1] + node[1:])[flagged]
    modes = len(axes) if axes[1].size > 1 else 1
    between = [middle, axes[1]] if axis == 0 else [axes[0], middle]
    fresh = sampling.on_grid(between[0], between[1], modes)
    points = _product(between[0], between[1], modes)
    table = sampling.table(axes, samples)
    surplus = sampling.error_of(table, points, fresh.reshape(len(points), -1))
    poor = surplus.reshape(fresh.shape[:2]).max(axis=1 - axis) > tolerance
    order = np.argsort(np.concatenate((node, middle)), kind="stable")
    merged = np.take(np.concatenate((samples, fresh), axis=axis), order, axis=axis)
    refined = list(axes)
    refined[axis] = np.concatenate((node, middle))[order]
    still = np.zeros(flagged.size, dtype=bool)
    still[flagged] = poor
    return refined, merged, np.repeat(still, np.where(flagged, 2, 1))


def _product(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Amplitude pairs (n_a n_b, modes) of a grid."""
    grid = np.stack(np.meshgrid(node_a, node_b, indexing="ij"), axis=-1)
    return grid.reshape(-1, 2)[:, :modes]


def _halton(count: int, dimensions: int) -> Floats:
    """The first points of the Halton sequence, (count, dimensions), without its origin."""
    points = np.zeros((count, dimensions))
    for base, column in zip((2, 3), points.T, strict=False):
        digits, place = np.arange(1, count + 1), 1.0
        while digits.any():
            place /= base
            column += place * (digits % base)
            digits //= base
    return points


def _cells_of(points: Floats, node: Floats) -> Flags:
    """Which intervals of `node` hold a point."""
    cells = np.zeros(node.size - 1, dtype=bool)
    cells[np.clip(np.searchsorted(node, points) - 1, 0, node.size - 2)] = True
    return cells
