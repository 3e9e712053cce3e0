"""Steady states of the slow flow with friction from the contact problem, as a curve.

    mass_j a_j' = F_j / 2 - (omega_j^2 - Omega_j^2 + i gamma_j Omega_j) a_j + S_j(a, Omega, F)

The continuation of the core follows it, as it follows curves with a friction table.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_friction import ContactFriction, ContactPoints

# Steps of finite differences, relative to the range of the table and to the frequencies.
_AMPLITUDE_STEP, _FREQUENCY_STEP = 1e-4, 1e-5
# Largest distance of two points for which a rank-one update replaces finite differences, and the
# largest error of the linear prediction there, relative to the change of the rates.
_NEAR, _NONLINEAR = 0.05, 0.3
_SMALL = 1e-4  # distance below which differences of the rates are too inexact for an update


@frozen
class _Known:
    """A point of the curve, or near it, with the scaled rates and their derivatives."""

    z: Floats  # (k + 1,)
    rate: Floats  # (k,)
    slope: Floats  # (k, k + 1)


class ContactCurve:
    """Steady states of a forced slow flow with friction from the contact problem.

    The unknowns z = (Re a, Im a, ... / range, part of the span) are those of `ForcedSlowFlow`. The
    curve ends where an amplitude leaves the range of the table.
    """

    def __init__(self, problem: ForcedSlowFlow, friction: ContactFriction) -> None:
        self.friction = friction
        self._problem = problem
        self._known: list[_Known] = []
        self._raised: BaseException | None = None
        callback = kernel.CurveRates(self._called)
        known = problem.curve
        self.curve = kernel.Curve(known.unknowns, known.largest_step, callback)
        self.curve.owned["callback"] = callback

    def solved(self, z: Floats) -> Floats | None:
        """Return the solution (k + 1,) near z at the same part of the span; None without any."""
        found = z.copy()
        status = kernel.lib.sm_curve_solved(self.curve, found)
        self.check()
        return found if status == kernel.OK else None

    def check(self) -> None:
        """Raise what interrupted a call of the core."""
        if self._raised is not None:
            raise self._raised

    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives (points, k, k + 1) at solutions z (points, k + 1)."""
        every = np.array([known.z for known in self._known])
        nearest = [int(np.argmin(((every - each) ** 2).sum(axis=1))) for each in z]
        return np.array([self._known[k].slope for k in nearest])

    def _rates(self, z: Floats) -> Floats:
        """Return the scaled rates da/dt (points, k) at z (points, k + 1); NaN where unknown."""
        problem = self._problem
        flow, a = problem.at(z[:, -1]), problem.amplitude(z)
        reduced, Omega = problem.model.reduced, flow.frequency
        friction = self.friction(ContactPoints.of(flow, a))
        friction[(np.abs(a) > problem.size(z[:, -1])[:, ::2]).any(axis=1)] = np.nan
        omega, gamma = reduced.frequency, reduced.modal_damping
        stiffness = omega**2 - Omega**2 + 1j * gamma * Omega
        mass = 0.5 * gamma + np.emath.sqrt(0.25 * gamma**2 - omega**2 + 0j) + 1j * Omega
        force = 0.5 * flow.force * (1.0 + self._through_dampers(Omega))
        rate = (force - stiffness * a + friction) / mass
        return np.ascontiguousarray(rate).view(float) / problem.size(z[:, -1])

    def _through_dampers(self, frequency: Floats) -> Complexes:
        """Return `AppliedForces.through_dampers` at carriers (points, modes)."""
        reduced, applied = self._problem.model.reduced, self._problem.applied
        if not reduced.damping_coupling.any():
            return np.zeros(frequency.shape, dtype=complex)
        there = [reduced.at_carrier(each) for each in frequency.tolist()]
        return np.array([replace(applied, reduced=each).through_dampers for each in there])

    def _differences(self, z: Floats, rate: Floats) -> Floats:
        """Return the derivatives (k, k + 1) of the rates at z (k + 1,)."""
        ends = self._problem.ends.frequency
        relative = max(float(np.abs(ends[1] / ends[0] - 1.0).max()), _FREQUENCY_STEP)
        step = np.full(z.size, _AMPLITUDE_STEP)
        step[-1] = min(_FREQUENCY_STEP / relative, _AMPLITUDE_STEP)
        step *= np.where(z > 0.5, -1.0, 1.0)  # towards the inside
        return np.asarray((self._rates(z + np.diag(step)) - rate).T / step)

    def _called(self, _: object, z: Any, rates: Any, derivatives: Any) -> int:
        """Write rates and derivatives for the core."""
        k = self._problem.curve.unknowns
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
        """Return rates and derivatives at z, by Broyden's update from the last point nearby."""
        (rate,) = self._rates(z[np.newaxis])
        if self._known:
            last = self._known[-1]
            moved = z - last.z
            distance = float(np.linalg.norm(moved))
            if distance < _SMALL:
                return _Known(z, rate, last.slope)
            change, predicted = rate - last.rate, last.slope @ moved
            off = np.linalg.norm(change - predicted)
            if distance < _NEAR and off <= _NONLINEAR * np.linalg.norm(change):
                update = np.outer(change - predicted, moved) / distance**2
                return _Known(z, rate, last.slope + update)
        return _Known(z, rate, self._differences(z, rate))
