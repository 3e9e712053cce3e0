"""Steady motion at many points, each under a constant load.

Relaxation and Newton's method solve all points at once. Where they do not converge, the slow flow
of the point is integrated from rest.
"""

from __future__ import annotations

from dataclasses import field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import OutsideTableError, SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.corrected_points import corrected_points
from slipmode.rom.slow.slow_flow import Balance, ForcedFlow
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers

INSIDE = 0.998  # of the table's range, so that the coupling ratio has room


@frozen
class SteadyPoints:
    """Steady amplitudes of many loads, and refusals."""

    amplitude: Complexes  # (points, modes), a_j [kg^1/2 m]; NaN where the load is refused
    is_direct: Flags  # (points,), whether friction is of the contact problem, not of the table
    refusals: dict[int, Exception] = field(default_factory=dict)  # By point

    @property
    def reason(self) -> list[str]:
        """Why each point is refused; "" where there is an amplitude."""
        return [str(self.refusals.get(k, "")) for k in range(len(self.amplitude))]

    @property
    def outside(self) -> Flags:
        """Whether each point (points,) is outside the friction table: a larger one would help."""
        refusals = (self.refusals.get(k) for k in range(len(self.amplitude)))
        return np.array([isinstance(each, OutsideTableError) for each in refusals], dtype=bool)


def steady_points(
    model: Model, frequency: Floats, applied: AppliedForces, excitation: Complexes
) -> SteadyPoints:
    """Return the steady states of many loads, reached from rest.

    A load is a `frequency` (modes,) [rad/s] and an `excitation` F_j exp(i phase_j) (modes,), modal
    [N kg^-1/2]. All loads have the patterns of the `applied` forces, in any scale.
    """
    unknown = np.full(frequency.shape, np.nan, dtype=complex)
    found = SteadyPoints(unknown, np.zeros(len(frequency), dtype=bool))
    forced = excitation != 0.0
    for kind in np.unique(forced, axis=0):
        (alike,) = np.nonzero((forced == kind).all(axis=1))
        found.refusals.update(_refusals(model.reduced, frequency, kind, alike))
    (places,) = np.nonzero([k not in found.refusals for k in range(len(frequency))])
    if places.size:
        problem = _SteadyFlow.of(model, frequency[places], excitation[places], applied.shift)
        _solve(problem, places, found)
        for k, corrected in corrected_points(problem, found.amplitude[places], applied):
            place = int(places[k])
            if isinstance(corrected, SlipmodeError):
                found.amplitude[place], found.refusals[place] = np.nan, corrected
            else:  # the same if the table's error is below the tolerance
                found.is_direct[place] = (corrected != found.amplitude[place]).any()
                found.amplitude[place] = corrected
    return found


def _refusals(
    reduced: Reduced, frequency: Floats, forced: Flags, points: NDArray[np.intp]
) -> dict[int, Exception]:
    """Return the refusals of frequencies of some points, whose forces act on the same modes."""
    try:
        check_carriers(reduced, frequency[points], forced)
    except SlipmodeError as refusal:
        if points.size == 1:
            return {int(points[0]): refusal}
        each = (_refusals(reduced, frequency, forced, points[[k]]) for k in range(points.size))
        return {point: reason for found in each for point, reason in found.items()}
    return {}


def _solve(problem: _SteadyFlow, places: NDArray[np.intp], found: SteadyPoints) -> None:
    """Solve for points; where one stops the iterations of all, each by itself."""
    try:
        amplitude = problem.newton(problem.relaxed())
        steady = problem.is_steady(amplitude)
    except (SlipmodeError, np.linalg.LinAlgError) as refusal:
        if places.size == 1:
            found.refusals[int(places[0])] = refusal
            return
        for k in range(places.size):
            _solve(problem.only(k), places[[k]], found)
        return
    found.amplitude[places[steady]] = amplitude[steady]
    for k in np.flatnonzero(~steady).tolist():
        place = int(places[k])
        try:
            found.amplitude[place] = problem.only(k).from_rest()
        except (SlipmodeError, np.linalg.LinAlgError) as refusal:
            found.refusals[place] = refusal


