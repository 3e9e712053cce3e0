"""Steady states of the slow flow: resonance curves and surfaces, Eqs. (22)-(25)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from rom.amplitude import Complexes, amplitude_rate, friction_force, linear_part
from rom.errors import SlipmodeError
from rom.matrices import Floats
from rom.model import Model

Force = Sequence[Mapping[int, float] | ArrayLike]

_RELAXATION_PASSES = 60
_NEWTON_PASSES = 25
_CURVE_PASSES = 12
_CONVERGED = 1e-10  # of the forces in the amplitude equation


@dataclass(frozen=True, eq=False)
class ResonanceCurve:
    """Forcing frequencies at which a mode vibrates with given amplitudes, Eq. (23) or (25).

    Attributes
    ----------
    amplitude : (n,) ndarray
        |a_j| [kg^1/2 m].
    below, above : (n,) ndarray
        Frequency on the branch below and above the peak [rad/s]; NaN where the force does not
        reach the amplitude.
    """

    amplitude: Floats
    below: Floats
    above: Floats


@dataclass(frozen=True, eq=False)
class ResonanceSurface:
    """Steady amplitudes over a grid of both forcing frequencies.

    Attributes
    ----------
    frequency_A : (n_A,) ndarray
    frequency_B : (n_B,) ndarray
        [rad/s]
    amplitude : (n_A, n_B, 2) complex ndarray
        a_A and a_B [kg^1/2 m].
    """

    frequency_A: Floats
    frequency_B: Floats
    amplitude: Complexes

    @property
    def euclidean(self) -> Floats:
        """sqrt(|a_A|^2 + |a_B|^2), (n_A, n_B)."""
        return np.asarray(np.linalg.norm(self.amplitude, axis=-1))


def steady(
    model: Model,
    frequency: ArrayLike,
    force: Force,
    phase: Sequence[float] = (0.0, 0.0),
) -> Complexes:
    """Steady complex amplitudes under constant forcing, on the branch reached from rest.

    Parameters
    ----------
    model : Model
    frequency : (..., modes) array_like
        Forcing frequencies [rad/s].
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N].
    phase : sequence of float
        Phases of the forces [rad].

    Returns
    -------
    (..., modes) complex ndarray
        x = 2 Re(sum_j mode_shape_j a_j exp(i Omega_j t)) plus the contacts' share.

    Raises
    ------
    SlipmodeError
        If an amplitude would leave the table, or the slow flow does not come to rest.
    """
    Omega = np.atleast_1d(np.asarray(frequency, dtype=float))
    if Omega.shape[-1] != model.modes or not np.all(np.isfinite(Omega) & (Omega > 0)):
        raise SlipmodeError(
            f"frequency: must be finite and > 0 with a last axis of length {model.modes} [rad/s]"
        )
    excitation = _excitation(model, force, phase)
    points = Omega.reshape(-1, model.modes)
    amplitude = _polish(model, points, excitation, _relax(model, points, excitation))
    error = _imbalance(model, points, excitation, amplitude)
    for point in np.flatnonzero(error > _CONVERGED):
        amplitude[point] = _from_rest(model, points[point], excitation)
    return amplitude.reshape(Omega.shape)


def resonance(
    model: Model, force: Force, frequency_A: ArrayLike, frequency_B: ArrayLike
) -> ResonanceSurface:
    """Steady amplitudes over frequency_A x frequency_B [rad/s]."""
    axis_A, axis_B = (np.asarray(axis, dtype=float) for axis in (frequency_A, frequency_B))
    grid = np.stack(np.meshgrid(axis_A, axis_B, indexing="ij"), axis=-1)
    return ResonanceSurface(axis_A, axis_B, steady(model, grid, force))


def resonance_curve(
    model: Model, mode: int, force: Mapping[int, float] | ArrayLike, amplitudes: ArrayLike
) -> ResonanceCurve:
    """Solve the amplitude equation for the frequency instead of the amplitude.

    Parameters
    ----------
    mode : int
        0 for A, 1 for B.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes [N] on this mode.
    amplitudes : (n, modes) array_like
        Amplitudes of all modes; the other mode's may be held.
    """
    points = np.asarray(amplitudes, dtype=float)
    r = points[:, mode]
    half_force = 0.5 * abs(model.reduced.modal_force(mode, force)) / r
    omega, gamma = model.reduced.frequency[mode], model.reduced.modal_damping[mode]
    paper = model.reduced.formulation == "paper"

    def reach_at(Omega: Floats) -> tuple[Complexes, Floats]:
        """Q, and the square of the detuning that the force affords, at frequencies Omega."""
        frequencies = np.tile(model.reduced.carrier, (r.size, 1))
        frequencies[:, mode] = Omega
        Q = friction_force(model, points.astype(complex), frequencies)[:, mode] / r
        loss = Q.imag - gamma * (omega if paper else Omega)
        return Q, half_force**2 - loss**2

    def branch(sign: float) -> Floats:
        Omega = np.full(r.shape, omega)
        for _ in range(_CURVE_PASSES):  # friction and damping move with Omega, weakly
            Q, square = reach_at(Omega)
            reach = sign * np.sqrt(np.maximum(square, 0.0))
            Omega = (
                omega - (Q.real - reach) / (2 * omega)
                if paper
                else np.sqrt(np.maximum(omega**2 - Q.real + reach, 0.0))
            )
        return np.where(square >= 0.0, Omega, np.nan)

    return ResonanceCurve(r, branch(-1.0), branch(1.0))


def _excitation(model: Model, force: Force, phase: Sequence[float]) -> Complexes:
    """F_j exp(i phase_j), (modes,)."""
    if len(force) != model.modes:
        raise SlipmodeError(f"force: needs one entry per mode ({model.modes}), got {len(force)}")
    modal = [model.reduced.modal_force(mode, pattern) for mode, pattern in enumerate(force)]
    turned: Complexes = np.array(modal) * np.exp(1j * np.asarray(phase)[: model.modes])
    return turned


def _relax(model: Model, Omega: Floats, excitation: Complexes) -> Complexes:
    """A = F / 2 / (stiffness - Q(|a|)), half a step at a time from rest."""
    stiffness = linear_part(model.reduced, Omega).stiffness
    limit = 0.999 * model.table.limit
    modulus = np.zeros(Omega.shape)
    amplitude = np.zeros(Omega.shape, dtype=complex)
    tiny = 1e-6 * limit
    for _ in range(_RELAXATION_PASSES):
        probe = np.maximum(modulus, tiny).astype(complex)
        Q = friction_force(model, probe, Omega) / probe
        amplitude = 0.5 * excitation / (stiffness - Q)
        modulus = 0.5 * (modulus + np.minimum(np.abs(amplitude), limit))
    scale = np.divide(modulus, np.abs(amplitude), out=np.zeros(Omega.shape), where=modulus > 0)
    return amplitude * np.minimum(scale, 1.0)


def _polish(model: Model, Omega: Floats, excitation: Complexes, start: Complexes) -> Complexes:
    """Newton's method for da/dt = 0 at all points at once, inside the table."""
    unknowns = 2 * model.modes
    limit = model.table.limit

    def rate(real: Floats) -> Floats:
        amplitude = real.view(complex)
        return amplitude_rate(model, amplitude, Omega, excitation).view(float)

    def inside(real: Floats) -> Floats:
        amplitude = real.view(complex).copy()
        modulus = np.abs(amplitude)
        over = modulus > 0.999 * limit
        amplitude[over] *= (
            0.999 * np.broadcast_to(limit, modulus.shape) / np.maximum(modulus, 1e-300)
        )[over]
        return amplitude.view(float)

    y = inside(np.ascontiguousarray(start).view(float))
    step = 1e-7 * limit.max()
    for _ in range(_NEWTON_PASSES):
        residual = rate(y)
        jacobian = np.empty((*y.shape, unknowns))
        for k in range(unknowns):
            shifted = y.copy()
            shifted[:, k] += step
            jacobian[..., k] = (rate(shifted) - residual) / step
        y = inside(y - np.linalg.solve(jacobian, residual[..., np.newaxis])[..., 0])
    return y.view(complex)


