"""Points where the error of a table is measured.

Some points are spread evenly. Most are in the blocks that kinks cross, since the error of a kink
decays fast outside these, and in the blocks with the largest error indicator: where nodes are
predicted badly by their neighbours, or where samples differed from the surface. The worst blocks
are checked at several places. Blocks are the unit, not cells: grid lines without samples on them
say nothing about the error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.table.refinement.blocks import Blocks

_SPREAD = (8, 16)  # points for one mode, for two
_ONSETS = 32  # points at most where contacts yield, or a share of the blocks
_NEAR = 0.25  # of a block: distance of a kink that affects it
_INDICATED = (32, 64)  # points at least by the indicator, for one mode, for two
_BLOCKS_PER_INDICATED = (1, 32)
_BLOCKS_PER_ONSET = 32
_BLOCKS_ALL_OVER = 3  # with the largest indicator
_ALL_OVER = (0.2, 0.5, 0.8)  # places along each axis of such a block
_NEARBY = 0.1  # of a block: distance of check points that tell the same
AROUND = (0.25, 0.12)  # of a block, around the largest error, then around the largest again
_WORST = (4, 1)  # blocks checked around their largest error, for one mode, for two
_OTHERS = 4  # errors next to the largest that extrapolate to the end of the distribution
_LEAST_BEYOND = 0.5  # of the largest, see `largest_error`


def spread_points(amplitude_range: Floats) -> Floats:
    """Return points spread evenly over [0, amplitude_range], (points, modes)."""
    modes = amplitude_range.size
    return np.asarray(_halton(_SPREAD[modes - 1], modes) * amplitude_range)


def first_onsets(lines: Floats, amplitude_range: Floats) -> Floats:
    """Return where the first contact begins to slip in each mode alone, (points, modes).

    Errors of a kink are the largest there, relative to the amplitude. `lines` as `onset_points`.
    """
    steepest = lines.max(axis=0, initial=0.0)
    reached = steepest * amplitude_range > 1.0
    return np.asarray(np.diag(1.0 / np.where(reached, steepest, 1.0))[reached])


def unpredicted(node: Floats, values: Complexes) -> Floats:
    """Return |values - cubic through two neighbours on either side|, of the shape of values.

    Along the first axis; at its ends through the nearest four. 0 at node = 0, where all harmonics
    are known.
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
    """Return the largest value at the corners of each cell, (n_a - 1, n_b - 1).

    Of nodes (n_a, n_b). With one mode, n_b = 1, of each interval, (n_a - 1, 1).
    """
    along = np.maximum(nodes[:-1], nodes[1:])
    return along if nodes.shape[1] == 1 else np.maximum(along[:, :-1], along[:, 1:])


def holding_cells(axes: Sequence[Floats], points: Floats) -> tuple[NDArray[np.intp], ...]:
    """Return the indices along each axis of the cells that contain points (points, modes)."""
    return tuple(
        np.searchsorted(node[1:-1], place) for node, place in zip(axes, points.T, strict=True)
    )


