"""Combination resonances in steady states, which have only the mean of their effect: zero."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import Detuned
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.rom.table.model import Model
from slipmode.rom.validity import Finding

# Largest response that is not reported, relative to the contact motion of the carriers. Amplitudes
# change by up to 1.3 times this part (tests/rom/slow/branches/test_stated_errors.py).
_NEGLIGIBLE = 0.01
_MEASURED = 8  # parts of the points; the point of largest response in each is measured


def neglected_resonance_findings(
    model: Model,
    frequency: Floats,
    amplitude: Complexes,
    error_of: Callable[[int, Complexes], float],
) -> list[Finding]:
    """Report the combination resonance to which a mode responds most, if it changes amplitudes.

    A harmonic (n, m) of the contact forces near mode j moves it by |T_nm| / |D_jj(n Omega_A + m
    Omega_B)|, "Near resonances" in docs/theory.md. Runs in slow time have this response, steady
    states do not. If it is strong, contact problems are solved in which the mode responds to the
    harmonic; they give the error of friction.

    Parameters
    ----------
    model : Model
        Model with one or two modes.
    frequency : (points, modes) ndarray
        Carrier frequencies Omega_j [rad/s].
    amplitude : (points, modes) ndarray
        Amplitudes at the contacts, relative to the scale of friction limits [kg^1/2 m]; NaN where
        there is none.
    error_of : callable
        Returns the relative error of the steady state at a point due to an error of S_j (modes,),
        which is relative to the scale of friction limits.

    Returns
    -------
    list of Finding
        Empty, or one warning.
    """
    (known,) = np.nonzero(np.isfinite(amplitude).all(axis=1) & (amplitude != 0.0).any(axis=1))
    terms = model.combinations
    if not terms or not known.size:
        return []
    reduced = model.reduced
    a = np.minimum(np.abs(amplitude[known]), model.table.amplitude_range)
    mode = [term.mode for term in terms]
    nu = frequency[known] @ np.array([(term.n, term.m) for term in terms]).T
    impedance = reduced.frequency[mode] ** 2 - nu**2 + 1j * reduced.modal_damping[mode] * nu
    drive = np.abs(model.table.terms(a)[:, model.modes : model.modes + len(terms)])
    coupling = np.abs(reduced.coupling)
    moved = (a @ coupling).max(axis=1, keepdims=True)
    part = drive / np.abs(impedance) * coupling[mode].max(axis=1) / moved
    point, k = np.unravel_index(part.argmax(), part.shape)
    if part[point, k] <= _NEGLIGIBLE:
        return []
    name, term = "AB"[terms[k].mode], terms[k]
    motion = (
        f"mode {name} responds to this harmonic with up to {percentage(part[point, k])} of the "
        "contact motion. Steady states leave the response out"
    )
    largest, strongest = 0.0, part.max(axis=1)
    for some in np.array_split(np.arange(known.size), min(_MEASURED, known.size)):
        place = int(some[strongest[some].argmax()])
        if strongest[place] <= _NEGLIGIBLE:
            continue
        friction = _friction_by_response(model, frequency[known[place]], a[place])
        if friction is None:
            largest = np.inf
            break
        largest = max(largest, error_of(int(known[place]), friction))
    if largest <= model.accuracy.tolerance:
        return []
    if np.isinf(largest):
        error = ", and their relative error may be as large"
    else:
        size = percentage(largest) if largest <= 1.0 else "more than 100 %"
        error = f", and their relative error is up to {size}"
    advice = "Use rom.steady_state, or a model of one mode, or compare with slipmode validate"
    reason = f"{motion}{error}. {advice}"
    return [Finding(f"combination resonance {term}", "is neglected", reason, "warning")]


def _friction_by_response(model: Model, frequency: Floats, amplitude: Floats) -> Complexes | None:
    """Return the change of S_j (modes,) if modes respond to the combination resonances.

    None if the contact motion does not converge with this response.
    """
    torus = model.contact_problem(smallest_scale(model.reduced, model.table.amplitude_range))
    responding = ContactProblem.of(model.reduced, model.law).on(
        torus.grid, torus.march.tolerance, torus.smallest_amplitude
    )
    apart = frequency / model.reduced.carrier - 1.0
    try:
        neglected = Detuned.of(torus, apart)
        without = neglected.solve(amplitude[np.newaxis])
        full = Detuned.of(responding, apart)
        change = full.friction(full.solve(amplitude[np.newaxis])) - neglected.friction(without)
    except SlipmodeError:
        return None
    return None if np.isnan(change).any() else np.asarray(change[0])
