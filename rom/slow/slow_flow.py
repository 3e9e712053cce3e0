"""The slow flow, Eqs. (18) and (19), in the frame of the forcing.

mass_j a_j' + stiffness_j a_j = F_j exp(i phase_j) / 2 + Q_j(|a_A|, |a_B|) a_j
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import _kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.coupling import coupling_coefficients, coupling_factor
from slipmode.rom.reduction.force_response import Forces, cross_response, off_resonance_shift
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.table.model import Model

_SHORT_STEP = 1e-4  # of a difference along the flow, in radians of mode A


def slow_flow(model: Model, force: Forces | None = None) -> _kernel.SlowFlow:
    """The amplitude equations as the core reads them; forces act as `off_resonance_shift` says."""
    shift = None if force is None else off_resonance_shift(model.reduced, force)
    off_resonance = None if force is None else cross_response(model.reduced, force)
    table = model.table.kernel()
    flow = _kernel.SlowFlow(paper=int(model.reduced.formulation == "paper"), table=table)
    for mode in range(model.modes):
        flow.natural[mode] = model.reduced.frequency[mode]
        flow.damping[mode] = model.reduced.modal_damping[mode]
        for power, coefficient in enumerate(coupling_coefficients(model.reduced)[mode]):
            flow.factor[mode][power][:] = (coefficient.real, coefficient.imag)
        if shift is not None:
            flow.shift[mode][:] = (shift[mode].real, shift[mode].imag)
        if off_resonance is not None:
            for other, response in enumerate(off_resonance[mode]):
                flow.cross_response[mode][other][:] = (response.real, response.imag)
    for k, term in enumerate(model.combinations):
        flow.combinations[k] = _kernel.Near(term.mode, term.n, term.m)
    flow.owned = table
    return flow


@dataclass(frozen=True, eq=False)
class LinearPart:
    """Coefficients of the amplitude equations at constant forcing frequencies.

    Attributes
    ----------
    mass : (..., modes) complex ndarray
        Factor of da_j/dt [rad/s].
    stiffness : (..., modes) complex ndarray
        Factor of a_j [rad^2/s^2].
    """

    mass: Complexes
    stiffness: Complexes

    __repr__ = short_repr


def linear_part(reduced: Reduced, frequency: ArrayLike) -> LinearPart:
    """Linear part of the slow flow at forcing frequencies (..., modes) [rad/s].

    In the "paper" formulation the carrier is the natural frequency and the detuning enters to
    first order; in "consistent" the carrier is the forcing itself.
    """
    Omega = np.asarray(frequency, dtype=float)
    omega, gamma = reduced.frequency, reduced.modal_damping
    if reduced.formulation == "paper":
        mass = np.broadcast_to(2j * omega, Omega.shape)
        return LinearPart(mass, 2 * omega * (omega - Omega) + 1j * gamma * omega)
    return LinearPart(gamma + 2j * Omega, (omega - Omega) * (omega + Omega) + 1j * gamma * Omega)


def amplitude_rate(
    model: Model,
    amplitude: Complexes,
    frequency: Floats,
    force: Complexes,
    frequency_rate: Floats | float = 0.0,
    shift: Complexes | float = 0.0,
    force_rate: Complexes | float = 0.0,
) -> Complexes:
    """da/dt (..., modes) at amplitudes (..., modes), without combination resonances.

    Parameters
    ----------
    frequency : (..., modes) ndarray
        Forcing frequencies [rad/s].
    force : (..., modes) complex ndarray
        F_j exp(i phase_j), modal [N kg^-1/2].
    frequency_rate : (..., modes) ndarray or float
        Rate of a sweep [rad/s^2]; the "paper" formulation has no such term.
    shift : (modes,) complex ndarray or float
        As `off_resonance_shift` gives it.
    force_rate : (..., modes) complex ndarray or float
        d(force)/dt.

    Notes
    -----
    The exact equation has a second derivative, a'' + mass a' + stiffness a = .... With v(a) the
    rate without it, a'' is v' along the flow to first order, so a' = v - v' / mass. To the same
    order friction lags behind that of steady motion (rate_correction). The paper neglects both.
    """
    frequency = np.asarray(frequency, dtype=float)
    v = first_order_rate(model, amplitude, frequency, force, frequency_rate, shift)
    if model.reduced.formulation == "paper":
        return v
    ahead = _SHORT_STEP / model.reduced.carrier[0]
    amplitude_ahead = amplitude + ahead * v
    frequency_ahead = frequency + ahead * np.asarray(frequency_rate)
    force_ahead = force + ahead * np.asarray(force_rate)
    later = first_order_rate(
        model, amplitude_ahead, frequency_ahead, force_ahead, frequency_rate, shift
    )
    factor = coupling_factor(model.reduced, frequency)
    effective = factor * (amplitude + shift * force)
    factor_ahead = coupling_factor(model.reduced, frequency_ahead)
    effective_ahead = factor_ahead * (amplitude_ahead + shift * force_ahead)
    growth = (np.abs(effective_ahead) - np.abs(effective)) / ahead
    rate_correction = np.einsum(
        "...jk,...k->...j", model.table.rate_correction_at(np.abs(effective)), growth
    )
    # from rest an amplitude has the direction in which it moves
    rate_correction = factor * rate_correction * _unit(effective_ahead)
    mass = linear_part(model.reduced, frequency).mass
    rate: Complexes = v - ((later - v) / ahead - rate_correction) / mass
    return rate


def first_order_rate(
    model: Model,
    amplitude: Complexes,
    frequency: Floats,
    force: Complexes,
    frequency_rate: Floats | float = 0.0,
    shift: Complexes | float = 0.0,
) -> Complexes:
    """The rate without the second derivative, see `amplitude_rate`: 0 at the same amplitudes."""
    part = linear_part(model.reduced, frequency)
    contact_force = friction_force(model, amplitude, frequency, shift * force)
    sweep = 0.0 if model.reduced.formulation == "paper" else 1j * np.asarray(frequency_rate)
    rate: Complexes = (
        0.5 * force + contact_force - (part.stiffness + sweep) * amplitude
    ) / part.mass
    return rate


def friction_force(
    model: Model, amplitude: Complexes, frequency: Floats, shift: Complexes | float = 0.0
) -> Complexes:
    """Q_j a_j (..., modes) at forcing frequencies (..., modes), tending to 0 with a_j.

    Without the combination resonances, whose mean over time is zero. `shift` is what the contacts
    feel on top of the amplitude: off_resonance_shift times the modal force.
    """
    factor = coupling_factor(model.reduced, np.asarray(frequency))
    effective = factor * (amplitude + shift)
    return np.asarray(factor * model.table(np.abs(effective)) * _unit(effective))


def _unit(effective: Complexes) -> Complexes:
    """Direction of what the contacts feel, 0 at rest."""
    modulus = np.abs(effective)
    tiny = np.finfo(float).tiny  # below it the quotient overflows
    return np.divide(effective, modulus, out=np.zeros_like(effective), where=modulus > tiny)
