"""Slow limit cycles: closed orbits of the amplitudes around unstable steady states.

Beyond a Hopf point amplitudes tend to a closed orbit around the steady state, which is slow
against the forcing. All orbits are integrated at once, from points near the steady states.
"""

from __future__ import annotations

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.continuation import Points
from slipmode.rom.slow.branches.forced import ForcedSlowFlow
from slipmode.rom.slow.slow_flow import rates

_RELATIVE, _ABSOLUTE = 1e-6, 1e-8  # tolerances of integration; absolute: of the table's range
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
    # Units of time: the largest eigenvalue turns an orbit by 0.1 in each
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
    """Return the end of 400 units `h` of time, and the extremes of |a_j| (2, points, modes).

    Orbits that leave the friction table stop at its edge, and are NaN.
    """
    flow, size, unit = problem.at(part), problem.size(part), h[:, np.newaxis]

    def slope(_: float, z: Floats) -> Floats:  # with a''; NaN outside the friction table
        a = np.ascontiguousarray(z.reshape(y.shape) * size).view(complex)
        # Combination resonances turn meanwhile: with these, rates do not include a''.
        if problem.model.combinations:
            moving = flow.balance(a).rate
        else:
            moving = rates(flow.flow, flow.inputs, a, may_leave=True)
        return np.ravel(unit * np.ascontiguousarray(moving).view(float) / size)

    def scaled(time: float, z: Floats) -> Floats:
        return np.nan_to_num(slope(time, z))

    times = np.arange(401.0)
    path = scipy.integrate.solve_ivp(
        scaled, (0.0, 400.0), y.ravel(), t_eval=times, rtol=_RELATIVE, atol=_ABSOLUTE
    )
    states = np.ascontiguousarray(path.y.T).reshape(-1, *y.shape)
    states += 0.0 * slope(400.0, path.y[:, -1]).reshape(y.shape)
    modulus = np.abs((states * problem.scale).view(complex))
    return states[-1], np.array([modulus.min(axis=0), modulus.max(axis=0)])