class _SteadyFlow(ForcedFlow):
    """da/dt = 0 at points."""

    def only(self, point: int) -> Self:
        """Return the problem at one of the points."""
        return self.with_inputs(self.inputs[[point]])

    def balance(self, amplitude: Complexes) -> Balance:
        """Return the terms of the amplitude equations; refuse amplitudes outside the table."""
        found = super().balance(amplitude)
        outside = np.isnan(found.rate).any(axis=-1)
        if outside.any() and self._excited.any():
            raise SlipmodeError(
                f"amplitude: self-excited mode {_named(self._excited)} leaves the friction table, "
                f"whose range is {self.model.table.amplitude_range}; rom.limit_cycles finds the "
                "amplitude at which friction limits it"
            )
        if outside.any():
            raise outside_table(np.abs(self.effective(amplitude))[outside], self.model.table)
        return found

    def relaxed(self) -> Complexes:
        """Return amplitudes near (stiffness - Q) a = F / 2 + Q shift F, half steps from rest."""
        force = self.force
        moving = np.arange(len(force))
        start = np.broadcast_to(1e-6 * self._range, force.shape)
        amplitude = self._inside(start.astype(complex))
        for _ in range(60):
            part = self.with_inputs(self.inputs[moving])
            before = amplitude[moving]
            balanced = part.secant_response(part.balance(before), before)
            step = np.minimum(np.abs(balanced), self._range) - np.abs(before)
            modulus = np.maximum(np.abs(before) + 0.5 * step, 1e-12 * self._range)
            amplitude[moving] = part._inside(phasor(modulus, np.angle(balanced)))
            # Newton's method continues from smaller changes.
            moving = moving[(np.abs(step) > 1e-4 * self._range).any(axis=-1)]
            if moving.size == 0:
                break
        return np.where(force == 0.0, 0.0, amplitude)  # an unforced mode is at rest

    def newton(self, start: Complexes) -> Complexes:
        """Return amplitudes at which da/dt = 0, by Newton's method inside the table."""
        moving = np.arange(len(start))
        found = self._inside(start)
        for _ in range(25):
            part, before = self.with_inputs(self.inputs[moving]), found[moving]
            rate, jacobian = part.rate_and_jacobian(before)
            update = np.linalg.solve(jacobian, rate[..., np.newaxis])[..., 0]
            after = part._inside(before - np.ascontiguousarray(update).view(complex))
            found[moving] = after
            moving = moving[np.abs(after - before).max(axis=-1) > 1e-11 * self._range.max()]
            if moving.size == 0:
                break
        return found

    def _is_balanced(self, amplitude: Complexes) -> Flags:
        """Return where the residual is rounding against the forces, (points,)."""
        now = self.balance(amplitude)
        elastic = np.abs(now.stiffness * amplitude).max(axis=-1)
        scale = 0.5 * np.abs(self.force).max(axis=-1) + elastic + 1e-300
        return np.asarray(np.abs(now.mass * now.rate).max(axis=-1) <= 1e-10 * scale)

    def is_steady(self, amplitude: Complexes) -> Flags:
        """Return where amplitudes are steady and, with self-excited modes, stable, (points,)."""
        steady = self._is_balanced(amplitude)
        if self._excited.any():
            _, jacobian = self.rate_and_jacobian(amplitude)
            steady &= np.linalg.eigvals(jacobian).real.max(axis=-1) < 0.0
        return steady

    def from_rest(self) -> Complexes:
        """Return the steady state (modes,) of the one point, by integration from rest."""
        from scipy.integrate import solve_ivp  # takes longer to import than many a table

        slowest = np.abs(self.model.reduced.modal_damping).min()
        if slowest <= 0.0:
            slowest = 1e-3 * self.model.reduced.frequency.min()
        y = np.zeros(2 * self.model.modes)
        free = self._excited & (self.force[0] == 0.0)
        # Whether the last stage inside the table was close to its edge, or none was inside.
        at_edge = True

        def rate(_: float, z: Floats) -> Floats:
            nonlocal at_edge
            # NaN where a trial stage leaves the table: a shorter step follows. At the edge steps
            # would become so short that they change no amplitude.
            if np.isnan(z).any():
                return z
            amplitude = z.view(complex)[np.newaxis]
            flow = self.balance(amplitude) if at_edge else ForcedFlow.balance(self, amplitude)
            now: Floats = flow.rate[0].view(float)
            if not np.isnan(now).any():
                at_edge = bool((np.abs(self.effective(amplitude)) > self._range).any())
            return now

        for _ in range(20):
            path = solve_ivp(rate, (0.0, 10.0 / slowest), y, rtol=1e-8, atol=1e-12)
            y = path.y[:, -1]
            point = self.newton(y.view(complex)[np.newaxis])
            if self.is_steady(point)[0]:
                return np.asarray(point[0])
            if free.any() and self._is_balanced(point)[0]:
                raise SlipmodeError(
                    f"aerodynamics: mode {_named(free)} is self-excited and not forced, so its "
                    "state of rest is unstable; rom.limit_cycles finds its limit cycles"
                )
        held = ""
        if self._excited.any():
            held = f", and mode {_named(self._excited)} is self-excited"
        raise SlipmodeError(
            f"frequency: no steady state was found at {self.frequency[0]} rad/s{held}"
        )

    def _inside(self, amplitude: Complexes) -> Complexes:
        """Return amplitudes scaled back where the effective ones would leave the table."""
        shifted = self.shift * self.force
        modulus = np.abs(amplitude + shifted)
        over = modulus > self.model.table.amplitude_range
        factor = np.divide(self._range, modulus, out=np.ones(modulus.shape), where=over)
        return np.where(over, factor * (amplitude + shifted) - shifted, amplitude)

    @property
    def _excited(self) -> Flags:
        """Self-excited modes, (modes,)."""
        return np.asarray(self.model.reduced.modal_damping < 0.0)

    @property
    def _range(self) -> Floats:
        return INSIDE * self.model.table.amplitude_range


def _named(modes: Flags) -> str:
    """Return A, B, or both."""
    return " and ".join("AB"[j] for j in np.flatnonzero(modes))
