"""The error of response curves, and folds and Hopf points that are smaller than it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.answer_error import (
    TableError,
    change_along,
    curve_displacement,
    error_at_constant,
)
from slipmode.rom.slow.branches.continuation import Branch, Kind
from slipmode.rom.slow.branches.forced import ForcedSlowFlow


@dataclass(frozen=True, eq=False)
class CurveError:
    """The error of a response curve at its points.

    Attributes
    ----------
    amplitude : (points, modes) ndarray
        Of a_j at constant parameter [kg^1/2 m].
    growth : (points,) ndarray
        Of the growth of small deviations [1/s].
    friction : (points, modes) ndarray
        Of S_j [N kg^-1/2].
    off_carriers : float
        Largest error of a_j due to forcing off the table's carriers, relative to |a_j|, at the
        points where it is measured; infinity where the contact motion does not converge.
    """

    amplitude: Floats
    growth: Floats
    friction: Floats
    off_carriers: float

    __repr__ = short_repr

    @classmethod
    def of(cls, problem: ForcedSlowFlow, z: Floats, branch: NDArray[np.intp]) -> CurveError:
        """Return the error of solutions z (points, k + 1), neighbours of a branch in sequence."""
        linear, y = problem.linearised(z), np.ascontiguousarray(z[:, :-1]).view(complex)
        size = np.multiply.outer(problem.limit_scale(z[:, -1]), problem.scale[::2])

        def error_of(change: Floats) -> Floats:
            """Return the error of y by a change of the scaled rates."""
            aside = curve_displacement(linear, change)
            at_end = np.minimum(curve_displacement(linear[:, :, :-1], change)[0], 1.0)
            return error_at_constant(z[:, -1], y, branch, aside, at_end)

        modulus = np.maximum(np.abs(y), 1e-12)
        stated = problem.table_error(z, None)
        change = np.abs(problem.rate_change(z, stated.size)) / size
        total = problem.table_error(z, (error_of(change) / modulus).max(axis=1))
        rate = np.abs(problem.rate_change(z, total.size)) + problem.neglected_force(z)
        amplitude = size * error_of(rate / size)
        growth = np.nan_to_num(rate / (size * modulus)).max(axis=1)
        off_carriers = _off_carriers(problem, z, linear, branch, total)
        return cls(amplitude, growth, total.size, off_carriers)


def _off_carriers(
    problem: ForcedSlowFlow,
    z: Floats,
    linear: Floats,
    branch: NDArray[np.intp],
    error: TableError,
) -> float:
    at, friction = error.measured, error.off_carriers
    if not at.size:
        return 0.0
    if np.isnan(friction).any():
        return float(np.inf)
    y = np.ascontiguousarray(z[:, :-1]).view(complex)
    size = np.multiply.outer(problem.limit_scale(z[at, -1]), problem.scale[::2])
    change = np.ascontiguousarray(problem.rate_change(z[at], friction) / size).view(float)
    found = 0.0
    for k, each, derivatives in zip(at.tolist(), change, linear[at], strict=True):
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
    problem: ForcedSlowFlow, branch: Branch, friction: Floats, growth_error: Floats
) -> tuple[list[tuple[Kind, Floats]], Flags]:
    """Return folds and Hopf points that are larger than the error; points between the others.

    Two folds in sequence are left out if their distance in the parameter is below its error
    there, two Hopf points if the growth between them is.

    Parameters
    ----------
    problem : ForcedSlowFlow
    branch : Branch
    friction : (points, modes) ndarray
        Error of S_j [N kg^-1/2].
    growth_error : (points,) ndarray
        [1/s]
    """
    points, kept = branch.points, list(range(len(branch.special)))
    between = np.zeros(len(points.rows), dtype=bool)
    if not kept:
        return [], between
    places = [_segment(points.z, z) for _, z in branch.special]
    at = np.array([z for _, z in branch.special])
    error = _parameter_error(problem, at, friction[places])

    def excess(first: int, second: int) -> float:
        (kind, z), (other, z_other) = branch.special[first], branch.special[second]
        if kind != other:
            return np.inf
        if kind == "fold":
            return float(abs(z[-1] - z_other[-1]) / (error[first] + error[second] + 1e-300))
        inside = slice(places[first] + 1, places[second] + 1)
        growth = np.abs(points.eigenvalues[inside, 0].real) / growth_error[inside]
        return float(growth.max(initial=0.0))

    while len(kept) > 1:
        size = [excess(*pair) for pair in pairwise(kept)]
        least = int(np.argmin(size))
        if size[least] > 1.0:
            break
        between[places[kept[least]] + 1 : places[kept[least + 1]] + 1] = True
        del kept[least : least + 2]
    return [branch.special[k] for k in kept], between


def _parameter_error(problem: ForcedSlowFlow, z: Floats, friction: Floats) -> Floats:
    """Return the error of the parameter (points,) at solutions, in parts of the span."""
    size = np.multiply.outer(problem.limit_scale(z[:, -1]), problem.scale[::2])
    change = np.abs(problem.rate_change(z, friction)) / size
    return np.nan_to_num(curve_displacement(problem.linearised(z), change)[1])


def _segment(z: Floats, at: Floats) -> int:
    """Return the point of a curve (points, k + 1) after which a solution lies."""
    distance = np.linalg.norm(z - at, axis=1)
    detour = distance[:-1] + distance[1:] - np.linalg.norm(np.diff(z, axis=0), axis=1)
    return int(np.argmin(detour))
