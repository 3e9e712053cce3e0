"""Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977), the core's.

Points z = (y, p) are scaled so that 1 is large in each direction. F is a rate dy/dt: eigenvalues
of dF/dy are the growth of small deviations [1/s]; where one passes zero the curve folds back, or
two branches meet; where a complex pair does, a Hopf point, oscillation sets in.
"""

from __future__ import annotations

import ctypes
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.short_repr import frozen

Kind = Literal["fold", "Hopf"]

MOST_POINTS = 5000  # to each side of the first solution of a curve


@frozen
class Points:
    """Points along a curve F(y, p) = 0 with k unknowns y, as rows of the core."""

    rows: Floats
    unknowns: int

    @property
    def z(self) -> Floats:
        """(y, p), (n, k + 1)."""
        return self.rows[:, : self.unknowns + 1]

    @property
    def eigenvalues(self) -> Complexes:
        """Of dF/dy, (n, k), the largest real part first."""
        return self.rows[:, 2 * (self.unknowns + 1) :].view(complex)

    @property
    def unstable(self) -> NDArray[np.intp]:
        """Number of growing deviations, (n,)."""
        return np.asarray(np.count_nonzero(self.eigenvalues.real > 0.0, axis=1))

    def pass_by(self, z: Floats) -> Flags:
        """Return whether the curve passes through solutions z (solutions, k + 1), (solutions,)."""
        passed = np.empty(len(z), dtype=bool)
        at = np.ascontiguousarray(z)
        status = kernel.lib.sm_curve_passes(
            self.unknowns,
            len(self.rows),
            self.rows.ctypes.data,
            len(at),
            at.ctypes.data,
            passed.ctypes.data,
        )
        kernel.check(status, "curve")
        return passed


@frozen
class Branch:
    """Solutions in their order along the curve."""

    points: Points
    special: list[tuple[Kind, Floats]]  # folds and Hopf points, in the same order
    closed: bool  # whether the first point follows the last one
    cut_off: list[Floats]  # ends at which a curve with too many points continues

    @property
    def reversed(self) -> Branch:
        """The branch in the opposite order."""
        points = Points(self.points.rows[::-1].copy(), self.points.unknowns)
        return Branch(points, self.special[::-1], self.closed, self.cut_off[::-1])


def branch_through(curve: kernel.Structure, z: Floats) -> Branch | None:
    """Return the curve through a solution, both ways to p = 0, p = 1 or the end of F.

    `z` (k + 1,) is a solution, or near one at the same p; None if there is none.
    """
    start, found = np.ascontiguousarray(z), kernel.Branch()
    rows = np.empty((2 * MOST_POINTS - 1, 4 * curve.unknowns + 2))
    status = kernel.lib.sm_curve_branch(
        curve, start.ctypes.data, MOST_POINTS, rows.ctypes.data, found
    )
    if status == kernel.NOT_CONVERGED:
        return None
    kernel.check(status, "curve")
    first, last = MOST_POINTS - 1 - found.before, MOST_POINTS - 1 + found.after
    points, closed = Points(rows[first : last + 1].copy(), curve.unknowns), bool(found.closed)
    ends = [end for side, end in ((found.after, -1), (found.before, 0)) if side == MOST_POINTS - 1]
    cut_off = [] if closed else [points.z[end] for end in ends]
    most, count = len(points.rows), ctypes.c_size_t()
    folds, special = np.empty(most, dtype=bool), np.empty((most, curve.unknowns + 1))
    status = kernel.lib.sm_curve_specials(
        curve, most, points.rows.ctypes.data, folds.ctypes.data, special.ctypes.data, count
    )
    kernel.check(status, "curve")
    kinds: list[Kind] = ["fold" if one else "Hopf" for one in folds[: count.value]]
    at = list(special[: count.value])
    return Branch(points, list(zip(kinds, at, strict=True)), closed, cut_off)
