"""Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977), the core's.

Points z = (y, p) are scaled so that 1 is large in each direction. F is a rate dy/dt: eigenvalues
of dF/dy are the growth of small deviations [1/s]; where one passes zero the curve folds back, or
two branches meet; where a complex pair does, a Hopf point, oscillation sets in.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.short_repr import frozen

Kind = Literal["fold", "Hopf"]

MOST_POINTS = 5000  # to each side of the first solution of a curve


@frozen
class Points:
    """Points along a curve F(y, p) = 0 with k unknowns y."""

    rows: Floats  # (n, 4 k + 2): z, tangent and eigenvalues of each point
    unknowns: int

    @classmethod
    def of(cls, rows: Floats, unknowns: int) -> Self:
        """Return the points of rows of the core, which have dF/dy in place of its eigenvalues."""
        known, jacobian = np.split(rows, [2 * (unknowns + 1)], axis=1)
        found = np.linalg.eigvals(jacobian.reshape(-1, unknowns, unknowns)).astype(complex)
        order = np.argsort(-found.real, axis=1, kind="stable")
        eigenvalues = np.take_along_axis(found, order, axis=1)
        return cls(np.hstack((known, eigenvalues.view(float))), unknowns)

    @property
    def z(self) -> Floats:
        """(y, p), (n, k + 1)."""
        return self.rows[:, : self.unknowns + 1]

    @property
    def tangent(self) -> Floats:
        """Direction of the curve, (n, k + 1)."""
        return self.rows[:, self.unknowns + 1 : 2 * (self.unknowns + 1)]

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
        rows, at = np.ascontiguousarray(self.rows), np.ascontiguousarray(z)
        shape = self.unknowns, *rows.shape
        passes = kernel.lib.sm_curve_passes
        return np.array([passes(*shape, rows, k) for k in at], dtype=bool)


@frozen
class Branch:
    """Solutions in their order along the curve."""

    points: Points
    special: list[tuple[Kind, Floats]]  # folds and Hopf points, in the same order
    closed: bool  # whether the first point follows the last one
    cut_off: list[Floats]  # ends where the curve goes on

    @property
    def reversed(self) -> Branch:
        """The branch in the opposite order."""
        points = Points(self.points.rows[::-1].copy(), self.points.unknowns)
        return Branch(points, self.special[::-1], self.closed, self.cut_off[::-1])


def branch_through(curve: kernel.Structure, z: Floats) -> Branch | None:
    """Return the curve through a solution, both ways to p = 0, p = 1 or the end of F.

    `z` (k + 1,) is a solution, or near one at the same p; None if there is none.
    """
    branch = traced(curve, z)
    if branch is None:
        return None
    points = branch.points
    found = [(kind, _bisected(curve, points, k, kind)) for kind, k in changes_of_stability(points)]
    return replace(branch, special=found)


def traced(curve: kernel.Structure, z: Floats) -> Branch | None:
    """Return the branch as `branch_through` does, without its folds and Hopf points."""
    start, found = np.ascontiguousarray(z), kernel.Branch()
    rows = np.empty((2 * MOST_POINTS - 1, 2 * (curve.unknowns + 1) + curve.unknowns**2))
    status = kernel.lib.sm_curve_branch(curve, start, MOST_POINTS, rows, found)
    if status == kernel.NOT_CONVERGED:
        return None
    kernel.check(status, "curve")
    first, last = MOST_POINTS - 1 - found.before, MOST_POINTS - 1 + found.after
    points, closed = Points.of(rows[first : last + 1], curve.unknowns), bool(found.closed)
    ends = [end for side, end in ((found.after, -1), (found.before, 0)) if side == MOST_POINTS - 1]
    cut_off = [] if closed else [points.z[end] for end in ends]
    return Branch(points, [], closed, cut_off)


def changes_of_stability(points: Points) -> list[tuple[Kind, int]]:
    """Return folds, and Hopf points, where a pair of deviations begins or ceases to grow.

    With each goes the number of the point that it follows. At a fold one real eigenvalue changes
    its sign; the direction of the curve alone may turn by noise of the contact problem.
    """
    changes = np.abs(np.diff(points.unstable))
    folds = changes % 2 == 1
    places = np.flatnonzero(folds | (changes == 2)).tolist()
    return [("fold" if folds[before] else "Hopf", before) for before in places]


def _bisected(curve: kernel.Structure, points: Points, before: int, kind: Kind) -> Floats:
    """Return the fold or Hopf point (k + 1,) after one of the points."""
    (low, high), onward = points.z[before : before + 2], points.tangent[before].copy()
    row = np.empty((1, 2 * low.size + points.unknowns**2))
    for _ in range(40):
        length = np.linalg.norm(high - low)
        guess, normal = 0.5 * (low + high), (high - low) / length
        arrays = (guess, normal, onward, row)
        if length < 1e-9 or kernel.lib.sm_curve_point_near(curve, *arrays) != kernel.OK:
            break
        at = Points.of(row, points.unknowns)
        if kind == "fold":
            is_before = at.tangent[0, -1] * onward[-1] > 0.0
        else:
            is_before = at.unstable[0] == points.unstable[before]
        low, high = (at.z[0], high) if is_before else (low, at.z[0])
    return np.array(low)


def cut_off(branches: list[Branch]) -> list[float]:
    """Return parts of the span where a curve continues, and no other branch covers it."""
    return [
        float(end[-1])
        for branch in branches
        for end in branch.cut_off
        if not any(
            other.points.pass_by(end[np.newaxis])[0] for other in branches if other is not branch
        )
    ]
