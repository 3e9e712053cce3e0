"""The slow flow, Eqs. (18) and (19), in the frame of the forcing.

mass_j a_j' + stiffness_j a_j = F_j exp(i phase_j) / 2 + Q_j(|a_A|, |a_B|) a_j
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rom import _kernel
from rom.matrices import Floats
from rom.model import Model
from rom.reduction import Reduced

Complexes = NDArray[np.complex128]


def slow_flow(model: Model) -> _kernel.SlowFlow:
    """The amplitude equations as the core reads them."""
    table = model.table.kernel()
    flow = _kernel.SlowFlow(paper=int(model.reduced.formulation == "paper"), table=table)
    for mode in range(model.modes):
        flow.natural[mode] = model.reduced.frequency[mode]
        flow.damping[mode] = model.reduced.modal_damping[mode]
        for power, coefficient in enumerate(_turn_coefficients(model.reduced)[mode]):
            flow.turn[mode][power][:] = (coefficient.real, coefficient.imag)
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


def _turn_coefficients(reduced: Reduced) -> Complexes:
    """c_k, (modes, 2): L(nu) is nearest to (1 + c_0 + i nu c_1) L(carrier)."""
    L = reduced.coupling
    parts = np.stack((reduced.spring - L, reduced.damper), axis=1)
    norm = np.sum(np.abs(L) ** 2, axis=1)[:, np.newaxis]
    return np.asarray(np.einsum("jkc,jc->jk", parts, L.conj()) / np.where(norm > 0, norm, 1.0))


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
) -> Complexes:
    """da/dt (..., modes) at amplitudes (..., modes).

    Parameters
    ----------
    frequency : (..., modes) ndarray
        Forcing frequencies [rad/s].
    force : (..., modes) complex ndarray
        F_j exp(i phase_j), modal [N kg^-1/2].
    frequency_rate : (..., modes) ndarray or float
        Rate of a sweep [rad/s^2]; the "paper" formulation has no such term.
    """
    part = linear_part(model.reduced, frequency)
    contact_force = friction_force(model, amplitude, frequency)
    sweep = 0.0 if model.reduced.formulation == "paper" else 1j * np.asarray(frequency_rate)
    rate: Complexes = (
        0.5 * force + contact_force - (part.stiffness + sweep) * amplitude
    ) / part.mass
    return rate


def friction_force(model: Model, amplitude: Complexes, frequency: Floats) -> Complexes:
    """Q_j a_j (..., modes) at forcing frequencies (..., modes), tending to 0 with a_j.

    Without the near resonances, whose mean over time is zero.
    """
    turn = coupling_turn(model.reduced, np.asarray(frequency))
    felt = turn * amplitude
    modulus = np.abs(felt)
    unit = np.divide(felt, modulus, out=np.zeros_like(felt), where=modulus > 0)
    return np.asarray(turn * model.table(modulus) * unit)
