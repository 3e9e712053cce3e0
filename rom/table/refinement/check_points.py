"""Points where the error of a table is measured.

Some points are spread evenly. Most are in the blocks that kinks cross, since the error of a kink
decays fast outside these, and in the blocks with the largest error indicator: where nodes are
predicted badly by their neighbours, or where samples differed from the surface. The worst blocks
are checked at several places. Blocks are the unit, not cells: grid lines without samples on them
say nothing about the error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.refinement.grid import Blocks, Grid, in_cells
from slipmode.rom.table.refinement.sampling import Sampling

_MOST_INDICATED = 3  # blocks with the largest indicator, which are checked all over


class Checks:
    """Samples that are no nodes, and the errors of tables there.

    `gain` is the ratio of the largest error after points around it were checked to the one before.
    Errors in other blocks, around which no points were checked, would grow by about as much.
    """

    def __init__(self, sampling: Sampling, points: Floats, exact: Complexes) -> None:
        self._sampling = sampling
        self.gain = 1.0
        self.points = points
        self._exact = exact[:, : len(sampling.orders)]

    def errors(self, grid: Grid, tolerance: float) -> tuple[Table, Floats, Floats]:
        """Add the points that the table through the samples of a grid needs.

        Returns
        -------
        table : Table
        indicators : (modes, n_a, n_b) ndarray
            Of its nodes, see `Sampling.indicators`.
        errors : (points,) ndarray
            Relative errors at all points.
        """
        sampling = self._sampling
        table = sampling.table(grid.nodes, grid.samples.tabulated)
        indicators = sampling.indicators(table)
        indicator = in_cells(in_cells(indicators.max(axis=0), 0), 1)
        blocks = Blocks.of(
            table.axes, grid.block, np.maximum(indicator, grid.expected_error.max(axis=0))
        )

        def add(points: Floats) -> tuple[Floats, NDArray[np.int64]]:
            """Add points and samples there; return the errors at all points, and their blocks.

            The initial guess of a solve is the solution at the point before: where contacts have
            two motions, solves from far away converge to another one. The table is no initial
            guess, since checks are to find a motion that it does not have.
            """
            if len(points):
                points = in_order(points)
                exact = sampling.at(points, None)[:, : len(sampling.orders)]
                self.points = np.concatenate((self.points, points))
                self._exact = np.concatenate((self._exact, exact))
            off = table.terms(self.points) - self._exact
            errors = sampling.errors(table, self.points, off, self._exact)
            return errors, grid.block[grid.cells(self.points)]

        onset = onset_points(blocks, sampling.onset_lines, self.points)
        checked = np.concatenate((self.points, onset))
        indicated = _indicated_points(blocks, sampling.onset_lines, checked)
        errors, holding = add(np.concatenate((onset, indicated)))
        # Large errors cluster: the estimates in neighbouring blocks were as wrong.
        for _ in range(8):
            bad = holding[errors > self.limit(errors, tolerance)]
            if not bad.size or not len(beside := _points_beside(blocks, bad, self.points)):
                break
            errors, holding = add(beside)
        first = errors.max()
        # of a block, around the largest error, then around the largest again
        for share in (0.25, 0.12):
            errors, holding = add(_places_around(blocks, holding, self.points, errors, share))
        self.gain = float(errors.max() / first) if first > 0.0 else 1.0
        return table, indicators, errors

    def limit(self, errors: Floats, tolerance: float) -> float:
        """Return the largest error at check points for which `largest_error` is the tolerance."""
        worst = float(errors.max())
        return tolerance * worst / max(largest_error(errors, self._sampling.noise), tolerance)


def largest_error(errors: Floats, noise: float) -> float:
    """Return the largest error of a table from the errors at its check points.

    The end of the distribution is extrapolated: it lies about as far beyond the largest error as
    the next four lie below it (Robson and Whitlock 1964), but at least half of the largest, for
    dense checks of 58 tables found up to 1.32 times the largest error, and `noise`, the error of
    samples.
    """
    worst = np.sort(errors)[-5:]
    return float(worst[-1] + max(worst[-1] - worst[0], 0.5 * worst[-1], noise))


def first_points(lines: Floats, amplitude_range: Floats) -> Floats:
    """Return the first check points: spread evenly, and at the first onset of slip.

    That is where the first contact begins to slip in each mode alone, and where errors of a kink
    are the largest, relative to the amplitude. `lines` as `onset_points`.
    """
    modes = amplitude_range.size
    spread = _halton((8, 16)[modes - 1], modes) * amplitude_range
    steepest = lines.max(axis=0, initial=0.0)
    reached = steepest * amplitude_range > 1.0
    onset = np.diag(1.0 / np.where(reached, steepest, 1.0))[reached]
    return in_order(np.concatenate((spread, onset)))


def in_order(points: Floats) -> Floats:
    """Return points (points, modes) in the order in which they are solved."""
    return np.asarray(points[np.lexsort(points.T[::-1])])


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
    near = (begin - 0.25 * across <= 1.0) & (begin + 1.25 * across >= 1.0)
    found = _new_middles(blocks, np.any(near, axis=1), checked)
    count = min(len(found), max(32, len(blocks.number) // 32))
    return found[np.arange(count) * len(found) // max(count, 1)]


def _indicated_points(blocks: Blocks, lines: Floats, checked: Floats) -> Floats:
    """Return points in the blocks of the largest indicator, none close to a `checked` one.

    (points, modes). A block that one of `lines`, see `onset_points`, crosses is checked there too.
    """
    modes, size = checked.shape[1], len(blocks.number)
    count = max(32, size) if modes == 1 else max(64, size // 32)
    all_over = np.stack(np.meshgrid(*modes * [(0.2, 0.5, 0.8)]), axis=-1).reshape(-1, modes)
    ranked = np.argsort(-blocks.indicator, kind="stable")
    most, others = ranked[:_MOST_INDICATED], ranked[_MOST_INDICATED:]
    places = np.stack((blocks.middle, _on_kink(blocks, lines)), axis=1)
    low, width = blocks.low[most, np.newaxis], blocks.width[most, np.newaxis]
    tried = np.concatenate(
        ((low + width * all_over).reshape(-1, modes), places[others].reshape(-1, modes))
    )
    of_block = np.append(np.repeat(most, len(all_over)), np.repeat(others, 2))
    return _new(tried, blocks.width[of_block], checked, count)


def _places_around(
    blocks: Blocks, holding: NDArray[np.int64], points: Floats, errors: Floats, share: float
) -> Floats:
    """Return points at a share of the block to either side of the largest error in a few blocks.

    Along each axis; `holding` (points,) are the numbers of the blocks that contain the points.
    """
    modes = points.shape[1]
    order = np.argsort(-errors, kind="stable")
    _, first = np.unique(holding[order], return_index=True)
    worst = order[np.sort(first)[: (4, 1)[modes - 1]]]
    at = np.searchsorted(blocks.number, holding[worst])
    low, high = blocks.low[at, np.newaxis], blocks.high[at, np.newaxis]
    steps = share * np.concatenate((-np.eye(modes), np.eye(modes))) * (high - low)
    return np.clip(points[worst, np.newaxis] + steps, low, high).reshape(-1, modes)


def _points_beside(blocks: Blocks, numbers: NDArray[np.int64], checked: Floats) -> Floats:
    """Return the middles of the blocks that touch some blocks, none close to a `checked` point."""
    at = np.searchsorted(blocks.number, np.unique(numbers))
    touched = np.zeros(len(blocks.number), dtype=bool)
    for low, high in zip(blocks.low[at], blocks.high[at], strict=True):
        touched |= ((blocks.low <= high) & (blocks.high >= low)).all(axis=1)
    return _new_middles(blocks, touched, checked)


def _new_middles(blocks: Blocks, chosen: Flags, checked: Floats) -> Floats:
    """Return middles of chosen blocks that are close to no `checked` point, nor to each other."""
    return _new(blocks.middle[chosen], blocks.width[chosen], checked, len(blocks.number))


def _new(places: Floats, width: Floats, checked: Floats, count: int) -> Floats:
    """Return the first `count` places (places, modes) in blocks of a `width` (places, modes).

    Places close to a `checked` point or to a place before are left out.
    """
    reach = 0.1 * width  # check points so close have about the same error
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
    places = blocks.middle
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
    """Return the first points of the Halton sequence, (count, dimensions), without its origin.

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
