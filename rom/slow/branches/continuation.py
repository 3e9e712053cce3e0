"""Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977), the core's.

Points z = (y, p) are scaled so that 1 is large in each direction. F is a rate dy/dt: eigenvalues
of dF/dy are the growth of small deviations [1/s]; where one passes zero the curve folds back, or
two branches meet; where a complex pair does, a Hopf point, oscillation sets in.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.short_repr import short_repr

Kind = Literal["fold", "Hopf"]

MOST_POINTS = 5000  # to each side of where a curve is found
_BISECTIONS = 40
_NEAR = 1e-9


@dataclass(frozen=True, eq=False)
class Points:
    """Neighbours along a curve: z, its direction there and the eigenvalues of dF/dy.

    Attributes
    ----------
    z, tangent : (n, k + 1) ndarray
    eigenvalues : (n, k) complex ndarray
    """

    z: Floats
    tangent: Floats
    eigenvalues: Complexes

    __repr__ = short_repr

    @classmethod
    def of_rows(cls, rows: Floats, unknowns: int) -> Points:
        """Of points as the core has them."""
        n = unknowns + 1
        jacobian = rows[:, 2 * n :].reshape(-1, unknowns, unknowns)
        return cls(rows[:, :n], rows[:, n : 2 * n], _eigenvalues(jacobian))

    @property
    def unstable(self) -> NDArray[np.intp]:
        """How many eigenvalues let deviations grow, (n,)."""
        return np.asarray(np.count_nonzero(self.eigenvalues.real > 0.0, axis=1))


@dataclass(frozen=True, eq=False)
class Branch:
    """Solutions in the order in which the curve passes them.

    Attributes
    ----------
    points : Points
    special : list of (kind, z)
        Folds and Hopf points, in the same order.
    closed : bool
        Whether the last point is followed by the first.
    cut_off : list of (k + 1,) ndarray
        Ends at which the curve goes on, but it has too many points.
    """

    points: Points
    special: list[tuple[Kind, Floats]]
    closed: bool
    cut_off: list[Floats]

    __repr__ = short_repr


def branch_through(curve: kernel.Curve, z: Floats) -> Branch | None:
    """The curve through a solution, both ways to p = 0, p = 1 or where F ends.

    Parameters
    ----------
    curve : kernel.Curve
    z : (k + 1,) ndarray
        A solution, or near one at the same p.

    Returns
    -------
    Branch or None
        None if there is no solution near z.
    """
    upwards = np.eye(z.size)[-1]
    start = _point(curve, z, upwards, upwards)
    if start is None:
        return None
    rows, closed = _traced(curve, start)
    sides = [rows]
    if not closed:
        back, _ = _traced(curve, _turned(start[np.newaxis], z.size)[0])
        sides.append(back)
        rows = np.concatenate((_turned(back[:0:-1], z.size), rows))
    points = Points.of_rows(rows, curve.unknowns)
    cut_off = [side[-1, : z.size] for side in sides if not closed and len(side) >= MOST_POINTS]
    return Branch(points, _specials(curve, points), closed, cut_off)


def solutions_near(curve: kernel.Curve, guesses: Floats) -> Floats:
    """Solutions (found, k + 1), each at the p of one of the guesses (n, k + 1)."""
    z = np.array(guesses, dtype=float, order="C")
    status = kernel.lib.sm_curve_solve(ctypes.byref(curve), len(z), z.ctypes.data)
    kernel.check(status, "curve")
    return np.asarray(z[np.isfinite(z[:, -1])])


def _eigenvalues(jacobian: Floats) -> Complexes:
    """Of matrices (n, k, k); of two unknowns in closed form, at a tenth of the cost."""
    if jacobian.shape[1] != 2:
        return np.linalg.eigvals(jacobian).astype(complex)
    (a, b), (c, d) = np.moveaxis(jacobian, 0, -1)
    mean, half = 0.5 * (a + d), np.sqrt((0.25 * (a - d) ** 2 + b * c).astype(complex))
    return np.stack((mean + half, mean - half), axis=-1)


def _traced(curve: kernel.Curve, start: Floats) -> tuple[Floats, bool]:
    """Rows of points from a start on, and whether the curve comes back to it."""
    rows = np.empty((MOST_POINTS, start.size))
    rows[0] = start
    count, closed = ctypes.c_size_t(), ctypes.c_int32()
    status = kernel.lib.sm_curve_trace(
        ctypes.byref(curve),
        *(len(rows), rows.ctypes.data, ctypes.byref(count), ctypes.byref(closed)),
    )
    kernel.check(status, "curve")
    return rows[: count.value].copy(), bool(closed.value)


def _point(curve: kernel.Curve, guess: Floats, normal: Floats, onward: Floats) -> Floats | None:
    """The row of the point in the plane through a guess; None: there is none close by."""
    k = curve.unknowns
    row = np.empty(2 * (k + 1) + k * k)
    status = kernel.lib.sm_curve_point(
        ctypes.byref(curve), *(each.ctypes.data for each in (guess, normal, onward, row))
    )
    if status == kernel.NOT_CONVERGED:
        return None
    kernel.check(status, "curve")
    return row


def _turned(rows: Floats, n: int) -> Floats:
    """The same points on the curve passed the other way."""
    turned = rows.copy()
    turned[:, n : 2 * n] *= -1.0
    return np.asarray(turned)


def _specials(curve: kernel.Curve, points: Points) -> list[tuple[Kind, Floats]]:
    """What lies between neighbours."""
    along, unstable = points.tangent[:, -1], points.unstable
    folds = along[:-1] * along[1:] < 0.0
    hopf = ~folds & (np.abs(np.diff(unstable)) == 2)
    return [
        ("fold" if folds[k] else "Hopf", _between(curve, points, k, folds))
        for k in np.flatnonzero(folds | hopf).tolist()
    ]


def _between(curve: kernel.Curve, points: Points, k: int, folds: Flags) -> Floats:
    """Where the curve folds, or the number of growing deviations changes: by bisection."""
    low, high = points.z[k], points.z[k + 1]
    onward = np.ascontiguousarray(points.tangent[k])
    for _ in range(_BISECTIONS):
        chord = high - low
        length = np.linalg.norm(chord)
        row = None if length < _NEAR else _point(curve, 0.5 * (low + high), chord / length, onward)
        if row is None:
            break
        middle = Points.of_rows(row[np.newaxis], curve.unknowns)
        if folds[k]:
            is_before = middle.tangent[0, -1] * onward[-1] > 0.0
        else:
            is_before = middle.unstable[0] == points.unstable[k]
        low, high = (middle.z[0], high) if is_before else (low, middle.z[0])
    return np.asarray(low)
