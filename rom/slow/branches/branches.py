"""All branches of a curve of steady states, with their error: from the friction table, or without.

The table serves where its error is the stated one. Where the forcing is too far from its reference
frequencies, or a mode responds to a combination resonance, the curve is followed with friction
from the contact problem.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import Finding, SlipmodeError, warn
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.answer_error import allowed_error
from slipmode.rom.slow.branches.continuation import Branch, Points, branch_through
from slipmode.rom.slow.branches.curve_error import CurveError
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_curve import ContactCurve
from slipmode.rom.slow.direct.contact_friction import ContactFriction


@frozen
class Branches:
    """The branches of a curve, and their error."""

    problem: ForcedSlowFlow
    branches: list[Branch]
    points: Points  # of all branches
    number: NDArray[np.intp]  # (points,), of their branch
    error: CurveError
    contact: ContactCurve | None  # the curve, if its friction is not the table's

    @classmethod
    def of(
        cls, problem: ForcedSlowFlow, starts: Floats, contact: ContactCurve | None = None
    ) -> Self:
        """Return the branches through solutions (found, k + 1), or near them on another curve.

        Raises
        ------
        SlipmodeError
            If there is none.
        """
        branches: list[Branch] = []
        for start in starts:
            at = start if contact is None else contact.solved(start)
            if at is None or any(each.points.pass_by(at[np.newaxis])[0] for each in branches):
                continue
            branch = branch_through(problem.curve, at) if contact is None else contact.branch(at)
            if branch is not None and len(branch.points.rows) > 1:
                branches.append(branch)
        branches = [each for each in branches if not _is_part(each, branches)]
        if not branches:
            raise SlipmodeError(
                "span: no steady state inside the friction table, whose range is "
                f"{problem.model.table.amplitude_range}, over the span {problem.span}; tabulate a "
                "larger range"
            )
        if problem.is_reversed:
            branches = [branch.reversed for branch in branches]
        counts = [len(each.points.rows) for each in branches]
        rows = np.concatenate([branch.points.rows for branch in branches])
        points = Points(rows, problem.curve.unknowns)
        number = np.repeat(np.arange(len(counts)), counts)
        error = CurveError.of(problem, points.z, number, contact)
        return cls(problem, branches, points, number, error, contact)

    @property
    def misses(self) -> bool:
        """Whether the table misses the friction on the curve by far more than it states."""
        return self.error.beyond_table > allowed_error(self.problem.model.accuracy.tolerance)

    def without_table(self, starts: Floats) -> Self:
        """Return the branches with friction from the contact problem.

        If the contact problem has no solution, the branches are the table's, with a warning.
        """
        problem = self.problem
        along = problem.at(np.linspace(0.0, 1.0, 65)).frequency
        friction = ContactFriction.of(problem.model, problem.applied).with_resonances(along)
        try:
            return self.of(problem, starts, ContactCurve(problem, friction))
        except SlipmodeError:
            size = min(self.error.beyond_table, 1.0)
            reason = (
                f"the error of the friction table changes amplitudes by {percentage(size)} or "
                "more, and the contact problem at the forcing frequencies does not converge. "
                "Compare with rom.steady_state"
            )
            warn([Finding("curve", "has a large error", reason, "warning")])
            return self


def _is_part(branch: Branch, branches: list[Branch]) -> bool:
    """Return whether a branch is part of a longer one, as where the continuation stopped."""
    ends = branch.points.z[[0, branch.points.z.shape[0] // 2, -1]]
    longer = [each for each in branches if len(each.points.rows) > len(branch.points.rows)]
    return any(each.points.pass_by(ends).all() for each in longer)
