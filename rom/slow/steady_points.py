"""Steady motion at many points, each under a constant load.

Implicit steps in slow time lead all points from rest to their steady states at once. Where they
do not converge, shorter steps follow.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import OutsideTableError, SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.corrected_points import corrected_points
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers

INSIDE = 0.998  # of the table's range, so that the coupling ratio has room
# Time steps from rest: the first relative to the fastest change, the ratios of two in sequence of
# two attempts, and the logarithm of the largest step relative to the first. With longer steps
# amplitudes end on other branches near folds, where a contact opens.
_FIRST_STEP, _LONGER, _SPAN = 0.2, (1.5, 1.02), 40.0


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
        left = np.arange(places.size)
        for longer in _LONGER:
            part = problem.with_inputs(problem.inputs[left])
            amplitude = part.from_rest(longer)
            steady = part.is_steady(amplitude)
            found.amplitude[places[left[steady]]] = amplitude[steady]
            left = left[~steady]
        for k, at in zip(left.tolist(), amplitude[~steady], strict=True):
            found.refusals[int(places[k])] = problem.with_inputs(problem.inputs[[k]]).refusal(at)
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


class _SteadyFlow(ForcedFlow):
    """da/dt = 0 at points."""

    def from_rest(self, longer: float) -> Complexes:
        """Return amplitudes at which da/dt = 0, to which the slow flow leads inside the table.

        By steps of implicit Euler, each `longer` than the one before by this ratio
        (pseudo-transient continuation): the last ones are steps of Newton's method.
        """
        moving, found = np.arange(len(self.inputs)), self._inside(np.zeros_like(self.force))
        unit = np.eye(2 * found.shape[1])
        _, jacobian = self.rate_and_jacobian(found)
        fastest = np.linalg.norm(jacobian, axis=(1, 2))
        length = _FIRST_STEP / np.maximum(fastest, np.finfo(float).eps * self.frequency[:, 0])
        for _ in range(int(_SPAN / np.log(longer))):
            part, before = self.with_inputs(self.inputs[moving]), found[moving]
            rate, jacobian = part.rate_and_jacobian(before)
            slope = unit / length[moving, np.newaxis, np.newaxis] - jacobian
            step = np.linalg.solve(slope, rate[..., np.newaxis])[..., 0]
            after = part._inside(before + np.ascontiguousarray(step).view(complex))
            found[moving] = after
            length[moving] *= longer
            change, size = (np.abs(each).max(axis=-1) for each in (after - before, after))
            moving = moving[change > 1e-11 * size]
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

    def refusal(self, amplitude: Complexes) -> SlipmodeError:
        """Return why the one point has no steady state; the iteration ends at `amplitude`."""
        free, named = self._excited & (self.force[0] == 0.0), _named(self._excited)
        effective = np.abs(self.effective(amplitude[np.newaxis]))
        if free.any() and self._is_balanced(amplitude[np.newaxis])[0]:
            return SlipmodeError(
                f"aerodynamics: mode {_named(free)} is self-excited and not forced, so its "
                "state of rest is unstable; rom.limit_cycles finds its limit cycles"
            )
        at_edge = (effective > (1.0 - 1e-9) * self._range).any()
        if at_edge and self._excited.any():
            return SlipmodeError(
                f"amplitude: self-excited mode {named} leaves the friction table, "
                f"whose range is {self.model.table.amplitude_range}; rom.limit_cycles finds the "
                "amplitude at which friction limits it"
            )
        if at_edge:
            return outside_table(effective, self.model.table)
        held = f", and mode {named} is self-excited" if self._excited.any() else ""
        return SlipmodeError(
            f"frequency: no steady state was found at {self.frequency[0]} rad/s{held}"
        )

    def _inside(self, amplitude: Complexes) -> Complexes:
        """Return amplitudes scaled back where the effective ones would leave the table."""
        shifted, modulus = self.shift * self.force, np.abs(self.effective(amplitude))
        over = modulus > self._range
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
