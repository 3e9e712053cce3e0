"""The amplitude grid: dense where the slip threshold bends the surface, coarse elsewhere.

Grid lines are halved where the surface through the present nodes misses new samples by more than
the tolerance. Every sample becomes a node, so nothing is computed only to be checked; an
independent set of points measures the error of the finished table.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.stats import qmc

from rom.errors import SlipmodeError
from rom.matrices import Floats
from rom.tables import Complexes, Table, make_table

Sampler = Callable[[Floats], Complexes]

_FIRST_INTERVALS = 8
_MAX_ROUNDS = 14
_CHECK_POINTS = 64


def refine(sample: Sampler, limit: Floats, tolerance: float) -> tuple[Table, float]:
    """Tabulate `sample` over [0, limit] to a tolerance relative to the largest |S_j|.

    Parameters
    ----------
    sample : callable
        Friction terms S (points, modes) at amplitudes (points, modes).
    limit : (modes,) ndarray
    tolerance : float

    Returns
    -------
    table : Table
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
    S = _sample_product(sample, axes[0], axes[1], modes)
    flagged = [np.ones(axis.size - 1, dtype=bool) for axis in axes[:modes]]
    check_points = qmc.Halton(modes, scramble=False).random(_CHECK_POINTS + 1)[1:] * limit
    checks = sample(check_points)
    for _ in range(_MAX_ROUNDS):
        for axis in range(modes):
            axes, S, flagged[axis] = _halve(sample, axes, S, axis, flagged[axis], tolerance)
        table = make_table(axes[0], axes[1], S)
        errors = _relative(np.abs(table(check_points) - checks), S)
        if not any(flags.any() for flags in flagged):
            missed = errors > tolerance
            if not missed.any():
                return table, float(errors.max())
            for axis in range(modes):
                flagged[axis] |= _cells_of(check_points[missed, axis], axes[axis])
    raise SlipmodeError(
        f"tolerance: the friction table misses {tolerance:g} by a factor of "
        f"{errors.max() / tolerance:.1f} after {_MAX_ROUNDS} refinements; allow a larger "
        "tolerance or a larger alpha"
    )


def _halve(
    sample: Sampler,
    axes: list[Floats],
    S: Complexes,
    axis: int,
    flagged: np.ndarray,
    tolerance: float,
) -> tuple[list[Floats], Complexes, np.ndarray]:
    """Insert the midpoints of flagged intervals along one axis; flag the halves that need more."""
    if not flagged.any():
        return axes, S, flagged
    node = axes[axis]
    middle = 0.5 * (node[:-1] + node[1:])[flagged]
    modes = S.shape[-1]
    new_axes = [middle, axes[1]] if axis == 0 else [axes[0], middle]
    fresh = _sample_product(sample, new_axes[0], new_axes[1], modes)
    guess = make_table(axes[0], axes[1], S)(_product(new_axes[0], new_axes[1], modes))
    surplus = _relative(np.abs(guess - fresh.reshape(guess.shape)), S).reshape(fresh.shape[:2])
    poor = surplus.max(axis=1 - axis) > tolerance
    order = np.argsort(np.concatenate((node, middle)), kind="stable")
    merged = np.take(np.concatenate((S, fresh), axis=axis), order, axis=axis)
    refined = list(axes)
    refined[axis] = np.concatenate((node, middle))[order]
    still = np.zeros(flagged.size, dtype=bool)
    still[flagged] = poor
    return refined, merged, np.repeat(still, np.where(flagged, 2, 1))


def _product(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Amplitude pairs (n_a n_b, modes) of a grid."""
    grid = np.stack(np.meshgrid(node_a, node_b, indexing="ij"), axis=-1)
    return grid.reshape(-1, 2)[:, :modes]


def _sample_product(sample: Sampler, node_a: Floats, node_b: Floats, modes: int) -> Complexes:
    return sample(_product(node_a, node_b, modes)).reshape(node_a.size, node_b.size, modes)


def _relative(difference: Floats, S: Complexes) -> Floats:
    """Largest difference over the modes, each relative to its largest |S_j|."""
    largest = np.abs(S).max(axis=(0, 1))
    scale = np.where(largest > 0.0, largest, 1.0)
    return np.asarray((difference / scale).max(axis=-1))


def _cells_of(points: Floats, node: Floats) -> np.ndarray:
    """Which intervals of `node` hold a point."""
    cells = np.zeros(node.size - 1, dtype=bool)
    cells[np.clip(np.searchsorted(node, points) - 1, 0, node.size - 2)] = True
    return cells
