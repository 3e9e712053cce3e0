"""Corrections of the friction terms in a table: for rates of amplitudes, and for frequencies.

Both are hundredths of them, and are computed to some hundredths: with two modes at every third or
fourth grid line; the rate correction on a coarser torus and without the modal response.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import Detuned
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.contact.problem import TorusProblem
from slipmode.rom.contact.rate_correction import friction_rate_correction
from slipmode.rom.contact.resolution import Mapped
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.reduction.combination import CARRIERS, Order
from slipmode.rom.reduction.force_response import AppliedForces, steady_force
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.table.hermite import Table, surface_values
from slipmode.rom.table.refinement.sampling import amplitude_pairs, in_tasks

# Grid lines from one that is sampled to the next, at least, and how many at the most, by modes:
# what is corrected is small. Nodes of one mode are cheap.
_STRIDE, _DETUNING_STRIDE, _LINES = {1: 1, 2: 3}, {1: 1, 2: 4}, {1: 100, 2: 20}
# Of tables of two modes to `_COARSE` or more, the rate correction has half as many. Runs from rest
# differ by 0.12 % from those with the rate correction at each node
# (test_a_coarse_table_has_the_rate_correction_of_runs_from_rest), and take a fifth less time.
_COARSE = 5e-3
# Fractions of the largest amplitudes where forcing off the carriers is tried.
_PROBES = np.array([[1.0, 1.0], [1.0, 0.3], [0.3, 1.0], [0.5, 0.5]])
# Largest step of the central difference, relative to a carrier. Within it the difference over the
# whole range of the forcing has the least error (tests/evidence/test_stated_errors.py).
_DIFFERENCE = 0.02


def with_rate_correction(
    table: Table, torus: TorusProblem, tolerance: float, mapped: Mapped
) -> Table:
    """Return the table with its rate correction.

    Parameters
    ----------
    torus : TorusProblem
        Contact problem of the table.
    tolerance : float
        Tolerance of the table.
    mapped : callable
        Applies a function to parts of many points: as `map`.
    """
    reduced, law, grid = torus.problem.reduced, torus.problem.law, torus.grid
    steps = grid.steps
    if reduced.contacts is None:  # elastic contacts have few steps
        steps = min(steps, max(steps // 4, 16))
    coarse = Discretisation(steps, min(grid.lines, max(grid.lines // 2, 8)))
    most = _LINES[table.modes]
    if table.modes == 2 and tolerance >= _COARSE:
        most //= 2
    surface = _surface(
        table,
        _STRIDE[table.modes],
        most,
        lambda part: friction_rate_correction(reduced, law, part, table.amplitude_range, coarse),
        [(j != k, j != k) for j in range(table.modes) for k in range(table.modes)],
        mapped,
    )
    return replace(table, rate_correction=surface)


def with_detuning(
    table: Table, torus: TorusProblem, mapped: Mapped, tolerance: float | None, distance: float
) -> tuple[Table, float]:
    """Return the table with dS_j / dOmega_k, where that helps, and the error off the carriers.

    The error concerns S_j, at `distance` from the carriers, in terms of `ErrorNorm`.

    Parameters
    ----------
    torus : TorusProblem
        Contact problem of the table.
    mapped : callable
        Applies a function to parts of many points: as `map`.
    tolerance : float or None
        Error that needs no slope; None: no slope, whatever the error.
    distance : float
        Largest relative distance of the forcing frequencies from the carriers.
    """
    reduced = torus.problem.reduced
    points, guess = _probe_points(table), None
    at_carriers = table(points)
    norm = ErrorNorm.of(reduced, table.amplitude_range).known(table.nodes())
    if reduced.contacts is not None:
        at_carriers, guess = Detuned.of(torus, np.zeros(table.modes)).friction(points)
    detunings = distance * np.array(list(product((1.0, -1.0), repeat=table.modes)))
    if reduced.ratio:  # the carriers move together
        detunings = detunings[[0, -1]]
    moved = [Detuned.of(torus, detuning) for detuning in detunings]
    changes = [
        each.friction(points, guess)[0]
        - at_carriers
        + change_by_shift(table, reduced, each.reduced, points)
        for each in moved
    ]
    scale = norm.scale(points, at_carriers)

    def error_with(slope: Complexes | None) -> float:
        """Largest error at the points; all of S_j where the motion is not periodic."""
        rest = np.array(changes)
        if slope is not None:
            rest -= np.einsum("pjk,ck->cpj", slope, detunings * reduced.carrier)
        return float(np.nan_to_num(np.abs(rest) / scale, nan=1.0).max())

    error = error_with(None)
    if tolerance is None or error <= tolerance:
        return table, error
    if error_with(_DetuningSlope(table, torus, distance)(points)) > 0.5 * error:
        return table, error  # it would not help
    # Slopes are small corrections: marches may repeat ten times less closely.
    rough = torus.problem.on(torus.grid, 10.0 * torus.tolerance, torus.smallest_amplitude)
    surface = _surface(
        table,
        _DETUNING_STRIDE[table.modes],
        _LINES[table.modes],
        _DetuningSlope(table, rough, distance),
        [order for order in CARRIERS[: table.modes] for _ in range(table.modes)],
        mapped,
    )
    detuned = replace(table, detuning=surface)
    return detuned, error_with(detuned.detuning_at(points))


def change_by_shift(
    table: Table, at_carriers: Reduced, moved: Reduced, amplitudes: Floats
) -> Complexes:
    """Return the change of S_j by a force that acts past its mode, if it is off the carriers.

    The shift of the effective amplitude c_j by a force depends on its frequency, because the
    response of the other modes does; the slow flow has the shift at the carriers. The force is the
    one that holds c_j steady, see `steady_force`.

    Parameters
    ----------
    at_carriers, moved : Reduced
        Matrices at the carriers of the table and at the forcing frequencies.
    amplitudes : (points, modes) ndarray
        |c_j| [kg^1/2 m].

    Returns
    -------
    (points, modes) complex ndarray
        Change of S_j [N kg^-1/2]; 0 without `Reduced.force_patterns`.
    """
    if at_carriers.force_patterns is None:
        return np.zeros(amplitudes.shape, dtype=complex)
    shift, new = (AppliedForces(r, at_carriers.force_patterns).shift for r in (at_carriers, moved))
    D, S = steady_force(moved)[1], table(amplitudes)
    force = 2.0 * (D * amplitudes - S) / (1.0 + 2.0 * new * D)
    acting = amplitudes + (new - shift) * force
    size = np.abs(acting)
    turn = np.divide(acting, size, out=np.ones_like(acting), where=size > 0.0)
    # beyond the table S_j continues as it is about its end
    beyond = size > table.amplitude_range
    inside = np.clip(np.where(beyond, 2.0 * amplitudes - size, size), 0.0, table.amplitude_range)
    there = table(inside)
    return np.asarray(np.where(beyond, 2.0 * S - there, there) * turn - S)


class _DetuningSlope:
    """dS_j / dOmega_k of a table by central differences, at any amplitudes.

    `distance` is the largest relative distance of the forcing frequencies from the carriers.
    """

    def __init__(self, table: Table, torus: TorusProblem, distance: float) -> None:
        self._table, self._reduced = table, torus.problem.reduced
        steps = min(distance, _DIFFERENCE) * np.eye(table.modes)
        # from one of a pair to the other [rad/s]
        self._step = 2.0 * min(distance, _DIFFERENCE) * self._reduced.carrier
        self._pairs = [(Detuned.of(torus, each), Detuned.of(torus, -each)) for each in steps]

    def __call__(self, amplitudes: Floats) -> Complexes:
        """Return dS_j / dOmega_k [N kg^-1/2 s], (points, modes, modes) by j and k."""
        slope = np.empty((*amplitudes.shape, len(self._pairs)), dtype=complex)
        for k, pair in enumerate(self._pairs):
            above, below = (each.friction(amplitudes)[0] for each in pair)
            # 0 where the motion of the contacts is not periodic
            slope[..., k] = np.nan_to_num((above - below) / self._step[k], nan=0.0)
            above, below = (
                change_by_shift(self._table, self._reduced, each.reduced, amplitudes)
                for each in pair
            )
            slope[..., k] += (above - below) / self._step[k]
        return slope


def _probe_points(table: Table) -> Floats:
    """Return nodes that show what detuning does, (points, modes)."""
    nearest = [
        node[np.abs(node - np.outer(part, node[-1])).argmin(axis=1)]
        for node, part in zip(table.axes, _PROBES.T, strict=False)
    ]
    return np.unique(np.transpose(nearest), axis=0)


def _surface(
    table: Table,
    stride: int,
    most: int,
    sample: Callable[[Floats], Complexes],
    orders: Sequence[Order],
    mapped: Mapped,
) -> Floats:
    """Surface (n_a, n_b, 4, 2 modes^2) over the table through samples (points, modes, modes).

    Samples are at every `stride` nodes of each mode, or at fewer: at as many as `most`, about.
    They are interpolated linearly between these.
    Slopes are monotone: splines oscillate across kinks, which changes the stability of states.
    """
    modes, axes = table.modes, (table.node_a, table.node_b)
    some = []
    for node in axes:
        every = max(stride, node.size // most)
        some.append(np.append(node[:-1:every], node[-1]))
    points = amplitude_pairs(some[0], some[1], modes).reshape(-1, modes)
    parts = list(in_tasks(mapped, sample, points))
    samples = np.concatenate(parts).reshape(some[0].size, some[1].size, modes * modes)
    for axis in range(modes):
        samples = np.apply_along_axis(partial(np.interp, axes[axis], some[axis]), axis, samples)
    return surface_values(*axes, samples, orders, monotone=True)
