"""Steady states whose friction the table does not have, solved again with the contact problem.

The friction table may miss where the forcing is off its reference frequencies, where a mode
responds to a combination resonance or to another harmonic of the contacts, and where the forces
act on the contacts in other ways than in the table.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError, ValidityWarning, warn
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.answer_error import (
    allowed_error,
    amplitude_error,
    force_error,
    off_carrier_findings,
)
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_curve import ContactCurve
from slipmode.rom.slow.direct.contact_friction import (
    ContactFriction,
    ContactPoints,
    changed_reaction,
    has_contact_problem,
)
from slipmode.rom.slow.direct.steady_harmonics import relative_error
from slipmode.rom.slow.direct.steady_state import steady_state
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.quasi_static import quasi_static_error

# Part of the tolerance above which an estimated error is measured: estimates scale trials of the
# table at other amplitudes.
_WORTH_MEASURING = 0.1
# Largest tolerance of a steady state without a table: the default of `steady_state`.
_LARGEST_TOLERANCE = 1e-3
# Of more points than twice _SOME, the error is measured at some. The estimates of the others are
# scaled by the largest ratio of both there, times a margin.
_SOME, _MARGIN = 16, 2.0


def corrected_points(
    flow: ForcedFlow, amplitude: Complexes, applied: AppliedForces
) -> Iterator[tuple[int, Complexes | SlipmodeError]]:
    """Yield numbers and steady states (modes,) where the table may miss, or why there is none.

    `amplitude` (points, modes) are the steady states with the friction of the table.
    """
    missed, estimate = _missed(flow, amplitude, applied)
    if not missed.size:
        return
    friction = ContactFriction.of(flow.model, applied)
    if missed.size > 2 * _SOME:
        part = flow.with_inputs(flow.inputs[missed])
        missed = missed[_beyond_allowed(part, amplitude[missed], estimate, friction)]
    for k in missed.tolist():
        one = flow.with_inputs(flow.inputs[[k]])
        try:
            found: Complexes | SlipmodeError = _corrected(one, amplitude[k], applied, friction)
        except SlipmodeError as refusal:
            found = refusal
        yield k, found


def _missed(
    flow: ForcedFlow, amplitude: Complexes, applied: AppliedForces
) -> tuple[NDArray[np.intp], Floats]:
    """Return the numbers of steady states (points, modes) whose friction the table may miss.

    And an estimate of their errors, relative to one another.
    """
    model = flow.model
    (known,) = np.nonzero(np.isfinite(amplitude).all(axis=1))
    if not has_contact_problem(model) or not known.size:
        return known[:0], np.zeros(0)
    at, a = flow.with_inputs(flow.inputs[known]), amplitude[known]
    tolerance = model.accuracy.tolerance
    points = ContactPoints.of(at, a)
    static = quasi_static_error(model, applied, points.amplitude, points.force)
    if static.max() > tolerance:
        return known, np.ones(known.size)
    part = model.detuning_error(np.abs(points.frequency / model.reduced.carrier - 1.0).max(axis=1))
    scale = points.scale * model.error_scale(np.abs(at.effective(a)) / points.scale)
    changed = changed_reaction(model, points.frequency)
    by_detuning, by_reaction = (
        np.nan_to_num(amplitude_error(at, a, error.astype(complex)), nan=np.inf).max(axis=1)
        for error in (part[:, np.newaxis] * scale, changed[:, np.newaxis] * scale)
    )
    off = (by_detuning > _WORTH_MEASURING * tolerance) | (changed > tolerance)
    return known[off], np.asarray((by_detuning + by_reaction)[off])


def _beyond_allowed(
    flow: ForcedFlow, amplitude: Complexes, estimate: Floats, friction: ContactFriction
) -> Flags:
    """Return where many amplitudes may have more than the allowed error; report the others'.

    `estimate` (points,) are estimates of their errors, relative to one another.
    """
    some = np.linspace(0, estimate.size - 1, _SOME).astype(np.intp)
    some = np.append(some, estimate.argmax())
    error = _table_errors(flow.with_inputs(flow.inputs[some]), amplitude[some], friction)
    largest = float((np.nan_to_num(error, nan=np.inf) / estimate[some]).max())
    expected, tolerance = _MARGIN * largest * estimate, flow.model.accuracy.tolerance
    kept = expected <= allowed_error(tolerance)
    apart = flow.frequency[kept] / flow.model.reduced.carrier - 1.0
    worst = float(expected[kept].max(initial=0.0))
    warn(off_carrier_findings(tolerance, worst, apart, "the amplitudes"))
    return ~kept


def _table_errors(flow: ForcedFlow, amplitude: Complexes, friction: ContactFriction) -> Floats:
    """Return errors of amplitudes (points, modes) by the table, relative to these, (points,)."""
    change = friction.without_guess(ContactPoints.of(flow, amplitude))
    error = force_error(flow, amplitude, change - flow.balance(amplitude).friction)
    return np.asarray(error.max(axis=1))


def _corrected(
    flow: ForcedFlow, amplitude: Complexes, applied: AppliedForces, friction: ContactFriction
) -> Complexes:
    """Return the steady state (modes,) of a flow at one point, near the table's (modes,).

    Two modes are integrated in time: 15 ms where the balance of two contacts takes one second.

    Raises
    ------
    SlipmodeError
        If the contact problem has no solution inside the range of the table.
    """
    two = flow.model.modes == 2
    found = _from_rest(flow, applied) if two else None
    tolerance = flow.model.accuracy.tolerance
    if found is not None:
        same = np.all(np.abs(found - amplitude) <= tolerance * np.abs(amplitude))
        return amplitude if same else found
    error = float(_table_errors(flow, amplitude[np.newaxis], friction)[0])
    if error <= tolerance:
        return amplitude
    found = _near(amplitude, flow, applied, friction)
    if found is None and not two:
        found = _from_rest(flow, applied)
    if found is None:
        size = percentage(min(float(np.nan_to_num(error, nan=1.0)), 1.0))
        raise SlipmodeError(
            f"frequency: at {flow.frequency[0]} rad/s the error of the friction table is {size} "
            "or more, and the contact problem at these frequencies does not converge; call "
            "rom.reduce with carrier = these frequencies, or rom.steady_state"
        )
    return found


def _near(
    amplitude: Complexes, flow: ForcedFlow, applied: AppliedForces, friction: ContactFriction
) -> Complexes | None:
    """Return the steady state of the contact problem near an amplitude (modes,), if found."""
    problem = _at_one_point(flow, applied)
    start = np.append(amplitude.view(float) / problem.size(np.zeros(1))[0], 0.0)
    found = ContactCurve(problem, friction.with_resonances(flow.frequency)).solved(start)
    return None if found is None else np.asarray(problem.amplitude(found[np.newaxis])[0])


def _from_rest(flow: ForcedFlow, applied: AppliedForces) -> Complexes | None:
    """Return the steady state (modes,) without a table, if all modes have a force.

    Its error is below the tolerance of the table.
    """
    model, scale = flow.model, float(flow.inputs["limit_scale"][0])
    reduced, tolerance = model.reduced, model.accuracy.tolerance
    if not flow.force[0].all():
        return None
    factor = flow.force[0] / applied.modal
    force = list(np.abs(factor / scale)[:, np.newaxis] * applied.force)
    try:
        with warnings.catch_warnings():  # the caller has them
            warnings.simplefilter("ignore", ValidityWarning)
            own = min(tolerance, _LARGEST_TOLERANCE)
            state = steady_state(reduced, model.law, flow.frequency[0], force, own)
    except SlipmodeError:
        return None
    if relative_error(reduced, state.error, state.amplitude) > tolerance:
        return None
    return np.asarray(scale * state.amplitude * np.exp(1j * np.angle(factor)))


def _at_one_point(flow: ForcedFlow, applied: AppliedForces) -> ForcedSlowFlow:
    """Return the flow at one point as a line of equal inputs."""
    model = flow.model
    ends = flow.with_inputs(flow.inputs[[0, 0]])
    curve = kernel.Curve(unknowns=2 * model.modes, largest_step=1.0)
    return ForcedSlowFlow(applied, ends, (0.0, 1.0), False, curve)
