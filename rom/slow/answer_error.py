"""Errors of steady states, by linearisation from errors of the friction table along a curve.

An error delta S_j of the friction terms changes the slow flow da/dt = G(a, p) by

    delta G_j = r_j delta S_j / mass_j,

with the coupling factor r_j. It moves the solution curve G(a, p) = 0 by (delta a, delta p), where

    [dG/da, dG/dp] (delta a, delta p) = -delta G.

The smallest solution is the distance between the curves. It is bounded at folds, where dG/da is
singular. The error of a_j at constant p is |delta a_j| plus the largest change of a_j along the
curve while p changes by delta p. On a backbone

    delta Omega = |Re delta S| / (2 Omega |a|),    delta zeta = |Im delta S| / (2 Omega^2 |a|).

delta S_j is measured at some points of a curve: contact problems are solved there at the forcing
frequencies, in finer steps than the table, with the response of the modes to all harmonics. The
error at the other points is interpolated.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.errors import Finding
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.direct.contact_friction import (
    ContactFriction,
    ContactPoints,
    ContactSolutions,
    changed_reaction,
    has_contact_problem,
)
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.validity import reference_frequency_finding

# Points of a curve at which delta S_j is measured, by modes: about as many contact problems as a
# quarter of the contact problems of a table with one mode.
_MEASURED = {1: 64, 2: 16}
# Stated error relative to the measured one. True errors are up to 1.4 times the measured ones
# (tests/rom/slow/branches/test_stated_errors.py).
_SAFETY = 2.0
# Allowed errors of the friction of a table, relative to the tolerance and at least.
_ALLOWED, _LEAST = 5.0, 0.01


@frozen
class TableError:
    """The error of S_j at points of a curve, measured at some of them.

    Without a contact problem, as of models of measured rates, all of the error is stated.
    """

    scale: Floats  # (points, modes), see `Model.error_scale` [N kg^-1/2]
    stated: Floats  # (points, modes), the part that is not measured [N kg^-1/2]
    at: NDArray[np.intp]  # (some,), points at which the error is measured
    measured: Complexes  # (some, modes), delta S_j; NaN where the motion does not converge

    @classmethod
    def of(
        cls,
        flow: ForcedFlow,
        amplitude: Complexes,
        applied: AppliedForces | None = None,
        used: ContactSolutions | None = None,
    ) -> Self:
        """Return the error of S_j at amplitudes (points, modes) of a slow flow.

        `applied` are the forces of the flow. Without them, the forces act as in the table. `used`
        is the friction of the flow if it is not the friction of the table.
        """
        model = flow.model
        factor = flow.inputs["limit_scale"][:, np.newaxis]
        effective = flow.effective(amplitude) / factor
        size = np.minimum(np.abs(effective), model.table.amplitude_range)
        scale, accuracy = factor * model.error_scale(size), model.accuracy
        if not has_contact_problem(model):
            share = np.full(len(size), accuracy.total)
            if not model.reduced.n_contacts and accuracy.detuning is not None:
                away = np.abs(flow.frequency / model.reduced.carrier - 1.0).max(axis=1)
                share += model.detuning_error(away)  # of waves it is stated
            nothing = np.zeros((0, model.modes), dtype=complex)
            return cls(scale, share[:, np.newaxis] * scale, np.zeros(0, np.intp), nothing)
        at = _measured_points(size, model.table.axes)
        if used is None:  # an internal resonance may be narrow
            at = np.union1d(at, changed_reaction(model, flow.frequency).argmax())
        some, a = flow.with_inputs(flow.inputs[at]), amplitude[at]
        if used is None:
            exact, points = ContactFriction.of(model, applied), ContactPoints.of(some, a)
            friction = some.balance(a).friction
        else:
            exact, points = used.friction, ContactPoints.of(some, a, used.response[at])
            friction = exact(points)
        measured = exact.finer(points) - friction
        inside = np.isfinite(friction).all(axis=1)
        # Steps are of second order: four times as many as the table has leave 1 / 12 of the change
        # by doubling.
        finer = accuracy.resolution / 12.0 + 0.01 * accuracy.tolerance
        stated = accuracy.neglected + finer
        return cls(scale, stated * scale, at[inside], measured[inside])

    def between(self, share: Floats) -> Floats:
        """Return errors at all points (points, ...) from those at measured points (some, ...).

        They are relative to a scale that varies little from point to point. Between measured
        points the error is the largest of the two on either side. 0 if none is measured.
        """
        if not self.at.size:
            return np.zeros((len(self.scale), *share.shape[1:]))
        share, last = np.nan_to_num(share, nan=1.0), self.at.size - 1
        points = np.arange(len(self.scale))
        after = np.minimum(np.searchsorted(self.at, points), last)
        near = after + np.where(self.at[after] == points, 0, np.array([[-2], [-1], [0], [1]]))
        return np.asarray(_SAFETY * share[np.clip(near, 0, last)].max(axis=0))

    @property
    def size(self) -> Floats:
        """|delta S_j| at all points, (points, modes) [N kg^-1/2]."""
        return self.between(np.abs(self.measured) / self.scale[self.at]) * self.scale + self.stated


def _measured_points(size: Floats, axes: tuple[Floats, ...]) -> NDArray[np.intp]:
    """Return the points of a curve at which delta S_j is measured, (some,).

    `size` (points, modes) are effective amplitudes, `axes` the nodes of the friction table. The
    measured points of one mode have equal distances, half by the number of points in between and
    half by the number of cells of the table: the interpolation error is different in each cell.
    """
    count = _MEASURED[len(axes)]
    if len(size) <= count:
        return np.arange(len(size))
    if len(axes) == 2:  # so few points miss most cells of a table of two modes
        return np.unique(np.linspace(0, len(size) - 1, count).astype(np.intp))
    nodes = axes[0]
    cells = np.abs(np.diff(np.interp(size[:, 0], nodes, np.arange(nodes.size))))
    share = np.divide(cells, cells.mean(), out=np.zeros_like(cells), where=cells > 0.0)
    distance = np.concatenate(([0.0], np.cumsum(1.0 + share)))
    return np.unique(np.searchsorted(distance, np.linspace(0.0, distance[-1], count)))


def allowed_error(tolerance: float) -> float:
    """Return the relative error of amplitudes above which friction is not the table's.

    Below, the error is stated: curves and surfaces without a table take seconds to minutes.
    """
    return max(_ALLOWED * tolerance, _LEAST)


def off_carrier_findings(
    tolerance: float, error: float, apart: Floats, what: str
) -> list[Finding]:
    """Report a curve `what` whose error, so far `apart` from the reference frequency, is large."""
    if error <= tolerance:
        return []
    size = "more than 100 %" if error > 1.0 else f"up to {percentage(error)}"
    reason = (
        f"the relative error of {what} there is {size} (tolerance {percentage(tolerance)}). Call "
        "rom.reduce with carrier = this frequency, or compare with slipmode validate"
    )
    return [reference_frequency_finding(float(np.abs(apart).max()), reason)]


def curve_displacement(linear: Floats, change: Floats) -> tuple[Floats, Floats]:
    """Return the distance of the true curve, in a_j (points, modes) and in p (points,).

    `linear` (points, 2 modes, 2 modes + 1) is dG/da, dG/dp; without the last column the distance
    is at constant p. `change` (points, modes) is |delta G_j|, of any phase.
    """
    points, unknowns, _ = linear.shape
    inverse = known_inverse(linear)
    # A step of any phase moves a_j by up to |u| + |v|, where it moves it by u z + v conj(z).
    rows = inverse[:, :unknowns:2] + 1j * inverse[:, 1:unknowns:2]
    real, imaginary = rows[..., ::2], 1j * rows[..., 1::2]
    of_a = 0.5 * (np.abs(real - imaginary) + np.abs(real + imaginary))
    of_p = np.linalg.norm(inverse[:, unknowns:].reshape(points, -1, unknowns // 2, 2), axis=-1)
    moved_p = np.einsum("pij,pj->p", of_p, change)
    return np.einsum("pij,pj->pi", of_a, change), moved_p


def known_inverse(linear: Floats) -> Floats:
    """Return pseudo-inverses of matrices (points, rows, columns); NaN where one is not known."""
    known, inverse = np.isfinite(linear).all(axis=(1, 2)), np.full_like(linear, np.nan)
    inverse = inverse.swapaxes(1, 2)
    inverse[known] = np.linalg.pinv(linear[known])
    return inverse


def change_along(
    parameter: Floats, values: Complexes | Floats, branch: NDArray[np.intp], width: Floats
) -> Floats:
    """Return the largest |change| of values (points, modes) along a curve near each point.

    From a point the curve is followed both ways, through folds, while its parameter is within
    `width` (points,) of the point's. Infinity where the branch ends before.
    """
    found = np.zeros(values.shape)
    for way in (1, -1):
        active = np.arange(parameter.size)
        for step in range(1, parameter.size + 1):
            after = active + way * step
            on = (after >= 0) & (after < parameter.size)
            on[on] = branch[after[on]] == branch[active[on]]
            found[active[~on & (width[active] > 0.0)]] = np.inf
            active, after = active[on], after[on]
            if not active.size:
                break
            start = values[active]
            before = after - way
            near, far = parameter[before] - parameter[active], parameter[after] - parameter[active]
            beyond = np.abs(far) > width[active]
            edge = np.copysign(width[active], far)
            part = np.divide(edge - near, far - near, out=np.ones(far.size), where=beyond)
            reached = values[before] + part[:, np.newaxis] * (values[after] - values[before])
            found[active] = np.maximum(found[active], np.abs(reached - start))
            active = active[~beyond]
    return found


def error_at_constant(
    parameter: Floats,
    values: Complexes | Floats,
    branch: NDArray[np.intp],
    displacement: tuple[Floats, Floats],
    at_end: Floats,
) -> Floats:
    """Return the error of values (points, modes) at constant parameter.

    `displacement` is the distance of the true curve in the values (points, modes) and in the
    parameter (points,); `at_end` (points, modes) is the error where the branch ends nearby.
    """
    own, width = displacement
    along = change_along(parameter, values, branch, width)
    error = np.where(np.isfinite(along), own + along, at_end)
    known = np.isfinite(error).all(axis=1)
    if known.any() and not known.all():  # at the end of the table
        at = np.arange(error.shape[0])
        for column in error.T:
            column[:] = np.interp(at, at[known], column[known])
    return np.asarray(error)


def peak_errors(limit: Floats, peak: Floats, share: Floats) -> Floats:
    """Return the error of peaks (n,) at constant limit; `share` is the error of their force."""
    slope = np.abs(np.gradient(np.log(peak)) / np.gradient(np.log(limit)))
    at_end = np.where(np.isfinite(slope), (1.0 + slope) * share * peak, peak)[:, np.newaxis]
    displacement = (share * peak)[:, np.newaxis], share * limit
    one_branch = np.zeros(limit.size, dtype=np.intp)
    return error_at_constant(limit, peak[:, np.newaxis], one_branch, displacement, at_end)[:, 0]


def amplitude_error(flow: ForcedFlow, amplitude: Complexes, friction: Complexes) -> Floats:
    """Return |delta a_j| / |a_j| by an error of S_j at steady states, (points, modes).

    `amplitude` and `friction` are (points, modes); 0 for a mode at rest.
    """
    factor = coupling_factor(flow.model.reduced, flow.frequency)
    turned = np.exp(1j * np.angle(flow.effective(amplitude)))
    return force_error(flow, amplitude, factor * turned * friction)


def force_error(flow: ForcedFlow, amplitude: Complexes, force: Complexes) -> Floats:
    """Return |delta a_j| / |a_j| by modal forces (points, modes), as `amplitude_error`."""
    size = np.abs(amplitude)
    _, jacobian = flow.rate_and_jacobian(amplitude)
    change = np.ascontiguousarray(force / flow.balance(amplitude).mass)
    moved = np.linalg.pinv(jacobian) @ change.view(float)[..., np.newaxis]
    moved = np.abs(np.ascontiguousarray(moved[..., 0]).view(complex))
    return np.asarray(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0))
