"""The error of response curves, and folds and Hopf points that are smaller than it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import (
    TableError,
    change_along,
    curve_displacement,
    error_at_constant,
    known_inverse,
)
from slipmode.rom.slow.branches.continuation import Branch, Kind, Points
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.direct.contact_curve import ContactCurve
from slipmode.rom.slow.slow_flow import ForcedFlow

_DIFFERENCE = 1e-6  # of the span, for derivatives: far above rounding


@frozen
class CurveError:
    """The error of a response curve at its points."""

    amplitude: Floats  # (points, modes), of a_j at constant parameter [kg^1/2 m]
    rate: Floats  # (points, modes), of the scaled rates [1/s]
    # Largest error of a_j, relative to |a_j|, where friction misses what the table states at its
    # carriers; infinity where the contact motion does not converge
    beyond_table: float

    @classmethod
    def of(
        cls,
        problem: ForcedSlowFlow,
        z: Floats,
        branch: NDArray[np.intp],
        contact: ContactCurve | None,
    ) -> CurveError:
        """Return the error of solutions z (points, k + 1), neighbours of a branch in sequence.

        `contact` is the curve if its friction is not the table's.
        """
        points = _Solutions(problem, z, contact)
        y, size = points.y, points.size

        def error_of(change: Floats) -> Floats:
            """Return the error of y by a change of the scaled rates of any phase."""
            displacement = curve_displacement(points.linear, change)
            at_constant = curve_displacement(points.linear[:, :, :-1], change)[0]
            return error_at_constant(z[:, -1], y, branch, displacement, np.minimum(at_constant, 1))

        table = points.table_error
        rate = np.abs(points.rate_change(table.size)) + points.neglected_force
        error = error_of(np.abs(points.rate_change(table.stated)) + points.neglected_force)
        beyond_table = 0.0
        if table.at.size:
            part = np.abs(table.measured) / table.scale[table.at]
            largest = np.nan_to_num(part, nan=1.0).max() * table.scale
            of_any_phase = error_of(np.abs(points.rate_change(largest)))
            moved = points.moved(branch, table.at, table.measured)
            least = np.maximum(of_any_phase[table.at], np.finfo(float).tiny)
            error = error + table.between(np.minimum(moved / least, 1.0)) * of_any_phase
            modulus = np.abs(y[table.at])
            share = np.divide(moved, modulus, out=np.zeros_like(moved), where=modulus > 0.0)
            share[part <= problem.model.accuracy.total] = 0.0
            beyond_table = float(np.nan_to_num(share, nan=np.inf).max())
        return cls(size * error, rate, beyond_table)

    def at(self, points: NDArray[np.intp]) -> CurveError:
        """Return the error of some points, or of all in another order."""
        return CurveError(self.amplitude[points], self.rate[points], self.beyond_table)


@dataclass(frozen=True, eq=False)
class _Solutions:
    """Solutions z (points, k + 1) of a forced slow flow, and its derivatives there."""

    problem: ForcedSlowFlow
    z: Floats
    contact: ContactCurve | None = None  # the curve, if its friction is not the table's

    @cached_property
    def flow(self) -> ForcedFlow:
        return self.problem.at(self.z[:, -1])

    @property
    def y(self) -> Complexes:
        """Scaled amplitudes (points, modes)."""
        return np.ascontiguousarray(self.z[:, :-1]).view(complex)

    @property
    def size(self) -> Floats:
        """Amplitudes (points, modes) whose scaled ones are 1 [kg^1/2 m]."""
        return self.problem.size(self.z[:, -1])[:, ::2]

    @cached_property
    def linear(self) -> Floats:
        """Derivatives of the scaled rates by z, (points, k, k + 1).

        NaN at the end of the friction table.
        """
        if self.contact is not None:
            return self.contact.derivatives(self.z)
        size = self.problem.size(self.z[:, -1])
        _, jacobian = self.flow.rate_and_jacobian(self.problem.amplitude(self.z))
        step = _DIFFERENCE * np.eye(self.z.shape[1])[-1]
        above, below = (self._rates(self.z + side) for side in (step, -step))
        by_parameter = (above - below)[..., np.newaxis] / (2.0 * _DIFFERENCE)
        by_y = jacobian * size[:, np.newaxis] / size[:, :, np.newaxis]
        return np.concatenate((by_y, by_parameter), axis=2)

    def _rates(self, z: Floats) -> Floats:
        rate = self.problem.at(z[:, -1]).balance(self.problem.amplitude(z)).rate
        return np.ascontiguousarray(rate).view(float) / self.problem.size(z[:, -1])

    @cached_property
    def _mass(self) -> Complexes:
        """Factor of the scaled rates in the amplitude equations, (points, modes)."""
        mass = self.flow.balance(self.problem.amplitude(self.z)).mass
        return np.asarray(mass * self.size)

    @cached_property
    def table_error(self) -> TableError:
        """The error of S_j, see `TableError.of`."""
        used = None if self.contact is None else self.contact.solutions(self.z)
        amplitude = self.problem.amplitude(self.z)
        return TableError.of(self.flow, amplitude, self.problem.applied, used)

    def rate_change(self, friction: Complexes | Floats) -> Complexes:
        """Return the change of the scaled rates (points, modes) by a change of S_j."""
        factor = coupling_factor(self.flow.model.reduced, self.flow.frequency)
        turned = np.exp(1j * np.angle(self.flow.effective(self.problem.amplitude(self.z))))
        return np.asarray(factor * turned * friction / self._mass)

    def moved(self, branch: NDArray[np.intp], at: NDArray[np.intp], force: Complexes) -> Floats:
        """Return errors of y (some, modes) at points `at` by forces on the modes (some, modes).

        NaN where the force or the derivatives are not known.
        """
        linear, width = self.linear[at], np.zeros(len(self.z))
        rate = np.ascontiguousarray(force / self._mass[at]).view(float)[..., np.newaxis]
        moved = (known_inverse(linear) @ rate)[..., 0]
        at_constant = (known_inverse(linear[:, :, :-1]) @ rate)[..., 0]
        width[at] = np.nan_to_num(np.abs(moved[:, -1]))
        near = np.abs(np.ascontiguousarray(moved[:, :-1]).view(complex))
        near += change_along(self.z[:, -1], self.y, branch, width)[at]
        return np.asarray(np.minimum(near, np.abs(at_constant.view(complex))))

    @property
    def neglected_force(self) -> Floats:
        """Scaled rates (points, modes) by the force through dampers, which tables neglect."""
        if self.contact is not None:
            return np.zeros(self.y.shape)
        force = self.flow.force * self.problem.applied.through_dampers
        return np.asarray(np.abs(0.5 * force / self._mass))


def significant_specials(
    problem: ForcedSlowFlow,
    branches: list[Branch],
    error: CurveError,
    contact: ContactCurve | None,
) -> tuple[list[tuple[Kind, Floats]], Flags]:
    """Return folds and Hopf points that are larger than the error; points between the others.

    Unstable states in sequence are left out, with their folds and Hopf points, if the error may
    make them unstable. So are two folds or Hopf points in sequence whose distance in the parameter
    is below its error there. `contact` is the curve if its friction is not the table's.
    """
    ends = np.cumsum([len(branch.points.rows) for branch in branches])[:-1]
    found: list[tuple[Kind, Floats]] = []
    between = []
    for branch, rate in zip(branches, np.split(error.rate, ends), strict=True):
        kept, small = _significant(branch, rate, problem, contact)
        found += kept
        between.append(small)
    return found, np.concatenate(between)


def _significant(
    branch: Branch, rate: Floats, problem: ForcedSlowFlow, contact: ContactCurve | None
) -> tuple[list[tuple[Kind, Floats]], Flags]:
    points = branch.points
    between = _stable_within_error(points, rate)
    if not branch.special:  # a step of the continuation may pass over a pair of folds
        return [], between
    places = np.array([_segment(points.z, z) for _, z in branch.special])
    small = between[places] | between[places + 1]
    kept = np.flatnonzero(~small).tolist()
    at = _Solutions(problem, np.array([z for _, z in branch.special]), contact)
    error = np.nan_to_num(curve_displacement(at.linear, rate[places])[1])  # of the parameter

    def apart(first: int, second: int) -> float:
        (kind, z), (other, z_other) = branch.special[first], branch.special[second]
        if kind != other:
            return np.inf
        return float(abs(z[-1] - z_other[-1]) / (error[first] + error[second] + 1e-300))

    while len(kept) > 1:
        size = [apart(*pair) for pair in pairwise(kept)]
        least = int(np.argmin(size))
        if size[least] > 1.0:
            break
        between[places[kept[least]] + 1 : places[kept[least + 1]] + 1] = True
        del kept[least : least + 2]
    return [branch.special[k] for k in kept], between


def _stable_within_error(points: Points, rate: Floats) -> Flags:
    """Return unstable points of a branch that the error of the rates may have made unstable.

    `rate` (points, modes) is the error of the scaled rates. The growth is a slope of the rates, so
    that its integral along a part of the curve has the errors of the rates at both ends.
    """
    size = np.abs(np.ascontiguousarray(points.z[:, :-1]).view(complex))
    growth_error = np.nan_to_num(rate / np.maximum(size, 1e-12)).max(axis=1)
    growth, number = points.eigenvalues[:, 0].real, len(rate)
    unstable = np.concatenate(([False], points.unstable > 0, [False]))
    starts, ends = np.flatnonzero(np.diff(unstable)).reshape(-1, 2).T
    found = np.zeros(number, dtype=bool)
    for start, end in zip(starts, ends, strict=True):
        first, last = max(start - 1, 0), min(end, number - 1)
        part = slice(first, last + 1)
        steps = np.linalg.norm(np.diff(points.z[part, :-1], axis=0), axis=1)
        excess = np.maximum(growth[part], 0.0) - growth_error[part]
        integral = float(steps @ (0.5 * (excess[:-1] + excess[1:])))
        found[start:end] = integral <= np.linalg.norm(rate[[first, last]], axis=1).sum()
    return found


def _segment(z: Floats, at: Floats) -> int:
    """Return the point of a curve (points, k + 1) after which a solution lies."""
    distance = np.linalg.norm(z - at, axis=1)
    detour = distance[:-1] + distance[1:] - np.linalg.norm(np.diff(z, axis=0), axis=1)
    return int(np.argmin(detour))
