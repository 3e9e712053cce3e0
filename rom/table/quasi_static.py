"""Whether a friction table has the quasi-static response of the contacts to the forces that act.

A force does not only drive its mode. It also acts on the contacts directly and through all other
modes, in other directions than its mode does. A table knows that of the forces whose patterns
`rom.reduce` was given. For other forces the error is measured by solving the contact problem with
and without that response.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, steady_force
from slipmode.rom.short_repr import percentage
from slipmode.rom.table.model import Model

_ROUNDING = 1e-9  # relative difference of forces that are the same


def check_force_patterns(
    model: Model,
    applied: AppliedForces,
    amplitude: Complexes | None = None,
    excitation: Complexes | None = None,
) -> None:
    """Refuse forces whose quasi-static response a table does not have, where it matters.

    Parameters
    ----------
    model : Model
    applied : AppliedForces
        Forces, or patterns: their scale does not matter.
    amplitude : (points, modes) complex ndarray, optional
        Amplitudes a_j of steady states, relative to the scale of the friction limits
        [kg^1/2 m]. The states with the largest amplitude of each mode are checked. Default: steady
        states at the carriers with the largest amplitudes of the table, and with half of them.
    excitation : (points, modes) complex ndarray
        F_j exp(i phase_j) that holds these states, relative to the same scale [N kg^-1/2].

    Raises
    ------
    SlipmodeError
        If the error of an amplitude is larger than the tolerance of the table.
    """
    error = quasi_static_error(model, applied, amplitude, excitation)
    tolerance = model.accuracy.tolerance
    if np.all(error <= tolerance):
        return
    mode = "AB"[int(error.argmax())]
    size = percentage(error.max()) if error.max() < 1.0 else "100 % or more"
    if model.reduced.force_patterns is not None and _same(applied).all():
        advice = (
            "the forces move the contacts about as much as the modes do, which no friction table "
            "includes; use rom.steady_state, or time integration (rom.full)"
        )
    else:
        advice = (
            "give rom.reduce the forces as force_patterns, one {DOF: amplitude} per mode, and "
            "tabulate the model again"
        )
    raise SlipmodeError(
        "force_patterns: the forces also act on the contacts directly, which changes amplitude "
        f"{mode} by {size}, more than the tolerance of the table of {percentage(tolerance)}; "
        f"{advice}"
    )


def quasi_static_error(
    model: Model,
    applied: AppliedForces,
    amplitude: Complexes | None,
    excitation: Complexes | None,
) -> Floats:
    """Return the relative error of amplitudes due to a neglected quasi-static response, (modes,).

    Arguments as of `check_force_patterns`. 0 where the table has the response.
    """
    error = np.zeros(model.modes)
    if model.reduced.formulation == "paper" or _has_response(applied).all():
        return error
    if amplitude is None or excitation is None:
        for share in (1.0, 0.5):
            point = share * model.table.amplitude_range
            error = np.maximum(error, _error_at(model, applied, point, None))
        return error
    effective = amplitude + applied.shift * excitation
    size = np.abs(effective)
    for k in np.unique(size.argmax(axis=0)):
        nothing, moving = np.zeros(model.modes, dtype=complex), size[k] > 0.0
        held = np.divide(0.5 * excitation[k], effective[k], out=nothing, where=moving)
        error = np.maximum(error, _error_at(model, applied, size[k], held))
    return error


def _same(applied: AppliedForces) -> Flags:
    """Return which forces have the patterns of the reduction, (modes,)."""
    patterns = applied.reduced.force_patterns
    if patterns is None:
        return np.zeros(applied.modal.size, dtype=bool)
    known = AppliedForces(applied.reduced, patterns).per_modal_force
    largest = np.abs(applied.per_modal_force).max(axis=1, keepdims=True)
    apart = np.abs(applied.per_modal_force - known) <= _ROUNDING * largest
    return np.asarray(apart.all(axis=1) | (applied.modal == 0.0))


def _has_response(applied: AppliedForces) -> Flags:
    """Return for which modes the table has the response, or there is none, (modes,)."""
    own = applied.reduced
    through = np.linalg.norm(own.coupling, axis=1)
    directly = np.linalg.norm(applied.residual(applied.past_mode), axis=1)
    none = directly * own.frequency**2 <= _ROUNDING * through
    known = (steady_force(own)[0] != 0.0).any(axis=1)
    return np.asarray(none | (_same(applied) & known))


def _error_at(
    model: Model, applied: AppliedForces, point: Floats, held: Complexes | None
) -> Floats:
    """Return the relative error of the amplitudes at one point, (modes,).

    `held` is half the modal force per amplitude; None: that which holds the motion at the carriers
    steady.
    """
    reduced, law, modes = model.reduced, model.law, point.size
    grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
    march = (
        grid,
        0.01 * model.accuracy.tolerance,
        smallest_scale(reduced, model.table.amplitude_range),
    )
    known = ContactProblem.of(reduced, law, model.combinations).on(*march).solve([point])
    bare = replace(reduced, force_patterns=None)
    problem = ContactProblem.of(bare, law, model.combinations)
    _, D = steady_force(bare)
    residual = applied.residual(applied.past_mode) * (applied.modal != 0.0)[:, np.newaxis]
    amplitude = np.where(point > 0.0, point, np.inf)
    S: Complexes = known.S[0]
    # Twice: the force follows from the friction term, which it changes by per cents.
    for _ in range(2 if held is None else 1):
        half = (D - S / amplitude) / (1.0 + 2.0 * applied.shift * D) if held is None else held
        coupling = bare.coupling - residual * half[:, np.newaxis]
        forces = ContactForces(coupling, problem.forces.reaction)
        terms = replace(problem, given_forces=forces).on(*march).solve([point])
        if not (terms.is_periodic.all() and known.is_periodic.all()):
            return np.where(point > 0.0, np.inf, 0.0)
        S = terms.S[0]
    balance = np.abs(bare.modal_damping) * bare.carrier * point + np.abs(S.imag)
    if held is not None:
        balance = np.maximum(balance, np.abs(held) * point)
    apart = np.abs(S - known.S[0])
    moving = (point > 0.0) & (balance > 0.0)
    return np.asarray(np.divide(apart, balance, out=np.zeros(modes), where=moving))
