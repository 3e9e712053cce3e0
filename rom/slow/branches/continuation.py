"""Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977).

Points z = (y, p) are scaled so that 1 is large in each direction. F is a rate dy/dt: eigenvalues
of dF/dy are the growth of small deviations [1/s]; where one passes zero the curve folds back, or
two branches meet; where a complex pair does, a Hopf point, oscillation sets in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import short_repr

Rates = Callable[[Floats], tuple[Floats, Floats]]
"""F (k,) and its Jacobian (k, k + 1) at z (k + 1,); NaN where it is not defined."""

Kind = Literal["fold", "Hopf"]

_PASSES = 8
_EASY_PASSES = 3  # up to which the next step may be longer
_CONVERGED = 1e-10  # of Newton's last update
_FARTHEST = 0.05  # that Newton's method goes from its start: beyond, there may not be an F
_LARGEST_TURN = 0.15  # of the tangent between two points [rad]
_SHORTEST = 1e-7
MOST_POINTS = 5000  # to each side of where a curve is found
_BISECTIONS = 40


@dataclass(frozen=True, eq=False)
class Point:
    """One solution, the direction of the curve there and the eigenvalues of dF/dy (k,)."""

    z: Floats
    tangent: Floats
    eigenvalues: Complexes

    __repr__ = short_repr

    @property
    def unstable(self) -> int:
        """How many eigenvalues let deviations grow."""
        return int(np.count_nonzero(self.eigenvalues.real > 0.0))


@dataclass(frozen=True, eq=False)
class Branch:
    """Solutions in the order in which the curve passes them.

    Attributes
    ----------
    points : list of Point
    special : list of (kind, Point)
        Folds and Hopf points, in the same order.
    closed : bool
        Whether the last point is followed by the first.
    cut_off : list of Point
        Ends at which the curve goes on, but it has too many points.
    """

    points: list[Point]
    special: list[tuple[Kind, Point]]
    closed: bool
    cut_off: list[Point]

    __repr__ = short_repr


def branch_through(rates: Rates, z: Floats, largest_step: float) -> Branch | None:
    """The curve through a solution, both ways to p = 0, p = 1 or where F ends.

    Parameters
    ----------
    rates : callable
    z : (k + 1,) ndarray
        A solution, or near one at the same p.
    largest_step : float
        Between two points, in scaled length.

    Returns
    -------
    Branch or None
        None if there is no solution near z.
    """
    upwards = np.eye(z.size)[-1]
    first = _corrected(rates, z, upwards, upwards)
    if first is None:
        return None
    start = first[0]
    there, closed = _traced(rates, start, largest_step)
    sides = [there]
    if closed:
        points = there
    else:
        back, _ = _traced(rates, _turned(start), largest_step)
        sides.append(back)
        points = [*(_turned(point) for point in back[:0:-1]), *there]
    special = [
        found
        for before, after in pairwise(points)
        if (found := _special(rates, before, after)) is not None
    ]
    cut_off = [side[-1] for side in sides if not closed and len(side) >= MOST_POINTS]
    return Branch(points, special, closed, cut_off)


def _traced(rates: Rates, start: Point, largest_step: float) -> tuple[list[Point], bool]:
    """Points from a start on, and whether the curve comes back to it."""
    points, step = [start], 0.25 * largest_step
    far = False
    while len(points) < MOST_POINTS:
        last = points[-1]
        found = _stepped(rates, last, step)
        if found is None:
            step *= 0.5
            if step < _SHORTEST:
                break
            continue
        point, passes = found
        if not 0.0 <= point.z[-1] <= 1.0:
            end = _at_end(rates, last, point)
            if end is not None and np.linalg.norm(end.z - last.z) > _SHORTEST:
                points.append(end)
            return points, False
        if passes <= _EASY_PASSES:
            step = min(1.5 * step, largest_step)
        away = float(np.linalg.norm(point.z - start.z))
        if far and away < step and point.tangent @ start.tangent > 0.0:
            return [*points, point], True
        far |= away > 2.0 * step
        points.append(point)
    return points, False


def _stepped(rates: Rates, last: Point, step: float) -> tuple[Point, int] | None:
    """The next point at a distance along the tangent; None if the curve bends too much for it."""
    found = _corrected(rates, last.z + step * last.tangent, last.tangent, last.tangent)
    if found is None or np.arccos(np.clip(found[0].tangent @ last.tangent, -1, 1)) > _LARGEST_TURN:
        return None
    return found


def _corrected(
    rates: Rates, guess: Floats, normal: Floats, onward: Floats
) -> tuple[Point, int] | None:
    """Newton's method on F = 0 in the plane through a guess; the tangent points onward."""
    z = guess.copy()
    for passes in range(_PASSES):
        F, J = rates(z)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            return None
        bordered = np.vstack((J, normal))
        try:
            update = np.linalg.solve(bordered, np.append(F, normal @ (z - guess)))
        except np.linalg.LinAlgError:
            return None
        if np.abs(update).max() <= _CONVERGED:
            tangent = np.linalg.svd(J)[2][-1]
            tangent = tangent if tangent @ onward >= 0.0 else -tangent
            return Point(z, tangent, np.linalg.eigvals(J[:, :-1]).astype(complex)), passes
        z = z - update
        if not np.abs(z - guess).max() <= _FARTHEST:
            return None
    return None


def _at_end(rates: Rates, inside: Point, outside: Point) -> Point | None:
    """The point at p = 0 or p = 1 between two."""
    end = 1.0 if outside.z[-1] > 1.0 else 0.0
    part = (end - inside.z[-1]) / (outside.z[-1] - inside.z[-1])
    guess = inside.z + part * (outside.z - inside.z)
    guess[-1] = end
    found = _corrected(rates, guess, np.eye(guess.size)[-1], inside.tangent)
    return None if found is None else found[0]


def _special(rates: Rates, before: Point, after: Point) -> tuple[Kind, Point] | None:
    """What lies between two neighbours: found by bisection."""
    if before.tangent[-1] * after.tangent[-1] < 0.0:
        kind: Kind = "fold"
        sign = np.sign(before.tangent[-1])

        def is_before(point: Point) -> bool:
            return bool(sign * point.tangent[-1] > 0.0)
    elif abs(after.unstable - before.unstable) == 2:
        kind = "Hopf"

        def is_before(point: Point) -> bool:
            return point.unstable == before.unstable
    else:
        return None
    low, high = before, after
    for _ in range(_BISECTIONS):
        chord = high.z - low.z
        length = np.linalg.norm(chord)
        if length < 1e-9:
            break
        found = _corrected(rates, 0.5 * (low.z + high.z), chord / length, before.tangent)
        if found is None:
            break
        low, high = (found[0], high) if is_before(found[0]) else (low, found[0])
    return kind, low


def _turned(point: Point) -> Point:
    """The same point on the curve passed the other way."""
    return Point(point.z, -point.tangent, point.eigenvalues)
