"""Slow limit cycles: what amplitudes do where a steady state lets oscillations grow.

Beyond a Hopf point amplitudes settle on a closed orbit around the steady state, slowly against the
forcing. It is integrated in slow time from beside the steady states, all at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.continuation import Points
from slipmode.rom.slow.branches.forced import ForcedSlowFlow

_MOST = 32  # steady states that are started from
_ASIDE = 1e-3  # of the table's range: how far from the steady state
_STEP = 0.1  # of a Runge-Kutta step, times the largest eigenvalue
_STRETCH = 400  # steps, whose extremes are compared with those of the stretch before
_MOST_STRETCHES = 40
_SAME = 2e-3  # of the table's range: by which these may differ


@dataclass(frozen=True, eq=False)
class SlowCycles:
    """Extremes of amplitudes that oscillate in slow time; those that do not settle are left out.

    Attributes
    ----------
    parameter : (n,) ndarray
        As in ResponseCurve, ascending.
    lowest, highest : (n, modes) ndarray
        Of |a_j| [kg^1/2 m].
    """

    parameter: Floats
    lowest: Floats
    highest: Floats

    __repr__ = short_repr


def slow_cycles(problem: ForcedSlowFlow, points: Points) -> SlowCycles:
    """Around steady states from which oscillations grow."""
    values = points.eigenvalues
    (growing,) = np.nonzero(((values.real > 0.0) & (values.imag != 0.0)).any(axis=1))
    if not growing.size:
        return SlowCycles(np.zeros(0), *np.zeros((2, 0, problem.model.modes)))
    chosen = np.unique(np.linspace(0, growing.size - 1, _MOST).round().astype(int))
    starts = points.z[growing[chosen]]
    part, y = starts[:, -1], starts[:, :-1].copy()
    y[:, 0] += _ASIDE
    h = _STEP / np.abs(values[growing[chosen]]).max(axis=1)
    settled = np.zeros(len(starts), dtype=bool)
    before = np.full((2, len(starts), problem.model.modes), np.nan)
    extremes = before.copy()
    for _ in range(_MOST_STRETCHES):
        at = np.flatnonzero(~settled & np.isfinite(y).all(axis=1))
        if not at.size:
            break
        y[at], extremes[:, at] = _stretch(problem, y[at], part[at], h[at])
        size = extremes / problem.scale[::2]
        change = np.abs(size - before).max(axis=(0, 2))
        moving = (size[1] - size[0]).max(axis=1) > 2.0 * _ASIDE
        settled |= moving & (change <= _SAME)
        before = size
    factor = problem.limit_scale(part)[:, np.newaxis]
    order = np.flatnonzero(settled)[np.argsort(part[settled])]
    low, high = (factor * extremes)[:, order]
    return SlowCycles(problem.parameter(part[order]), low, high)


def _stretch(problem: ForcedSlowFlow, y: Floats, part: Floats, h: Floats) -> tuple[Floats, Floats]:
    """Where it ends, and the extremes of |a_j| on the way (2, points, modes)."""
    step = h[:, np.newaxis]
    low, high = np.full((len(y), problem.model.modes), np.inf), np.zeros(problem.model.modes)
    rates = problem.held_at(part)
    for _ in range(_STRETCH):
        k1 = rates(y)
        k2 = rates(y + 0.5 * step * k1)
        k3 = rates(y + 0.5 * step * k2)
        k4 = rates(y + step * k3)
        y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        size = np.abs(np.ascontiguousarray(y * problem.scale).view(complex))
        low, high = np.minimum(low, size), np.maximum(high, size)
    return y, np.array([low, high])
