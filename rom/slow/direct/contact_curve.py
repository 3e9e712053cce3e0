"""Steady states of the slow flow with friction from the contact problem, as a curve.

    mass_j a_j' = F_j / 2 - (omega_j^2 + sum_k h_jk |a_k|^2 - Omega_j^2 + i gamma_j Omega_j) a_j
        + S_j(a, Omega, F)

The continuation of the core follows it, as it follows curves with a friction table.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.nonlinear.stiffness import hardening
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.continuation import (
    Branch,
    Kind,
    Points,
    changes_of_stability,
    traced,
)
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_friction import (
    ContactFriction,
    ContactPoints,
    ContactSolutions,
)

# Steps of finite differences, relative to the range of the table and to the frequencies.
_AMPLITUDE_STEP, _FREQUENCY_STEP = 1e-4, 1e-5
# Fall of the rates from one pass of Newton's method to the next with which finite differences are
# not repeated.
_CONVERGING = 0.3
# Change of the unknowns, relative to the tolerance, by jumps of the force where a contact turns
# between two time steps: 1e-2 with 64 steps.
_NOISE = 0.02


@frozen
class _Known:
    """A point of the curve, or near it, with the scaled rates and their derivatives."""

    z: Floats  # (k + 1,)
    rate: Floats  # (k,)
    slope: Floats  # (k, k + 1)


class ContactCurve:
    """Steady states of a forced slow flow with friction from the contact problem.

    The k unknowns are the scaled amplitudes of `ForcedSlowFlow`, then resonant responses. Points
    z (k + 1,) end with the part of the span. The curve ends where an amplitude leaves the range of
    the table.
    """

    def __init__(self, problem: ForcedSlowFlow, friction: ContactFriction) -> None:
        self.friction = friction
        self._problem = problem
        self._known: list[_Known] = []
        self._raised: BaseException | None = None
        self._amplitudes = 2 * problem.model.modes
        self._unknowns = self._amplitudes + 2 * friction.resonances.mode.size
        model = problem.model  # responses are scaled by the largest ones
        self._largest = friction.resonances.largest(model.reduced, model.table.amplitude_range)
        callback = kernel.CurveRates(self._called)
        self._curve = kernel.Curve(self._unknowns, problem.curve.largest_step, callback)
        self._curve.noise = _NOISE * problem.model.accuracy.tolerance
        self._curve.owned["callback"] = callback

    def solved(self, z: Floats) -> Floats | None:
        """Return the solution near scaled amplitudes and a part of the span; None without any.

        Both (2 modes + 1,), at the same part of the span.
        """
        full = np.insert(z, self._amplitudes, np.zeros(self._unknowns - self._amplitudes))
        status = kernel.lib.sm_curve_solved(self._curve, full)
        self._check()
        return self._without_responses(full) if status == kernel.OK else None

    def branch(self, z: Floats) -> Branch | None:
        """Return the curve through a solution (2 modes + 1,), without resonant responses."""
        known = self._nearest(z[np.newaxis])[0]
        branch = traced(self._curve, known.z)
        self._check()
        if branch is None:
            return None
        z, tangent = map(self._without_responses, (branch.points.z, branch.points.tangent))
        self._confirm(z)
        jacobian = self.derivatives(z)[:, :, :-1].reshape(len(z), -1)
        points = Points.of(np.hstack((z, tangent, jacobian)), self._amplitudes)
        special = [(kind, _between(points, k, kind)) for kind, k in changes_of_stability(points)]
        ends = [] if branch.closed else [end for end in z[[0, -1]] if self._goes_on(end)]
        return Branch(points, special, branch.closed, ends)

    def _goes_on(self, z: Floats) -> bool:
        """Return whether a curve ends at z (2 modes + 1,) before the end of the span or range."""
        largest = 1.0 - 2.0 * self._curve.largest_step
        size = float(np.abs(z[:-1].view(complex)).max())
        return 1e-6 < float(z[-1]) < 1.0 - 1e-6 and size < largest

    def solutions(self, z: Floats) -> ContactSolutions:
        """Return the friction with its resonant responses at solutions (points, 2 modes + 1)."""
        every = np.array([known.z for known in self._nearest(z)])
        return ContactSolutions(self.friction, self._parts(every)[1])

    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives (points, 2 modes, 2 modes + 1) of the rates of the amplitudes.

        At solutions z (points, 2 modes + 1), with the responses that follow them.
        """
        return self._amplitude_rates(np.array([known.slope for known in self._nearest(z)]))

    def _confirm(self, z: Floats) -> None:
        """Keep derivatives at unstable solutions by differences to the side of less growth.

        An unstable state is so by differences to either side: a jump of the force is at one of
        them.
        """
        growth = _growth(self.derivatives(z))
        for k in np.flatnonzero(growth > 0.0):
            (at,) = self._nearest(z[[k]])
            other = replace(at, slope=self._differences(at.z, at.rate, -1.0))
            if _growth(self._amplitude_rates(other.slope[np.newaxis]))[0] < growth[k]:
                self._known[self._known.index(at)] = other

    def _amplitude_rates(self, slope: Floats) -> Floats:
        """Return what `derivatives` does, from those by all unknowns (points, k, k + 1)."""
        n, rest = self._amplitudes, slice(self._amplitudes, self._unknowns)
        outer = np.delete(slope, rest, axis=2)
        follow = np.linalg.solve(slope[:, rest, rest], outer[:, rest])
        return np.asarray(outer[:, :n] - slope[:, :n, rest] @ follow)

    def _nearest(self, z: Floats) -> list[_Known]:
        every = self._without_responses(np.array([known.z for known in self._known]))
        return [self._known[int(np.argmin(((every - at) ** 2).sum(axis=1)))] for at in z]

    def _without_responses(self, z: Floats) -> Floats:
        return np.ascontiguousarray(
            np.delete(z, np.arange(self._amplitudes, self._unknowns), axis=-1)
        )

    def _parts(self, z: Floats) -> tuple[Complexes, Complexes]:
        """Return amplitudes and resonant responses at points (points, k + 1)."""
        scale = self._problem.at(z[:, -1]).inputs["limit_scale"][:, np.newaxis]
        q = np.ascontiguousarray(z[:, self._amplitudes : self._unknowns]).view(complex)
        return self._problem.amplitude(self._without_responses(z)), scale * self._largest * q

    def _check(self) -> None:
        """Raise what interrupted a call of the core."""
        if self._raised is not None:
            raise self._raised

    def _rates(self, z: Floats) -> Floats:
        """Return the scaled rates (points, k) at z (points, k + 1); NaN where unknown."""
        problem = self._problem
        flow, (a, q) = problem.at(z[:, -1]), self._parts(z)
        reduced, Omega = problem.model.reduced, flow.frequency
        contacts = self.friction.motion(ContactPoints.of(flow, a, q))
        omega, gamma = reduced.natural_at(Omega), reduced.modal_damping
        stiffness = omega**2 + np.abs(a) ** 2 @ hardening(reduced)
        stiffness = stiffness - Omega**2 + 1j * gamma * Omega
        mass = 0.5 * gamma + np.emath.sqrt(0.25 * gamma**2 - omega**2 + 0j) + 1j * Omega
        force = 0.5 * flow.force * (1.0 + self._through_dampers(Omega))
        rate = (force - stiffness * a + contacts.force) / mass
        size = problem.size(z[:, -1])[:, ::2]
        rate[(np.abs(a) > size).any(axis=1)] = np.nan
        scale = flow.inputs["limit_scale"][:, np.newaxis]
        scaled = np.hstack((rate / size, contacts.rate / (scale * self._largest)))
        return np.ascontiguousarray(scaled).view(float)

    def _through_dampers(self, frequency: Floats) -> Complexes:
        """Return `AppliedForces.through_dampers` at carriers (points, modes)."""
        reduced, applied = self._problem.model.reduced, self._problem.applied
        if not reduced.damping_coupling.any():
            return np.zeros(frequency.shape, dtype=complex)
        there = [reduced.at_carrier(each) for each in frequency.tolist()]
        return np.array([replace(applied, reduced=each).through_dampers for each in there])

    def _differences(self, z: Floats, rate: Floats, side: float = 1.0) -> Floats:
        """Return the derivatives (k, k + 1) of the rates at z (k + 1,), by steps to one side."""
        ends = self._problem.ends.frequency
        relative = max(float(np.abs(ends[1] / ends[0] - 1.0).max()), _FREQUENCY_STEP)
        step = np.full(z.size, _AMPLITUDE_STEP)
        step[-1] = min(_FREQUENCY_STEP / relative, _AMPLITUDE_STEP)
        step *= np.where(z > 0.5, -side, side)  # by default towards the inside
        return np.asarray((self._rates(z + np.diag(step)) - rate).T / step)

    def _called(self, _: object, z: Any, rates: Any, derivatives: Any) -> int:
        """Write rates and derivatives for the core."""
        k = self._unknowns
        try:
            found = self._near(np.ctypeslib.as_array(z, (k + 1,)).copy())
        except BaseException as raised:  # ctypes cannot pass it on
            self._raised = raised
            return int(kernel.NOT_CONVERGED)
        if not (np.isfinite(found.rate).all() and np.isfinite(found.slope).all()):
            return int(kernel.OUTSIDE_TABLE)
        self._known.append(found)
        np.ctypeslib.as_array(rates, (k,))[:] = found.rate
        np.ctypeslib.as_array(derivatives, (k, k + 1))[:] = found.slope
        return int(kernel.OK)

    def _near(self, z: Floats) -> _Known:
        """Return rates and derivatives at z; Broyden's update serves while Newton converges."""
        (rate,) = self._rates(z[np.newaxis])
        if self._known:
            last = self._known[-1]
            moved = z - last.z
            square = float(moved @ moved)
            if np.linalg.norm(rate) <= _CONVERGING * np.linalg.norm(last.rate) and square > 0.0:
                off = rate - last.rate - last.slope @ moved
                return _Known(z, rate, last.slope + np.outer(off, moved) / square)
        return _Known(z, rate, self._differences(z, rate))


def _growth(derivatives: Floats) -> Floats:
    """Return the largest growth of small deviations by `ContactCurve.derivatives`, (points,)."""
    return np.asarray(np.linalg.eigvals(derivatives[:, :, :-1]).real.max(axis=1))


def _between(points: Points, before: int, kind: Kind) -> Floats:
    """Return the fold or Hopf point (2 modes + 1,) after one of the points, interpolated."""
    value = points.tangent[:, -1] if kind == "fold" else points.eigenvalues[:, 0].real
    first, second = value[before : before + 2]
    part = first / (first - second) if first * second < 0.0 else 0.5
    return np.asarray((1.0 - part) * points.z[before] + part * points.z[before + 1])
