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
from slipmode.rom.slow.branches.curve_result import Method
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_curve import ContactCurve
from slipmode.rom.slow.direct.contact_friction import ContactFriction, has_contact_problem


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
        if not branches and contact is not None:
            raise SlipmodeError(
                f"span: the contact problem does not converge over the span {problem.span}; "
                'choose method = "table", or compare with rom.steady_state'
            )
        if not branches:
            raise SlipmodeError(
                "span: no steady state inside the friction table, whose range is "
                f"{problem.model.table.amplitude_range}, over the span {problem.span}; tabulate a "
                "larger range"
            )
        counts = [len(each.points.rows) for each in branches]
        rows = np.concatenate([branch.points.rows for branch in branches])
        points = Points(rows, problem.curve.unknowns)
        number = np.repeat(np.arange(len(counts)), counts)
        # the direction of the span has no influence on where the error is measured
        error = CurveError.of(problem, points.z, number, contact)
        if problem.is_reversed:
            branches = [branch.reversed for branch in branches]
            order = np.lexsort((-np.arange(number.size), number))
            points, error = Points(rows[order], points.unknowns), error.at(order)
        return cls(problem, branches, points, number, error, contact)

    @classmethod
    def by_method(cls, problem: ForcedSlowFlow, method: Method | None) -> Self:
        """Return the branches with friction by a method, see `rom.response_curve`.

        Raises
        ------
        SlipmodeError
            If there is none, or the model has no contact problem for "direct".
        """
        starts = problem.solutions(9)  # at nine values of the parameter
        if method == "direct":
            return cls._direct(problem, starts)
        found, accuracy = cls.of(problem, starts), problem.model.accuracy
        missed = found.error.beyond_table  # by far more than the table states
        if missed <= allowed_error(accuracy.tolerance):
            return found
        advice = 'Choose method = "direct", or compare with rom.steady_state'
        if method is None:
            try:
                return cls._direct(problem, starts)
            except SlipmodeError:
                advice = (
                    "The contact problem at the forcing frequencies does not converge. Compare "
                    "with rom.steady_state"
                )
        size = percentage(min(missed, 1.0))
        reason = f"the error of the friction table changes amplitudes by {size} or more. {advice}"
        warn([Finding("curve", "has a large error", reason, "warning")])
        return found

    @classmethod
    def _direct(cls, problem: ForcedSlowFlow, starts: Floats) -> Self:
        """Return the branches with friction from the contact problem."""
        if not has_contact_problem(problem.model):
            raise SlipmodeError(
                'method: "direct" needs a model with contacts that rom.reduce made with '
                'formulation = "consistent"'
            )
        along = problem.at(np.linspace(0.0, 1.0, 65)).frequency
        friction = ContactFriction.of(problem.model, problem.applied).with_resonances(along)
        return cls.of(problem, starts, ContactCurve(problem, friction))


def _is_part(branch: Branch, branches: list[Branch]) -> bool:
    """Return whether a branch is part of a longer one, as where the continuation stopped."""
    ends = branch.points.z[[0, branch.points.z.shape[0] // 2, -1]]
    longer = [each for each in branches if len(each.points.rows) > len(branch.points.rows)]
    return any(each.points.pass_by(ends).all() for each in longer)
