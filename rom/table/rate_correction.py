"""How far friction lags behind that of steady motion while amplitudes grow.

A contact that sticks holds what the last reversal left, and that was as large as the amplitude
was then. To first order in the growth, S_j = S_j(|a|) + sum_k lag_jk(|a|) d|a_k|/dt; where
contacts slip all the time nothing lags. It is a hundredth of S_j in a fast transient, and is
itself taken to some hundredths: at every third grid line, on a coarser torus, without the modes'
answer.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from slipmode.rom import _kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.laws import Friction
from slipmode.rom.contact.torus import Discretisation, contact_problem
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.table.hermite import Table, surface_values
from slipmode.rom.table.refinement import amplitude_pairs
from slipmode.rom.table.region import corners, with_neighbours

_GROWTH = 0.02  # of an amplitude in a period of mode A: small against it, large against rounding
_LEAST_GROWTH = 0.002  # of the largest amplitude
_COARSER = Discretisation(steps=4, lines=2)
_COARSEST = Discretisation(steps=16, lines=8)
_STRIDE = 3  # grid lines from one that is sampled to the next


def friction_lag(
    reduced: Reduced, law: Friction, amplitudes: Floats, limit: Floats, grid: Discretisation
) -> Complexes:
    """dS_j / d(d|a_k|/dt) [N kg^-1 s/m], (points, modes, modes) by j and k.

    Parameters
    ----------
    amplitudes : (points, modes) ndarray
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    limit : (modes,) ndarray
        Of the table: the scale of the growth where an amplitude is small.
    grid : Discretisation
    """
    modes = limit.size
    growth = np.maximum(_GROWTH * amplitudes, _LEAST_GROWTH * limit)
    lag = np.empty((len(amplitudes), modes, modes), dtype=complex)
    for k in range(modes):
        along = np.where(np.arange(modes) == k, growth, 0.0)
        S_up, S_down = (
            _growing(reduced, law, amplitudes, sign * along, grid) for sign in (1.0, -1.0)
        )
        lag[:, :, k] = (S_up - S_down) / (2.0 * growth[:, k : k + 1])
    lag *= 2.0 * np.pi / reduced.carrier[0]
    # of one mode by the growth of the other: odd in both amplitudes
    of_other = ~np.eye(modes, dtype=bool)
    lag[(amplitudes == 0.0).any(axis=1)[:, np.newaxis, np.newaxis] & of_other] = 0.0
    return lag


def _growing(
    reduced: Reduced, law: Friction, amplitudes: Floats, growth: Floats, grid: Discretisation
) -> Complexes:
    """S_j (points, modes) as amplitudes pass by, growing by `growth` in a period of mode A."""
    problem = contact_problem(reduced, law)
    problem.answer = None
    rates = _kernel.contiguous(reduced.carrier)
    orders = np.ascontiguousarray(CARRIERS[: rates.size], dtype=np.int32)
    points, growth = _kernel.contiguous(amplitudes), _kernel.contiguous(growth)
    P = np.empty((len(points), rates.size, reduced.n_contacts), dtype=complex)
    status = _kernel.lib.sm_torus_growing(
        *(ctypes.byref(problem), rates.ctypes.data, grid.steps, grid.lines),
        *(len(points), points.ctypes.data, growth.ctypes.data),
        *(len(orders), orders.ctypes.data, P.ctypes.data),
    )
    _kernel.check(status, "contact problem of growing amplitudes")
    return np.asarray(-np.einsum("jc,pjc->pj", reduced.coupling, P))


def with_lag(
    table: Table,
    reduced: Reduced,
    law: Friction,
    grid: Discretisation,
    spread: Callable[[Callable[[Floats], Complexes], Floats], Iterable[Complexes]],
) -> Table:
    """The table with its lag.

    Parameters
    ----------
    grid : Discretisation
        Of the table.
    spread : callable
        Values of a function at many points, part by part.
    """
    modes, limit, axes = table.modes, table.limit, (table.node_a, table.node_b)
    coarse = Discretisation(
        min(grid.steps, max(grid.steps // _COARSER.steps, _COARSEST.steps)),
        min(grid.lines, max(grid.lines // _COARSER.lines, _COARSEST.lines)),
    )
    lines = [
        np.unique(np.append(np.arange(0, node.size, _STRIDE), node.size - 1)) for node in axes
    ]
    wanted = _wanted(table)[np.ix_(*lines)]
    some = [node[chosen] for node, chosen in zip(axes, lines, strict=True)]
    points = amplitude_pairs(some[0], some[1], modes)[wanted.ravel()]
    parts = spread(lambda part: friction_lag(reduced, law, part, limit, coarse), points)
    lag = np.zeros((*wanted.shape, modes * modes), dtype=complex)
    lag[wanted] = np.concatenate(list(parts)).reshape(-1, modes * modes)
    for axis in range(2):
        lag = np.apply_along_axis(partial(np.interp, axes[axis], some[axis]), axis, lag)
    even = [(j != k, j != k) for j in range(modes) for k in range(modes)]
    return replace(table, lag=surface_values(*axes, lag, even))


def _wanted(table: Table) -> Flags:
    """Nodes (n_a, n_b) that what is looked up may depend on."""
    if table.visited is None:
        return np.ones((table.node_a.size, table.node_b.size), dtype=bool)
    near = corners(table.visited)
    for _ in range(_STRIDE):
        near = with_neighbours(near)
    return near