def onset_points(blocks: Blocks, lines: Floats, checked: Floats) -> Floats:
    """Return the middles of blocks that kinks cross or come close to, (points, modes).

    Blocks with a `checked` point close to the middle are left out. Errors in these blocks decay
    irregularly as cells are halved, so that a small error in one says nothing about the next. On
    the kink itself they may be small, too.

    Parameters
    ----------
    blocks : Blocks
    lines : (lines, modes) ndarray
        Normals n of kinks n @ |a| = 1.
    checked : (points, modes) ndarray
    """
    begin, across = blocks.low @ lines.T, blocks.width @ lines.T
    near = (begin - _NEAR * across <= 1.0) & (begin + (1.0 + _NEAR) * across >= 1.0)
    found = _new_middles(blocks, np.any(near, axis=1), checked)
    count = min(len(found), max(_ONSETS, len(blocks.number) // _BLOCKS_PER_ONSET))
    return found[np.arange(count) * len(found) // max(count, 1)]


def indicated_points(blocks: Blocks, lines: Floats, checked: Floats) -> Floats:
    """Return points in the blocks of the largest indicator, none close to a `checked` one.

    (points, modes). A block that one of `lines`, see `onset_points`, crosses is checked there too.
    """
    modes = checked.shape[1]
    count = max(_INDICATED[modes - 1], len(blocks.indicator) // _BLOCKS_PER_INDICATED[modes - 1])
    all_over = np.stack(np.meshgrid(*modes * [_ALL_OVER]), axis=-1).reshape(-1, modes)
    ranked = np.argsort(-blocks.indicator, kind="stable")
    most, others = ranked[:_BLOCKS_ALL_OVER], ranked[_BLOCKS_ALL_OVER:]
    places = np.stack((blocks.middle, _on_kink(blocks, lines)), axis=1)
    low, width = blocks.low[most, np.newaxis], blocks.width[most, np.newaxis]
    tried = np.concatenate(
        ((low + width * all_over).reshape(-1, modes), places[others].reshape(-1, modes))
    )
    of_block = np.append(np.repeat(most, len(all_over)), np.repeat(others, 2))
    return _new(tried, blocks.width[of_block], checked, count)


def places_around(
    blocks: Blocks, holding: NDArray[np.int64], points: Floats, errors: Floats, share: float
) -> Floats:
    """Return points at a share of the block to either side of the largest error in a few blocks.

    Along each axis; `holding` (points,) are the numbers of the blocks that contain the points.
    """
    modes = points.shape[1]
    order = np.argsort(-errors, kind="stable")
    _, first = np.unique(holding[order], return_index=True)
    worst = order[np.sort(first)[: _WORST[modes - 1]]]
    at = np.searchsorted(blocks.number, holding[worst])
    low, width = blocks.low[at, np.newaxis], blocks.width[at, np.newaxis]
    steps = share * np.concatenate((-np.eye(modes), np.eye(modes))) * width
    return np.clip(points[worst, np.newaxis] + steps, low, low + width).reshape(-1, modes)


def points_beside(blocks: Blocks, numbers: NDArray[np.int64], checked: Floats) -> Floats:
    """Return the middles of the blocks that touch some blocks, none close to a `checked` point."""
    at = np.searchsorted(blocks.number, np.unique(numbers))
    end = blocks.low + blocks.width
    touched = np.zeros(len(end), dtype=bool)
    for low, high in zip(blocks.low[at], end[at], strict=True):
        touched |= ((blocks.low <= high) & (end >= low)).all(axis=1)
    return _new_middles(blocks, touched, checked)


def largest_error(errors: Floats, noise: float) -> float:
    """Return the largest error of a table from the errors at its check points.

    The end of the distribution is extrapolated: it lies about as far beyond the largest error as
    the next few lie below it (Robson and Whitlock 1964), but at least `_LEAST_BEYOND` of the
    largest, for dense checks of 58 tables found up to 1.32 times the largest error, and `noise`,
    the error of samples.
    """
    worst = np.sort(errors)[-1 - _OTHERS :]
    return float(worst[-1] + max(worst[-1] - worst[0], _LEAST_BEYOND * worst[-1], noise))


def _new_middles(blocks: Blocks, chosen: Flags, checked: Floats) -> Floats:
    """Return middles of chosen blocks that are close to no `checked` point, nor to each other."""
    return _new(blocks.middle[chosen], blocks.width[chosen], checked, len(blocks.number))


def _new(places: Floats, width: Floats, checked: Floats, count: int) -> Floats:
    """Return the first `count` places (places, modes) in blocks of a `width` (places, modes).

    Places close to a `checked` point or to a place before are left out.
    """
    reach = _NEARBY * width
    near = np.ones((len(places), len(checked)), dtype=bool)
    for place, point, within in zip(places.T, checked.T, reach.T, strict=True):
        near &= np.abs(place[:, np.newaxis] - point) <= within[:, np.newaxis]
    left = ~near.any(axis=1)
    found: list[int] = []
    while left.any() and len(found) < count:
        found.append(int(left.argmax()))
        left &= (np.abs(places - places[found[-1]]) > reach).any(axis=1)
        left[found[-1]] = False
    return np.asarray(places[found])


def _on_kink(blocks: Blocks, lines: Floats) -> Floats:
    """Return the point of a line that is closest to the middle of each block, (blocks, modes).

    The middle where no line crosses.
    """
    places = blocks.middle.copy()
    if not lines.size:
        return places
    normal = lines * blocks.width[:, np.newaxis]  # blocks, lines, modes
    square = (normal**2).sum(axis=-1)
    short = 1.0 - (blocks.low + 0.5 * blocks.width) @ lines.T
    to_line = normal * (short / np.where(square > 0.0, square, np.inf))[..., np.newaxis]
    distance = np.where(square > 0.0, np.abs(to_line).max(axis=-1), np.inf)
    nearest = distance.argmin(axis=1)
    each = np.arange(len(places))
    crossed = distance[each, nearest] < 0.5
    share = 0.5 + to_line[each, nearest][crossed]
    places[crossed] = blocks.low[crossed] + blocks.width[crossed] * share
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
