"""Steady states of the slow flow: resonance curves and surfaces, Eqs. (22)-(25)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import off_resonance_shift
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import first_order_rate, friction_force, linear_part
from slipmode.rom.table.model import Model

Force = Sequence[Mapping[int, float] | ArrayLike]

_RELAXATION_PASSES = 60
_NEWTON_PASSES = 25
_CURVE_PASSES = 12
_RELAXED = 1e-4  # of the table's range: from there on it is Newton's
_SETTLED = 1e-11  # of the table's range: Newton's next update would be rounding
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

    __repr__ = short_repr


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

    __repr__ = short_repr

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
    problem = _Steady(
        model, _excitation(model, force, phase), off_resonance_shift(model.reduced, force)
    )
    points = Omega.reshape(-1, model.modes)
    amplitude = problem.polish(points, problem.relax(points))
    for point in np.flatnonzero(problem.imbalance(points, amplitude) > _CONVERGED):
        amplitude[point] = problem.from_rest(points[point])
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


@dataclass(frozen=True, eq=False)
class _Steady:
    """da/dt = 0 under a constant excitation F_j exp(i phase_j)."""

    model: Model
    excitation: Complexes
    shift: Complexes

    def rate(self, amplitude: Complexes, Omega: Floats) -> Complexes:
        return first_order_rate(self.model, amplitude, Omega, self.excitation, shift=self.shift)

    def friction(self, amplitude: Complexes, Omega: Floats) -> Complexes:
        return friction_force(self.model, amplitude, Omega, self.shift * self.excitation)

    def relax(self, Omega: Floats) -> Complexes:
        """A = F / 2 / (stiffness - Q(|a|)), half a step at a time from rest."""
        stiffness = linear_part(self.model.reduced, Omega).stiffness
        amplitude = np.broadcast_to(1e-6 * self._range, Omega.shape).astype(complex)
        for _ in range(_RELAXATION_PASSES):
            Q = self.friction(amplitude, Omega) / amplitude
            balanced = 0.5 * self.excitation / (stiffness - Q)
            before, wanted = np.abs(amplitude), np.minimum(np.abs(balanced), self._range)
            modulus = np.maximum(0.5 * (before + wanted), 1e-12 * self._range)
            amplitude = modulus * np.exp(1j * np.angle(balanced))
            if np.all(np.abs(wanted - before) <= _RELAXED * self._range):
                break
        return np.where(self.excitation == 0.0, 0.0, amplitude)  # an unforced mode is at rest

    def polish(self, Omega: Floats, start: Complexes) -> Complexes:
        """Newton's method, inside the table, at all points that still move."""
        found = self.inside(start)
        moving = np.arange(len(found))
        for _ in range(_NEWTON_PASSES):
            before = found[moving]
            after = self.inside(before - self._newton_update(Omega[moving], before))
            found[moving] = after
            moving = moving[np.abs(after - before).max(axis=-1) > _SETTLED * self._range.max()]
            if moving.size == 0:
                break
        return found

    def _newton_update(self, Omega: Floats, amplitude: Complexes) -> Complexes:
        """Jacobian^-1 rate (points, modes), the Jacobian by differences in one call."""
        y = amplitude.view(float)
        step = 1e-7 * self._range.max()
        shifts = np.vstack((np.zeros(y.shape[-1]), step * np.eye(y.shape[-1])))
        shifted = y + shifts[:, np.newaxis]  # (1 + 2 modes, points, 2 modes)
        rates = self.rate(shifted.view(complex), Omega).view(float)
        jacobian = np.moveaxis(rates[1:] - rates[0], 0, -1) / step
        return np.asarray(np.linalg.solve(jacobian, rates[0][..., np.newaxis])[..., 0]).view(
            complex
        )

    def imbalance(self, Omega: Floats, amplitude: Complexes) -> Floats:
        """Unbalanced force relative to the forces in the amplitude equations, (points,)."""
        stiffness = linear_part(self.model.reduced, Omega).stiffness
        elastic = stiffness * amplitude
        balance = 0.5 * self.excitation + self.friction(amplitude, Omega) - elastic
        scale = 0.5 * np.abs(self.excitation).max() + np.abs(elastic).max(axis=-1) + 1e-300
        return np.asarray(np.abs(balance).max(axis=-1) / scale)

    def from_rest(self, Omega: Floats) -> Complexes:
        """Integrate the slow flow from rest until it stands still: slow, but it cannot miss."""
        from scipy.integrate import solve_ivp  # takes longer to import than many a table

        slowest = self.model.reduced.modal_damping.min()
        if slowest <= 0.0:
            slowest = 1e-3 * self.model.reduced.frequency.min()
        y = np.zeros(2 * self.model.modes)
        points = Omega[np.newaxis]
        for _ in range(20):
            y = solve_ivp(
                lambda _, z: self.rate(z.view(complex), Omega).view(float),
                *((0.0, 10.0 / slowest), y),
                rtol=1e-8,
                atol=1e-12,
            ).y[:, -1]
            point = self.polish(points, y.view(complex)[np.newaxis])
            if self.imbalance(points, point)[0] <= _CONVERGED:
                found: Complexes = point[0]
                return found
        raise SlipmodeError(f"frequency: no steady state found at {Omega} rad/s")

    def inside(self, amplitude: Complexes) -> Complexes:
        """The amplitudes, scaled back to the table where they leave it."""
        modulus = np.abs(amplitude)
        over = modulus > self._range
        factor = np.divide(self._range, modulus, out=np.ones(modulus.shape), where=over)
        return amplitude * factor

    @property
    def _range(self) -> Floats:
        """A little inside the table, so that the coupling may turn."""
        return 0.998 * self.model.table.amplitude_range
