"""Steady states of the slow flow: resonance curves and surfaces, Eqs. (22)-(25)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import Forces, off_resonance_shift, phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import (
    Balance,
    balance,
    inputs_of,
    rate_and_jacobian,
    shifted_flow,
)
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model
from slipmode.rom.validity import can_carry, check_carriers, motion_findings, warn

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
        reach the amplitude, or only at a frequency that a slow flow cannot follow, or where the
        friction table ends before the amplitude.
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
    force: Forces,
    phase: Sequence[float] = (0.0, 0.0),
) -> Complexes:
    """Steady complex amplitudes under constant forcing, on the branch reached from rest.

    Parameters
    ----------
    model : Model
    frequency : (..., modes) array_like
        Forcing frequencies [rad/s].
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N] on the DOFs: magnitude times pattern, which `fmu.Component` takes
        apart (`force_patterns`, and the inputs force_A and force_B).
    phase : sequence of float
        Phases of the forces [rad].

    Returns
    -------
    (..., modes) complex ndarray
        x = 2 Re(sum_j mode_shape_j a_j exp(i Omega_j t)) plus the contacts' share.

    Raises
    ------
    SlipmodeError
        If the frequency of a mode that is forced is none that its slow flow can follow, an
        amplitude would leave the table, or the slow flow does not come to rest: a self-excited
        mode only does where its force holds it.

    Warns
    -----
    ValidityWarning
        Where friction or the force strain what the method assumes.
    """
    Omega = np.atleast_1d(np.asarray(frequency, dtype=float))
    if Omega.shape[-1] != model.modes or not np.all(np.isfinite(Omega) & (Omega > 0)):
        raise SlipmodeError(
            f"frequency: must be finite and > 0 with a last axis of length {model.modes} [rad/s]"
        )
    excitation = excitation_of(model, force, phase)
    points = Omega.reshape(-1, model.modes)
    check_carriers(model.reduced, points, excitation != 0.0)
    shift = off_resonance_shift(model.reduced, force)
    problem = _Steady(model, excitation, shift, shifted_flow(model, shift))
    amplitude = problem.polish(points, problem.relax(points))
    for point in np.flatnonzero(~problem.is_steady(points, amplitude)):
        amplitude[point] = problem.from_rest(points[point])
    warn(motion_findings(model.reduced, model.law, force, np.abs(amplitude).max(axis=0)))
    return amplitude.reshape(Omega.shape)


def resonance(
    model: Model, force: Forces, frequency_A: ArrayLike, frequency_B: ArrayLike
) -> ResonanceSurface:
    """Steady amplitudes over a grid of both forcing frequencies, each reached from rest.

    Parameters
    ----------
    model : Model
        Of two modes.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N].
    frequency_A : (n_A,) array_like
    frequency_B : (n_B,) array_like
        [rad/s]
    """
    axis_A, axis_B = (np.asarray(axis, dtype=float) for axis in (frequency_A, frequency_B))
    grid = np.stack(np.meshgrid(axis_A, axis_B, indexing="ij"), axis=-1)
    return ResonanceSurface(axis_A, axis_B, steady(model, grid, force))


def resonance_curve(
    model: Model, mode: int, force: Mapping[int, float] | ArrayLike, amplitudes: ArrayLike
) -> ResonanceCurve:
    """Solve the amplitude equation for the frequency instead of the amplitude.

    Parameters
    ----------
    model : Model
    mode : int
        0 for A, 1 for B.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes [N] on this mode; what they do to the contacts directly is left out.
    amplitudes : (n, modes) array_like
        Amplitudes of all modes; the other mode's may be held.
    """
    points = np.asarray(amplitudes, dtype=float)
    r = points[:, mode]
    half_force = 0.5 * abs(model.reduced.modal_force(mode, force)) / r
    omega, gamma = model.reduced.frequency[mode], model.reduced.modal_damping[mode]
    paper = model.reduced.formulation == "paper"

    flow, still = shifted_flow(model, 0.0), np.zeros(points.shape, dtype=complex)

    def reach_at(Omega: Floats) -> tuple[Complexes, Floats]:
        """Q, and the square of the detuning that the force affords, at frequencies Omega."""
        frequencies = np.tile(model.reduced.carrier, (r.size, 1))
        lost = np.isnan(Omega)  # the table did not reach so far
        frequencies[:, mode] = np.where(lost, omega, Omega)
        friction = balance(flow, inputs_of(still, frequencies), points.astype(complex)).friction
        Q = np.where(lost, np.nan, friction[:, mode] / r)
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
        return np.where((square >= 0.0) & can_carry(omega, Omega), Omega, np.nan)

    return ResonanceCurve(r, branch(-1.0), branch(1.0))


def excitation_of(model: Model, force: Forces, phase: Sequence[float]) -> Complexes:
    """F_j exp(i phase_j), (modes,)."""
    if len(force) != model.modes:
        raise SlipmodeError(f"force: needs one entry per mode ({model.modes}), got {len(force)}")
    modal = [model.reduced.modal_force(mode, pattern) for mode, pattern in enumerate(force)]
    return phasor(np.array(modal), np.asarray(phase)[: model.modes])


@dataclass(frozen=True, eq=False)
class _Steady:
    """da/dt = 0 under a constant excitation F_j exp(i phase_j)."""

    model: Model
    excitation: Complexes
    shift: Complexes
    flow: kernel.SlowFlow

    def balance(self, amplitude: Complexes, inputs: NDArray[np.void]) -> Balance:
        found = balance(self.flow, inputs, amplitude)
        outside = np.isnan(found.rate).any(axis=-1)
        if outside.any() and self._excited.any():
            raise SlipmodeError(
                f"amplitude: self-excited mode {_named(self._excited)} leaves the friction table, "
                f"whose range is {self.model.table.amplitude_range}; rom.limit_cycles says how "
                "far friction holds it"
            )
        if outside.any():
            raise outside_table(np.abs(amplitude[outside]), self.model.table)
        return found

    def relax(self, Omega: Floats) -> Complexes:
        """(stiffness - Q) a = F / 2 + Q shift F, half a step at a time from rest."""
        off_resonance = self.shift * self.excitation
        amplitude = self.inside(np.broadcast_to(1e-6 * self._range, Omega.shape).astype(complex))
        moving, inputs = np.arange(len(amplitude)), self._inputs(Omega)
        for _ in range(_RELAXATION_PASSES):
            before = amplitude[moving]
            now = self.balance(before, inputs.take(moving))
            Q = now.friction / (before + off_resonance)
            balanced = (0.5 * self.excitation + Q * off_resonance) / (now.stiffness - Q)
            step = np.minimum(np.abs(balanced), self._range) - np.abs(before)
            modulus = np.maximum(np.abs(before) + 0.5 * step, 1e-12 * self._range)
            amplitude[moving] = self.inside(phasor(modulus, np.angle(balanced)))
            moving = moving[(np.abs(step) > _RELAXED * self._range).any(axis=-1)]
            if moving.size == 0:
                break
        return np.where(self.excitation == 0.0, 0.0, amplitude)  # an unforced mode is at rest

    def polish(self, Omega: Floats, start: Complexes) -> Complexes:
        """Newton's method, inside the table, at all points that still move."""
        found = self.inside(start)
        moving, inputs = np.arange(len(found)), self._inputs(Omega)
        for _ in range(_NEWTON_PASSES):
            before = found[moving]
            rate, jacobian = rate_and_jacobian(self.flow, inputs.take(moving), before)
            update = np.linalg.solve(jacobian, rate[..., np.newaxis])[..., 0]
            after = self.inside(before - np.ascontiguousarray(update).view(complex))
            found[moving] = after
            moving = moving[np.abs(after - before).max(axis=-1) > _SETTLED * self._range.max()]
            if moving.size == 0:
                break
        return found

    def imbalance(self, Omega: Floats, amplitude: Complexes) -> Floats:
        """Unbalanced force relative to the forces in the amplitude equations, (points,)."""
        now = self.balance(amplitude, self._inputs(Omega))
        elastic = np.abs(now.stiffness * amplitude).max(axis=-1)
        scale = 0.5 * np.abs(self.excitation).max() + elastic + 1e-300
        return np.asarray(np.abs(now.mass * now.rate).max(axis=-1) / scale)

    def is_steady(self, Omega: Floats, amplitude: Complexes) -> Flags:
        """Where the slow flow stands still and, with self-excited modes, returns to that."""
        stands = self.imbalance(Omega, amplitude) <= _CONVERGED
        if self._excited.any():
            _, jacobian = rate_and_jacobian(self.flow, self._inputs(Omega), amplitude)
            stands &= np.linalg.eigvals(jacobian).real.max(axis=-1) < 0.0
        return np.asarray(stands)

    def from_rest(self, Omega: Floats) -> Complexes:
        """Integrate the slow flow from rest until it stands still: slow, but it cannot miss."""
        from scipy.integrate import solve_ivp  # takes longer to import than many a table

        slowest = np.abs(self.model.reduced.modal_damping).min()
        if slowest <= 0.0:
            slowest = 1e-3 * self.model.reduced.frequency.min()
        y = np.zeros(2 * self.model.modes)
        free = self._excited & (self.excitation == 0.0)
        points = Omega[np.newaxis]
        inputs = self._inputs(points)

        def rate(_: float, z: Floats) -> Floats:
            moving: Floats = self.balance(z.view(complex)[np.newaxis], inputs).rate[0].view(float)
            return moving

        for _ in range(20):
            y = solve_ivp(rate, (0.0, 10.0 / slowest), y, rtol=1e-8, atol=1e-12).y[:, -1]
            point = self.polish(points, y.view(complex)[np.newaxis])
            if self.is_steady(points, point)[0]:
                found: Complexes = point[0]
                return found
            if free.any() and self.imbalance(points, point)[0] <= _CONVERGED:
                raise SlipmodeError(
                    f"force: mode {_named(free)} is self-excited and no force holds it: it does "
                    "not stay at rest; rom.limit_cycles has what it settles to"
                )
        held = ""
        if self._excited.any():
            held = f": self-excited mode {_named(self._excited)} is not held by its force there"
        raise SlipmodeError(f"frequency: no steady state found at {Omega} rad/s{held}")

    def _inputs(self, Omega: Floats) -> NDArray[np.void]:
        return inputs_of(np.broadcast_to(self.excitation, Omega.shape), Omega)

    def inside(self, amplitude: Complexes) -> Complexes:
        """The amplitudes, scaled back where the effective ones would leave the table."""
        off_resonance = self.shift * self.excitation
        modulus = np.abs(amplitude + off_resonance)
        over = modulus > self._range
        factor = np.divide(self._range, modulus, out=np.ones(modulus.shape), where=over)
        return np.where(over, factor * (amplitude + off_resonance) - off_resonance, amplitude)

    @property
    def _excited(self) -> Flags:
        """Self-excited modes, (modes,)."""
        return np.asarray(self.model.reduced.modal_damping < 0.0)

    @property
    def _range(self) -> Floats:
        """A little inside the table, so that the coupling ratio has room."""
        return 0.998 * self.model.table.amplitude_range


def _named(modes: Flags) -> str:
    """A, B, or both."""
    return " and ".join("AB"[j] for j in np.flatnonzero(modes))
