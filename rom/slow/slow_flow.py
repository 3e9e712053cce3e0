"""The slow flow, Eqs. (18) and (19), in the frame of the forcing.

mass_j a_j' + stiffness_j a_j = F_j exp(i phase_j) / 2 + Q_j(|a_A|, |a_B|) a_j
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import _kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.reduction import Reduced, force_vector
from slipmode.rom.table.model import Model

Forces = Sequence[Mapping[int, float] | ArrayLike]  # one {DOF: amplitude} or (n,) array per mode

_SHORT_STEP = 1e-4  # of a difference along the flow, in radians of mode A


def slow_flow(model: Model, force: Forces | None = None) -> _kernel.SlowFlow:
    """The amplitude equations as the core reads them, the forces acting as `felt_shift` says."""
    shift = None if force is None else felt_shift(model.reduced, force)
    across = None if force is None else answer_across(model.reduced, force)
    table = model.table.kernel()
    flow = _kernel.SlowFlow(paper=int(model.reduced.formulation == "paper"), table=table)
    for mode in range(model.modes):
        flow.natural[mode] = model.reduced.frequency[mode]
        flow.damping[mode] = model.reduced.modal_damping[mode]
        for power, coefficient in enumerate(_turn_coefficients(model.reduced)[mode]):
            flow.turn[mode][power][:] = (coefficient.real, coefficient.imag)
        if shift is not None:
            flow.shift[mode][:] = (shift[mode].real, shift[mode].imag)
        if across is not None:
            for other, answer in enumerate(across[mode]):
                flow.across[mode][other][:] = (answer.real, answer.imag)
    for k, term in enumerate(model.near):
        flow.near[k] = _kernel.Near(term.mode, term.n, term.m)
    flow.owned = table
    return flow


def coupling_turn(reduced: Reduced, frequency: Floats) -> Complexes:
    """How the coupling at (..., modes) [rad/s] differs from that at the carrier, a factor.

    Exact where all contacts of a mode turn alike, as with damping proportional to stiffness.
    """
    c = _turn_coefficients(reduced)
    turn: Complexes = 1.0 + c[:, 0] + 1j * frequency * c[:, 1]
    return turn


def answer_across(reduced: Reduced, force: Forces) -> Complexes:
    """Displacement of mode k by the force of another mode j, per unit of F_j, at the carriers.

    Returns
    -------
    (modes, modes) complex ndarray
        [k, j]; 0 on the diagonal, and in the paper's formulation.
    """
    across = np.zeros((len(reduced.modes), len(reduced.modes)), dtype=complex)
    if reduced.formulation == "paper":
        return across
    for j, pattern in enumerate(force):
        modal = reduced.all_shapes.T @ force_vector(pattern, reduced.n_dofs)
        if modal[j] == 0.0:
            continue
        answer = reduced.others_answer(j, reduced.carrier[j], 0.5 * modal / modal[j])
        across[:, j] = answer[: len(across)]
    return across


def felt_shift(reduced: Reduced, force: Forces) -> Complexes:
    """What the forces do to the contacts past their own mode, as a shift of its amplitude.

    Force j also acts on the contacts directly, by contact_shapes^T f, and through the other modes,
    which answer off resonance. The contacts feel a_j + shift_j F_j exp(i phase_j), F_j modal.
    Several contacts do not feel it along L_j: the shift does to the mode what the direct force
    does, with friction as linear as it is where the contacts move as in `contact_motion`.

    Parameters
    ----------
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force directions.

    Returns
    -------
    (modes,) complex ndarray
        0 in the paper's formulation.
    """
    shift = np.zeros(len(reduced.modes), dtype=complex)
    if reduced.formulation == "paper":
        return shift
    for j, pattern in enumerate(force):
        f = force_vector(pattern, reduced.n_dofs)
        modal = reduced.all_shapes.T @ f
        moved = reduced.contact_motion[j]
        drawn = moved @ reduced.coupling[j]
        if modal[j] == 0.0 or drawn == 0.0:
            continue
        Omega = reduced.carrier[j]
        driven = reduced.others_answer(j, Omega, modal)
        on_contacts = reduced.contact_shapes.T @ f - driven @ reduced.modal_coupling(Omega)
        shift[j] = -0.5 * (moved @ on_contacts) / drawn / modal[j]
    return shift


@lru_cache(maxsize=8)
def _turn_coefficients(reduced: Reduced) -> Complexes:
    """c_k, (modes, 2): L(nu) is nearest to (1 + c_0 + i nu c_1) L(carrier)."""
    L = reduced.coupling
    turned = 1j * reduced.carrier[:, np.newaxis] * reduced.damper
    parts = np.stack((-turned, reduced.damper), axis=1)
    norm = np.sum(np.abs(L) ** 2, axis=1)[:, np.newaxis]
    c = np.asarray(np.einsum("jkc,jc->jk", parts, L.conj()) / np.where(norm > 0, norm, 1.0))
    c.flags.writeable = False
    return c


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
    """da/dt (..., modes) at amplitudes (..., modes), without near resonances.

    Parameters
    ----------
    frequency : (..., modes) ndarray
        Forcing frequencies [rad/s].
    force : (..., modes) complex ndarray
        F_j exp(i phase_j), modal [N kg^-1/2].
    frequency_rate : (..., modes) ndarray or float
        Rate of a sweep [rad/s^2]; the "paper" formulation has no such term.
    shift : (modes,) complex ndarray or float
        As `felt_shift` gives it.
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
    turn = coupling_turn(model.reduced, frequency)
    felt = turn * (amplitude + shift * force)
    turn_ahead = coupling_turn(model.reduced, frequency_ahead)
    felt_ahead = turn_ahead * (amplitude_ahead + shift * force_ahead)
    growth = (np.abs(felt_ahead) - np.abs(felt)) / ahead
    lag = np.einsum("...jk,...k->...j", model.table.lag_at(np.abs(felt)), growth)
    # from rest an amplitude has the direction in which it moves
    lag = turn * lag * _unit(felt_ahead)
    mass = linear_part(model.reduced, frequency).mass
    rate: Complexes = v - ((later - v) / ahead - lag) / mass
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

    Without the near resonances, whose mean over time is zero. `shift` is what the contacts feel
    on top of the amplitude: felt_shift times the modal force.
    """
    turn = coupling_turn(model.reduced, np.asarray(frequency))
    felt = turn * (amplitude + shift)
    return np.asarray(turn * model.table(np.abs(felt)) * _unit(felt))


def _unit(felt: Complexes) -> Complexes:
    """Direction of what the contacts feel, 0 at rest."""
    modulus = np.abs(felt)
    tiny = np.finfo(float).tiny  # below it the quotient overflows
    return np.divide(felt, modulus, out=np.zeros_like(felt), where=modulus > tiny)
