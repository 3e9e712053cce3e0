"""The error of response curves, and folds and Hopf points that are smaller than it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import (
    TableError,
    change_along,
    curve_displacement,
    error_at_constant,
)
from slipmode.rom.slow.branches.continuation import Branch, Kind
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.slow_flow import ForcedFlow

_DIFFERENCE = 1e-6  # of the span, for derivatives: far above rounding


@frozen
class CurveError:
    """The error of a response curve at its points."""

    amplitude: Floats  # (points, modes), of a_j at constant parameter [kg^1/2 m]
    growth: Floats  # (points,), of the growth of small deviations [1/s]
    friction: Floats  # (points, modes), of S_j [N kg^-1/2]
    # Largest error of a_j due to forcing off the table's carriers, relative to |a_j|, at the
    # points where it is measured; infinity where the contact motion does not converge
    off_carriers: float

    @classmethod
    def of(cls, problem: ForcedSlowFlow, z: Floats, branch: NDArray[np.intp]) -> CurveError:
        """Return the error of solutions z (points, k + 1), neighbours of a branch in sequence."""
        points = _Solutions(problem, z)
        y, size = points.y, points.size

        def error_of(change: Floats) -> Floats:
            """Return the error of y by a change of the scaled rates."""
            displacement = curve_displacement(points.linear, change)
            at_constant = curve_displacement(points.linear[:, :, :-1], change)[0]
            return error_at_constant(z[:, -1], y, branch, displacement, np.minimum(at_constant, 1))

        modulus = np.maximum(np.abs(y), 1e-12)
        stated = points.table_error(None)
        sensitive = error_of(np.abs(points.rate_change(stated.size)))
        total = points.table_error((sensitive / modulus).max(axis=1))
        rate = np.abs(points.rate_change(total.size)) + points.neglected_force
        growth = np.nan_to_num(rate / modulus).max(axis=1)
        off_carriers = _off_carriers(points, branch, total)
        return cls(size * error_of(rate), growth, total.size, off_carriers)


@dataclass(frozen=True, eq=False)
class _Solutions:
    """Solutions z (points, k + 1) of a forced slow flow, and its derivatives there."""

    problem: ForcedSlowFlow
    z: Floats

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
    def _effective(self) -> Complexes:
        """Amplitudes at which the friction table is looked up, (points, modes)."""
        return self.flow.effective(self.problem.amplitude(self.z))

    def table_error(self, weight: Floats | None) -> TableError:
        """Return the error of S_j, see `TableError.of`."""
        limit_scale = self.flow.inputs["limit_scale"]
        effective = np.abs(self._effective) / limit_scale[:, np.newaxis]
        flow = self.flow
        return TableError.of(flow.model, effective, flow.frequency, limit_scale, weight)

    def rate_change(self, friction: Complexes | Floats) -> Complexes:
        """Return the change of the scaled rates (points, modes) by a change of S_j."""
        factor = coupling_factor(self.flow.model.reduced, self.flow.frequency)
        turned = np.exp(1j * np.angle(self._effective))
        return np.asarray(factor * turned * friction / self._mass)

    @property
    def neglected_force(self) -> Floats:
        """Scaled rates (points, modes) by the neglected force through dampers."""
        force = self.flow.force * self.problem.applied.through_dampers
        return np.asarray(np.abs(0.5 * force / self._mass))


def _off_carriers(points: _Solutions, branch: NDArray[np.intp], error: TableError) -> float:
    at, friction = error.measured, error.off_carriers
    if not at.size:
        return 0.0
    if np.isnan(friction).any():
        return float(np.inf)
    z, y = points.z, points.y
    change = _Solutions(points.problem, z[at]).rate_change(friction)
    found = 0.0
    for k, each in zip(at.tolist(), np.ascontiguousarray(change).view(float), strict=True):
        derivatives = points.linear[k]
        if not np.isfinite(derivatives).all() or not np.abs(y[k]).all():
            continue
        moved = np.linalg.pinv(derivatives) @ each
        width = np.zeros(len(z))
        width[k] = abs(moved[-1])
        near = np.abs(moved[:-1].view(complex)) + change_along(z[:, -1], y, branch, width)[k]
        at_constant = np.abs((np.linalg.pinv(derivatives[:, :-1]) @ each).view(complex))
        found = max(found, float((np.minimum(near, at_constant) / np.abs(y[k])).max()))
    return found


def significant_specials(
    problem: ForcedSlowFlow, branches: list[Branch], error: CurveError
) -> tuple[list[tuple[Kind, Floats]], Flags]:
    """Return folds and Hopf points that are larger than the error; points between the others.

    Two folds or Hopf points in sequence are left out if their distance in the parameter is below
    its error there; Hopf points also if the growth between them is below its own.
    """
    ends = np.cumsum([len(branch.points.rows) for branch in branches])[:-1]
    frictions, growths = np.split(error.friction, ends), np.split(error.growth, ends)
    found: list[tuple[Kind, Floats]] = []
    between = []
    for branch, friction, growth in zip(branches, frictions, growths, strict=True):
        kept, small = _significant(problem, branch, friction, growth)
        found += kept
        between.append(small)
    return found, np.concatenate(between)


def _significant(
    problem: ForcedSlowFlow, branch: Branch, friction: Floats, growth_error: Floats
) -> tuple[list[tuple[Kind, Floats]], Flags]:
    points, kept = branch.points, list(range(len(branch.special)))
    between = np.zeros(len(points.rows), dtype=bool)
    if not kept:
        return [], between
    places = [_segment(points.z, z) for _, z in branch.special]
    at = _Solutions(problem, np.array([z for _, z in branch.special]))
    change = np.abs(at.rate_change(friction[places]))
    error = np.nan_to_num(curve_displacement(at.linear, change)[1])  # of the parameter

    def excess(first: int, second: int) -> float:
        (kind, z), (other, z_other) = branch.special[first], branch.special[second]
        if kind != other:
            return np.inf
        apart = float(abs(z[-1] - z_other[-1]) / (error[first] + error[second] + 1e-300))
        if kind == "fold":
            return apart
        inside = slice(places[first] + 1, places[second] + 1)
        growth = np.abs(points.eigenvalues[inside, 0].real) / growth_error[inside]
        return min(apart, float(growth.max(initial=0.0)))

    while len(kept) > 1:
        size = [excess(*pair) for pair in pairwise(kept)]
        least = int(np.argmin(size))
        if size[least] > 1.0:
            break
        between[places[kept[least]] + 1 : places[kept[least + 1]] + 1] = True
        del kept[least : least + 2]
    return [branch.special[k] for k in kept], between


def _segment(z: Floats, at: Floats) -> int:
    """Return the point of a curve (points, k + 1) after which a solution lies."""
    distance = np.linalg.norm(z - at, axis=1)
    detour = distance[:-1] + distance[1:] - np.linalg.norm(np.diff(z, axis=0), axis=1)
    return int(np.argmin(detour))
