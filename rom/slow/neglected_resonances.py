"""Combination resonances in steady states, which have only the mean of their effect: zero."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import percentage
from slipmode.rom.table.model import Model
from slipmode.rom.validity import Finding

# Largest response that is not reported, relative to the contact motion of the carriers. Amplitudes
# change by up to 1.3 times this part (tests/rom/slow/branches/test_neglected_resonances.py).
_NEGLIGIBLE = 0.01


def neglected_resonance_findings(
    model: Model, frequency: Floats, amplitude: Complexes
) -> list[Finding]:
    """Report the combination resonance to which a mode responds most, if it responds strongly.

    A harmonic (n, m) of the contact forces near mode j moves it by |T_nm| / |D_jj(n Omega_A + m
    Omega_B)|, "Near resonances" in docs/theory.md. Runs in slow time have this response, steady
    states do not.

    Parameters
    ----------
    model : Model
        Model with one or two modes.
    frequency : (points, modes) ndarray
        Carrier frequencies Omega_j [rad/s].
    amplitude : (points, modes) ndarray
        Amplitudes at the contacts, relative to the scale of friction limits [kg^1/2 m]; NaN where
        there is none.

    Returns
    -------
    list of Finding
        Empty, or one warning.
    """
    known = np.isfinite(amplitude).all(axis=1) & (amplitude != 0.0).any(axis=1)
    terms = model.combinations
    if not terms or not known.any():
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
    reason = (
        f"mode {name} responds to this harmonic with up to {percentage(part[point, k])} of the "
        "contact motion. Steady states leave the response out, and their relative error may be as "
        "large. Use rom.steady_state, or a model of one mode, or compare with slipmode validate"
    )
    return [Finding(f"combination resonance {term}", "is neglected", reason, "warning")]
