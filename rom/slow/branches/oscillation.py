"""Slow limit cycles: closed orbits of the amplitudes around unstable steady states.

Beyond a Hopf point amplitudes tend to a closed orbit around the steady state, which is slow
against the forcing. All orbits are integrated at once, from points near the steady states.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.continuation import Points
from slipmode.rom.slow.branches.forced import ForcedSlowFlow

_DISTANCE = 1e-3  # of the start from the steady state, relative to the table's range


@frozen
class SlowCycles:
    """Extremes of amplitudes that oscillate in slow time on closed orbits."""

    parameter: Floats  # (n,), as in ResponseCurve, ascending
    lowest: Floats  # (n, modes), of |a_j| [kg^1/2 m]
    highest: Floats  # (n, modes), of |a_j| [kg^1/2 m]


def slow_cycles(problem: ForcedSlowFlow, points: Points) -> SlowCycles:
    """Return the orbits around steady states with growing oscillations."""
    values = points.eigenvalues
    (growing,) = np.nonzero(((values.real > 0.0) & (values.imag != 0.0)).any(axis=1))
    if not growing.size:
        return SlowCycles(np.zeros(0), *np.zeros((2, 0, problem.model.modes)))
    chosen = np.unique(np.linspace(0, growing.size - 1, 32).round().astype(int))
    starts = points.z[growing[chosen]]
    part, y = starts[:, -1], starts[:, :-1].copy()
    y[:, 0] += _DISTANCE
    # Runge-Kutta steps relative to 1 / the largest eigenvalue
    h = 0.1 / np.abs(values[growing[chosen]]).max(axis=1)
    is_closed = np.zeros(len(starts), dtype=bool)
    before = np.full((2, len(starts), problem.model.modes), np.nan)
    extremes = before.copy()
    for _ in range(40):
        at = np.flatnonzero(~is_closed & np.isfinite(y).all(axis=1))
        if not at.size:
            break
        y[at], extremes[:, at] = _stretch(problem, y[at], part[at], h[at])
        size = extremes / problem.scale[::2]
        change = np.abs(size - before).max(axis=(0, 2))
        moving = (size[1] - size[0]).max(axis=1) > 2.0 * _DISTANCE
        is_closed |= moving & (change <= 2e-3)
        before = size
    factor = problem.at(part).inputs["limit_scale"][:, np.newaxis]
    order = np.flatnonzero(is_closed)[np.argsort(part[is_closed])]
    low, high = (factor * extremes)[:, order]
    return SlowCycles(problem.parameter(part[order]), low, high)


def _stretch(problem: ForcedSlowFlow, y: Floats, part: Floats, h: Floats) -> tuple[Floats, Floats]:
    """Return the end of 400 steps, and the extremes of |a_j| in it (2, points, modes)."""
    step = h[:, np.newaxis]
    low, high = np.full((len(y), problem.model.modes), np.inf), np.zeros(problem.model.modes)
    rates = problem.held_at(part)
    for _ in range(400):
        k1 = rates(y)
        k2 = rates(y + 0.5 * step * k1)
        k3 = rates(y + 0.5 * step * k2)
        k4 = rates(y + step * k3)
        y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        size = np.abs(np.ascontiguousarray(y * problem.scale).view(complex))
        low, high = np.minimum(low, size), np.maximum(high, size)
    return y, np.array([low, high])
