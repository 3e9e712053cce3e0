"""Newton's method at many points at once, and frequencies at given amplitudes by it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.slow.slow_flow import ForcedFlow

# Steps of finite differences, relative to the unknowns: for forces with rounding errors, and for
# forces of the contact problem, which jump by about 1e-6 where a contact turns between two time
# steps.
_OF_TABLE, _OF_CONTACTS = 1e-7, 1e-4
_STEPS = 50  # most steps; from a good start about 5 suffice
_LARGEST_STEP = 0.5  # of an unknown, so that steps stay in the region of the start
_SHORTEST = 1e-5  # part of a Newton step that still does not reduce the residual: there is no way
LOWEST_SQUARE = 0.01  # of a frequency relative to the natural one; the slow flow ends far above


def solve_points(
    residual: Callable[[Floats], Floats],
    start: Floats,
    difference: float = _OF_TABLE,
) -> tuple[Floats, Flags]:
    """Return solutions (points, k) of residual(z) = 0 near `start`, and whether they converge.

    `residual` returns k real equations for k unknowns at all points, NaN where there are none.
    Unknowns and equations are relative, of about the size 1. Derivatives are by steps of
    `difference`, near the root of the error of the equations. A step that does not reduce the
    residual is repeated at a fourth of its length.
    """
    exact, converged = 10.0 * difference**2, 0.01 * difference
    z, F = start, residual(start)
    part = np.ones(len(z))  # of a Newton step
    sides = np.eye(z.shape[1])
    for _ in range(_STEPS):
        if not ((np.abs(F).max(axis=1) > exact) & (part > _SHORTEST)).any():
            break
        moved = [(residual(z + difference * side) - F) / difference for side in sides]
        slopes = np.stack(moved, axis=-1) + 1e-30 * sides  # without slope a step is long
        step = -part[:, np.newaxis] * np.linalg.solve(slopes, F[..., np.newaxis])[..., 0]
        after = z + np.clip(np.nan_to_num(step), -_LARGEST_STEP, _LARGEST_STEP)
        F_after = residual(after)
        better = np.linalg.norm(F_after, axis=1) < np.linalg.norm(F, axis=1)
        part = np.where(better, 1.0, 0.25 * part)
        z, F = (np.where(better[:, np.newaxis], *each) for each in ((after, z), (F_after, F)))
    return z, np.asarray(np.abs(F).max(axis=1) <= converged)


def flow_at_amplitudes(
    start: ForcedFlow,
    mode: int,
    amplitude: Complexes,
    condition: Callable[[Complexes, Complexes], Floats],
    friction: Callable[[ForcedFlow], Complexes] | None = None,
) -> tuple[ForcedFlow, tuple[Complexes, Complexes], Flags]:
    """Return the flow in which a mode has its frequencies at given amplitudes.

    `start` is the flow without forces at the frequencies from which Newton's method starts. At the
    frequencies of the result the `condition` on the stiffness of the mode and on its friction Q,
    each (points,) [rad^2/s^2], is 0. `amplitude` is (points, modes) [kg^1/2 m]. The other results
    are stiffness and Q, and whether a frequency is found. `friction` returns S (points, modes) of
    a flow at the amplitudes; by default it is the table's.
    """
    natural, frequency = start.model.reduced.frequency[mode], start.frequency.copy()

    def at(square: Floats) -> ForcedFlow:  # in which conditions are almost linear
        frequency[:, mode] = natural * np.sqrt(np.maximum(square[:, 0], LOWEST_SQUARE))
        return start.with_frequency(frequency)

    def terms(square: Floats) -> tuple[Complexes, Complexes]:
        flow = at(square)
        now = flow.balance(amplitude)
        S = now.friction if friction is None else friction(flow)
        return now.stiffness[:, mode], S[:, mode] / amplitude[:, mode]

    def residual(square: Floats) -> Floats:
        return np.asarray(condition(*terms(square))[:, np.newaxis] / natural**2)

    difference = _OF_TABLE if friction is None else _OF_CONTACTS
    square, found = solve_points(residual, (frequency[:, [mode]] / natural) ** 2, difference)
    return at(square), terms(square), found