def _imbalance(model: Model, Omega: Floats, excitation: Complexes, amplitude: Complexes) -> Floats:
    """Unbalanced force in the amplitude equations relative to the forces in them, (points,)."""
    stiffness = linear_part(model.reduced, Omega).stiffness
    balance = 0.5 * excitation + friction_force(model, amplitude, Omega) - stiffness * amplitude
    scale = 0.5 * np.abs(excitation).max() + np.abs(stiffness * amplitude).max(axis=-1) + 1e-300
    return np.asarray(np.abs(balance).max(axis=-1) / scale)


def _from_rest(model: Model, Omega: Floats, excitation: Complexes) -> Complexes:
    """Integrate the slow flow from rest until it stands still: slow, but it cannot miss."""

    def rate(_: float, y: Floats) -> Floats:
        amplitude = y.view(complex)
        return amplitude_rate(model, amplitude, Omega, excitation).view(float)

    slowest = model.reduced.modal_damping.min()
    if slowest <= 0.0:
        slowest = 1e-3 * model.reduced.frequency.min()
    y = np.zeros(2 * model.modes)
    for _ in range(20):
        y = solve_ivp(rate, (0.0, 10.0 / slowest), y, rtol=1e-8, atol=1e-12).y[:, -1]
        point = _polish(model, Omega[np.newaxis], excitation, y.view(complex)[np.newaxis])
        if _imbalance(model, Omega[np.newaxis], excitation, point)[0] <= _CONVERGED:
            found: Complexes = point[0]
            return found
    raise SlipmodeError(f"frequency: no steady state found at {Omega} rad/s")
