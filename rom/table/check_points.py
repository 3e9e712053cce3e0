"""Where the error of a table is measured: spread evenly, where contacts yield, where in doubt.

A few even points miss most of what a kink does: it is felt in the cells that it crosses, and
falls fast beside it. So most points are where the surface is doubted most, where its nodes are
least predicted by their neighbours; the worst cells are gone through at several places.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats

_SPREAD = (8, 16)  # points for one mode, for two
_ONSETS = 32  # points at most where contacts yield
_DOUBTS = (32, 64)  # points at least where in doubt, for one mode, for two
_CELLS_PER_DOUBT = (1, 32)
_CELLS_ALL_OVER = 3  # that are doubted most
_ALL_OVER = (0.2, 0.5, 0.8)  # places along each axis of such a cell
_NEARBY = 0.1  # of a cell: what is checked there need not be checked again
AROUND = (0.25, 0.12)  # of a cell, around the largest error, then around the largest again
_WORST = (4, 1)  # cells whose largest errors are gone around, for one mode, for two
_OTHERS = 4  # errors beside the largest that tell what lies beyond it
_LEAST_BEYOND = 0.5  # of the largest, see `largest_error`


def spread_points(
    amplitude_range: Floats, inside: Callable[[Floats], Flags] | None = None
) -> Floats:
    """Evenly over [0, amplitude_range], or over what is `inside` of it, (points, modes)."""
    modes = amplitude_range.size
    count = wanted = _SPREAD[modes - 1]
    while True:
        points = _halton(count, modes) * amplitude_range
        kept = points if inside is None else points[inside(points)]
        if len(kept) >= wanted:
            return np.asarray(kept[:wanted])
        count *= 2


def onset_points(lines: Floats, amplitude_range: Floats) -> Floats:
    """On lines n @ |a| = 1 of normals (lines, modes), in [0, amplitude_range]; (points, modes)."""
    normals = lines * amplitude_range
    normals = normals[normals.sum(axis=1) > 1.0]
    if not normals.size:
        return np.zeros((0, amplitude_range.size))
    count = _ONSETS if amplitude_range.size == 2 else min(_ONSETS, len(normals))
    normals = normals[np.arange(count) * len(normals) // count]
    if amplitude_range.size == 1:
        return np.asarray(amplitude_range / normals)
    # along the axis that the line is more parallel to, from where it enters the range
    steep, flat = normals.max(axis=1), normals.min(axis=1)
    with np.errstate(divide="ignore"):
        first, last = np.maximum((1.0 - steep) / flat, 0.0), np.minimum(1.0 / flat, 1.0)
    # a kink is sharpest at the ends, where one mode moves the contact alone
    along = first + (last - first) * (0.5 - 0.5 * np.cos(np.pi * _halton(count, 1)[:, 0]))
    across = (1.0 - flat * along) / steep
    steeper = normals[:, :1] >= normals[:, 1:]
    points = np.where(steeper, np.stack((across, along), 1), np.stack((along, across), 1))
    return np.asarray(points * amplitude_range)


def unpredicted(node: Floats, values: Complexes) -> Floats:
    """|values - what the cubic through two neighbours on either side has there|, as values.

    Along the first axis; at its ends through the nearest four. Nothing at node = 0, where all
    harmonics are known.
    """
    here = np.arange(1, node.size)[:, np.newaxis]
    window = np.clip(here - 2, 0, node.size - 5) + np.arange(5)
    others = window[window != here].reshape(-1, 4)
    own, known = np.eye(4, dtype=bool), node[others]
    apart = np.where(own, 1.0, known[:, :, np.newaxis] - known[:, np.newaxis])
    reach = np.where(own, 1.0, (node[here] - known)[:, np.newaxis])
    weights = np.eye(node.size)
    weights[here, others] = -np.prod(reach / apart, axis=2)
    weights[0] = 0.0
    return np.asarray(np.abs(np.tensordot(weights, values, axes=1)))


def at_cells(nodes: Floats) -> Floats:
    """Largest value at the corners of each cell, (n_a - 1, n_b - 1), of nodes (n_a, n_b).

    Of one mode, n_b = 1, that of each interval, (n_a - 1, 1).
    """
    along = np.maximum(nodes[:-1], nodes[1:])
    return along if nodes.shape[1] == 1 else np.maximum(along[:, :-1], along[:, 1:])


def holding_cells(axes: Sequence[Floats], points: Floats) -> tuple[NDArray[np.intp], ...]:
    """Index along each axis of the cells that hold points (points, modes)."""
    return tuple(
        np.clip(np.searchsorted(node, place) - 1, 0, node.size - 2)
        for node, place in zip(axes, points.T, strict=True)
    )


def doubtful_points(
    axes: Sequence[Floats], doubt: Floats, lines: Floats, checked: Floats
) -> Floats:
    """Points in the cells of most doubt, none next to a `checked` one, (points, modes).

    Parameters
    ----------
    axes : sequence of (n_j,) ndarray
        Nodes of each mode.
    doubt : ndarray
        Of the cells, as `at_cells` has them; those without any are left alone.
    lines : (lines, modes) ndarray
        Normals n of kinks n @ |a| = 1: a cell that one crosses is checked there too.
    checked : (points, modes) ndarray
    """
    modes = len(axes)
    count = max(_DOUBTS[modes - 1], doubt.size // _CELLS_PER_DOUBT[modes - 1])
    cells = np.argsort(-doubt, axis=None, kind="stable")[: count + len(checked)]
    index = np.unravel_index(cells[doubt.ravel()[cells] > 0.0], doubt.shape)[:modes]
    low = np.stack([node[i] for node, i in zip(axes, index, strict=True)], axis=-1)
    width = np.stack([np.diff(node)[i] for node, i in zip(axes, index, strict=True)], axis=-1)
    all_over = np.stack(np.meshgrid(*modes * [_ALL_OVER]), axis=-1).reshape(-1, modes)
    taken = checked
    for number, places in enumerate(_middle_and_kink(low, width, lines)):
        if len(taken) >= len(checked) + count:
            break
        for place in low[number] + width[number] * (
            all_over if number < _CELLS_ALL_OVER else places
        ):
            if (np.abs(taken - place) > _NEARBY * width[number]).any(axis=1).all():
                taken = np.concatenate((taken, place[np.newaxis]))
    return taken[len(checked) :]


def worst_points(axes: Sequence[Floats], points: Floats, errors: Floats) -> Floats:
    """Those of the largest errors in a few cells, (cells, modes)."""
    order = np.argsort(-errors, kind="stable")
    cells = np.stack(holding_cells(axes, points[order]), axis=-1)
    _, first = np.unique(cells, axis=0, return_index=True)
    return np.asarray(points[order[np.sort(first)[: _WORST[len(axes) - 1]]]])


def around(axes: Sequence[Floats], point: Floats, share: float) -> Floats:
    """Places by a share of its cell to either side of a point (modes,), along each axis."""
    points = np.tile(point, (2 * point.size, 1))
    cell = holding_cells(axes, point[np.newaxis])
    for j, (node, (i,)) in enumerate(zip(axes, cell, strict=True)):
        shift = share * (node[i + 1] - node[i])
        points[2 * j : 2 * j + 2, j] += -shift, shift
        points[:, j] = np.clip(points[:, j], node[i], node[i + 1])
    return points


def largest_error(errors: Floats, noise: float) -> float:
    """Largest error of a table, from those at its check points; samples are off by `noise`.

    These are the upper end of a sample: beyond its largest lies about as much as between it and
    the few after it (Robson and Whitlock's estimate of where a distribution ends). Where these
    are alike a better place in the cell, or a kink less fortunate, has more: of dense checks of 77
    tables one found 1.44 and one 1.27 times as much, with the noise of samples; no other 1.12.
    """
    worst = np.sort(errors)[-1 - _OTHERS :]
    return float(worst[-1] + max(worst[-1] - worst[0], _LEAST_BEYOND * worst[-1], noise))


def _middle_and_kink(low: Floats, width: Floats, lines: Floats) -> Floats:
    """Of cells, the middle and the place of a line nearest to it, (cells, 2, modes).

    In units of the cell; twice the middle where no line crosses.
    """
    places = np.full((len(low), 2, low.shape[1]), 0.5)
    if not lines.size:
        return places
    normal = lines * width[:, np.newaxis]  # cells, lines, modes
    square = (normal**2).sum(axis=-1)
    short = 1.0 - (low + 0.5 * width) @ lines.T
    to_line = normal * (short / np.where(square > 0.0, square, np.inf))[..., np.newaxis]
    distance = np.where(square > 0.0, np.abs(to_line).max(axis=-1), np.inf)
    nearest = distance.argmin(axis=1)
    cell = np.arange(len(low))
    crossed = distance[cell, nearest] < 0.5
    places[crossed, 1] += to_line[cell, nearest][crossed]
    return places


def _halton(count: int, dimensions: int) -> Floats:
    """The first points of the Halton sequence, (count, dimensions), without its origin.

    As scipy.stats has it, whose import takes longer than many a table.
    """
    points = np.zeros((count, dimensions))
    for base, column in zip((2, 3), points.T, strict=False):
        digits, place = np.arange(1, count + 1), 1.0
        while digits.any():
            place /= base
            column += place * (digits % base)
            digits //= base
    return points
