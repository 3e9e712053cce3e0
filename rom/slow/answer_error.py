"""Errors of steady states, by linearisation from the stated error of the friction table.

An error delta S_j of the friction terms changes the slow flow da/dt = G(a, p) by

    delta G_j = r_j delta S_j / mass_j,

with the coupling factor r_j. It moves the solution curve G(a, p) = 0 by (delta a, delta p), where

    [dG/da, dG/dp] (delta a, delta p) = -delta G.

The smallest solution is the distance between the curves. It is bounded at folds, where dG/da is
singular. The error of a_j at constant p is |delta a_j| plus the largest change of a_j along the
curve while p changes by delta p. On a backbone

    delta Omega = |delta S| / (2 Omega |a|),    delta zeta = |delta S| / (2 Omega^2 |a|).

In addition to the error that the table states, delta S_j has the error of forcing off the table's
carriers. It is measured: contact problems are solved at the forcing frequencies at a few points.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import MOST_DETUNING, Detuned
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.corrections import change_by_shift
from slipmode.rom.table.model import Model
from slipmode.rom.validity import reference_frequency_finding

# Estimate of the error by forcing off the carriers, relative to the tolerance, above which the
# error is measured. The estimate scales trials of the table at other amplitudes.
_WORTH_MEASURING = 0.1


@frozen
class TableError:
    """The error of S_j at points of a curve."""

    size: Floats  # (points, modes), |delta S_j| [N kg^-1/2]
    # (some,), points at which the error of forcing off the carriers is measured
    measured: NDArray[np.intp]
    # (some, modes), that error of S_j [N kg^-1/2]; NaN where the contact motion does not converge
    off_carriers: Complexes

    @classmethod
    def of(
        cls,
        model: Model,
        effective: Floats,
        frequency: Floats,
        limit_scale: Floats,
        weight: Floats | None,
    ) -> Self:
        """Return the error of S_j at points.

        The table is looked up at amplitudes `effective` (points, modes), relative to `limit_scale`
        (points,), with forcing `frequency` (points, modes). Points whose steady state is sensitive
        to S_j have a large `weight` (points,) and are measured. With None the error of forcing off
        the carriers is left out.
        """
        r = np.minimum(effective, model.table.amplitude_range)
        scale = model.error_scale(r)
        apart = frequency / model.reduced.carrier - 1.0
        off = np.abs(apart).max(axis=1)
        measured = np.zeros(0, dtype=np.intp) if weight is None else _measured_points(off, weight)
        beyond = _off_carriers(model, r[measured], apart[measured])
        share = np.zeros(r.shape)
        if not model.reduced.n_contacts and model.accuracy.detuning is not None:
            share += model.detuning_error(off)[:, np.newaxis]  # of waves it is stated
        elif measured.size:
            stated = model.accuracy
            part = np.nan_to_num(np.abs(beyond) / scale[measured], nan=1.0)
            part = np.maximum(part - stated.resolution - stated.periodicity, 0.0)
            order = 2 if model.table.detuning is not None else 1
            away = off[:, np.newaxis] ** order
            share = (part / away[measured]).max(axis=0) * away
        size = model.friction_error(r) + share * scale
        factor = limit_scale[:, np.newaxis]
        return cls(factor * size, measured, factor[measured] * beyond)


def _measured_points(off: Floats, weight: Floats) -> NDArray[np.intp]:
    """Return the point of largest weight in each part of the curve, (some,), off the carriers."""
    found = []
    # forcing off the carriers is measured at a point of each of eight parts of a curve
    for part in np.array_split(np.arange(off.size), min(8, off.size)):
        found.append(int(part[np.nan_to_num(weight[part] * off[part]).argmax()]))
    return np.array([k for k in found if off[k] > 1e-9], dtype=np.intp)  # rounding


def _off_carriers(model: Model, effective: Floats, apart: Floats) -> Complexes:
    """Return errors of S_j (points, modes) at frequencies off the carriers (points, modes).

    `apart` is the relative distance. NaN where the contact motion does not converge.
    """
    found = np.zeros(apart.shape, dtype=complex)
    if model.reduced.formulation == "paper" or not found.size or not model.reduced.n_contacts:
        return found
    torus = model.contact_problem(smallest_scale(model.reduced, model.table.amplitude_range))
    at_carriers = Detuned.of(torus, np.zeros(model.modes))
    for k, (amplitude, off) in enumerate(zip(effective[:, np.newaxis], apart, strict=True)):
        try:
            known = at_carriers.solve(amplitude)
            detuned = Detuned.of(torus, off)
            moved = detuned.friction(detuned.solve(amplitude, known.P))
        except SlipmodeError:
            found[k] = np.nan
            continue
        distance = np.clip(off, -MOST_DETUNING, MOST_DETUNING) * model.reduced.carrier
        tabulated = model.table.detuning_at(amplitude[0]) @ distance
        moved += change_by_shift(model.table, model.reduced, detuned.reduced, amplitude)
        found[k] = (moved - at_carriers.friction(known))[0] - tabulated
    return found


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
    known = np.isfinite(linear).all(axis=(1, 2))
    inverse = np.full((points, linear.shape[2], unknowns), np.nan)
    inverse[known] = np.linalg.pinv(linear[known])
    modes = unknowns // 2
    of_a = np.full((points, modes, modes), np.nan)
    blocks = inverse[known, :unknowns].reshape(-1, modes, 2, modes, 2).transpose(0, 1, 3, 2, 4)
    of_a[known] = np.linalg.norm(blocks, ord=2, axis=(-2, -1))
    of_p = np.linalg.norm(inverse[:, unknowns:].reshape(points, -1, modes, 2), axis=-1).sum(axis=1)
    return np.einsum("pij,pj->pi", of_a, change), np.einsum("pj,pj->p", of_p, change)


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
    size = np.abs(amplitude)
    _, jacobian = flow.rate_and_jacobian(amplitude)
    factor = coupling_factor(flow.model.reduced, flow.frequency)
    turned = np.exp(1j * np.angle(flow.effective(amplitude)))
    change = np.ascontiguousarray(factor * turned * friction / flow.balance(amplitude).mass)
    moved = np.linalg.pinv(jacobian) @ change.view(float)[..., np.newaxis]
    moved = np.abs(np.ascontiguousarray(moved[..., 0]).view(complex))
    return np.asarray(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0))


def error_at_points(flow: ForcedFlow, amplitude: Complexes) -> Callable[[int, Complexes], float]:
    """Return the function of a point and an error of S_j (modes,) for the error of amplitudes.

    It is the largest relative error. The error of S_j is relative to the scale of the limits.
    """

    def error_of(point: int, friction: Complexes) -> float:
        at = flow.with_inputs(flow.inputs[[point]])
        scaled: Complexes = at.inputs["limit_scale"][:, np.newaxis] * friction
        return float(amplitude_error(at, amplitude[[point]], scaled).max())

    return error_of


def detuning_findings(flow: ForcedFlow, amplitude: Complexes) -> list[Finding]:
    """Report steady states (points, modes) whose error by forcing off the carriers is large."""
    model, forced = flow.model, (flow.force != 0.0).any(axis=0)
    stated, apart = model.accuracy, flow.frequency / model.reduced.carrier - 1.0
    if stated.detuning is None:
        return model.detuning_findings(flow.frequency, forced)
    apart = np.where(forced, apart, 0.0)
    effective = np.abs(flow.effective(amplitude))
    part = stated.detuning_at(np.abs(apart).max(axis=1), model.table.detuning is not None)
    friction = part[:, np.newaxis] * model.error_scale(effective)
    estimate = amplitude_error(flow, amplitude, friction.astype(complex)).max(axis=1)
    if np.all(estimate <= _WORTH_MEASURING * stated.tolerance):
        return []
    scale = np.ones(len(amplitude))
    found = TableError.of(model, effective, flow.frequency, scale, estimate)
    at = flow.with_inputs(flow.inputs[found.measured])
    error = amplitude_error(at, amplitude[found.measured], found.off_carriers)
    largest = float(np.nan_to_num(error, nan=np.inf).max(initial=0.0))
    return off_carrier_findings(stated.tolerance, largest, apart, "the amplitudes")
