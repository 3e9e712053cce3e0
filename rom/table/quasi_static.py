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
from slipmode.rom.contact.friction_terms import contact_orders, contact_terms
from slipmode.rom.contact.settled import UNSETTLED
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import reaction_stiffnesses, torus_harmonics
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, steady_force
from slipmode.rom.table.model import Model

_ROUNDING = 1e-9  # relative difference of forces that are the same
_MARCH = 0.01  # of the table's tolerance: how well the contact motion repeats
_PASSES = 2  # the force follows from the friction term, which it changes by per cents
# Shares of the range where a component, whose amplitudes are not known yet, is checked.
_SHARES = np.array([[1.0, 1.0], [0.5, 0.5]])


def check_force_patterns(
    model: Model, applied: AppliedForces, amplitudes: Floats | None = None
) -> None:
    """Refuse forces whose quasi-static response a table does not have, where it matters.

    Parameters
    ----------
    model : Model
    applied : AppliedForces
        Forces, or patterns: their scale does not matter.
    amplitudes : (points, modes) ndarray, optional
        Of steady states [kg^1/2 m]; the largest of each mode are checked. Default: the largest of
        the table, and half of them.

    Raises
    ------
    SlipmodeError
        If the error of an amplitude is larger than the tolerance of the table.
    """
    error = quasi_static_error(model, applied, amplitudes)
    tolerance = model.accuracy.tolerance
    if np.all(error <= tolerance):
        return
    mode = "AB"[int(error.argmax())]
    size = f"{error.max():.2g}" if error.max() < 1.0 else "1 or more"
    if model.reduced.force_patterns is not None and _same(applied).all():
        advice = (
            "the contacts move as much by the forces as by the modes, so no table has it; use "
            "rom.steady_state, or time integration (rom.full)"
        )
    else:
        advice = (
            "give rom.reduce(..., force_patterns=) the forces, one {DOF: amplitude} per mode, and "
            "tabulate again"
        )
    raise SlipmodeError(
        f"force_patterns: the forces also move the contacts directly, which changes amplitude "
        f"{mode} by a relative {size}, above the tolerance {tolerance:g} of the table: {advice}"
    )


def quasi_static_error(
    model: Model, applied: AppliedForces, amplitudes: Floats | None = None
) -> Floats:
    """Return the relative error of amplitudes due to a neglected quasi-static response, (modes,).

    See `check_force_patterns` for the parameters. 0 where the table has the response.
    """
    reduced = model.reduced
    error = np.zeros(model.modes)
    if reduced.formulation == "paper" or _has_response(applied).all():
        return error
    if amplitudes is None:
        points = _SHARES[:, : model.modes] * model.table.amplitude_range
    else:
        points = np.unique(amplitudes[amplitudes.argmax(axis=0)], axis=0)
    for point in points[(points > 0.0).any(axis=1)]:
        error = np.maximum(error, _error_at(model, applied, point))
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
    return np.asarray(none | (_same(applied) & (known | none)))


def _error_at(model: Model, applied: AppliedForces, point: Floats) -> Floats:
    """Return the relative error of the amplitudes at one point (modes,)."""
    reduced, law = model.reduced, model.law
    modes = point.size
    grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
    tolerance = _MARCH * model.accuracy.tolerance
    smallest = smallest_scale(model.table.amplitude_range)
    known = contact_terms(
        *(reduced, law, point[np.newaxis], grid, tolerance, smallest, model.combinations)
    )
    bare = replace(reduced, force_patterns=None)
    orders = tuple(contact_orders(bare, model.combinations))
    reaction = reaction_stiffnesses(bare, orders, model.combinations)
    index = np.arange(modes)
    D = bare.modal_stiffness(bare.carrier)[index, index, index] + bare.indirect_damping
    residual = applied.residual(applied.past_mode) * (applied.modal != 0.0)[:, np.newaxis]
    amplitude = np.where(point > 0.0, point, np.inf)
    S: Complexes = known.S[0]
    for _ in range(_PASSES):
        # half the modal force per amplitude that holds the motion steady
        half = (D - S / amplitude) / (1.0 + 2.0 * applied.shift * D)
        solved = torus_harmonics(
            *(bare, law, bare.coupling - residual * half[:, np.newaxis], reaction),
            *(point[np.newaxis], grid, orders),
            tolerance=tolerance,
            smallest_scale=smallest,
        )
        if solved.residual[0] > UNSETTLED or known.residual[0] > UNSETTLED:
            return np.where(point > 0.0, np.inf, 0.0)
        P = solved.P[0, :modes]
        S = -np.einsum("jc,jc->j", bare.coupling, P) - bare.indirect_damping * point
    loss = np.abs(bare.modal_damping) * bare.carrier * point + np.abs(S.imag)
    apart = np.abs(S - known.S[0])
    return np.asarray(np.divide(apart, loss, out=np.zeros(modes), where=loss > 0.0))
