"""The rate correction over the amplitude plane, beside the friction terms of a table.

It is a hundredth of them, and itself taken to some hundredths: at every third grid line, on a
coarser torus, without the modal response.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.rate_correction import friction_rate_correction
from slipmode.rom.contact.torus import Discretisation
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.table.hermite import Table, surface_values
from slipmode.rom.table.refinement.sampling import amplitude_pairs
from slipmode.rom.table.region import corners, with_neighbours

_COARSER = Discretisation(steps=4, lines=2)
_COARSER_ELASTIC = Discretisation(steps=1, lines=2)  # of steps they have few
_COARSEST = Discretisation(steps=16, lines=8)
_STRIDE = 3  # grid lines from one that is sampled to the next


def with_rate_correction(
    table: Table,
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    grid: Discretisation,
    spread: Callable[[Callable[[Floats], Complexes], Floats], Iterable[Complexes]],
) -> Table:
    """The table with its rate correction.

    Parameters
    ----------
    amplitude_range : (modes,) ndarray
        Amplitudes that are looked at as large ones [kg^1/2 m].
    grid : Discretisation
        Of the table.
    spread : callable
        Values of a function at many points, part by part.
    """
    modes, axes = table.modes, (table.node_a, table.node_b)
    coarser = _COARSER if reduced.contacts is None else _COARSER_ELASTIC
    coarse = Discretisation(
        min(grid.steps, max(grid.steps // coarser.steps, _COARSEST.steps)),
        min(grid.lines, max(grid.lines // coarser.lines, _COARSEST.lines)),
    )
    lines = [
        np.unique(np.append(np.arange(0, node.size, _STRIDE), node.size - 1)) for node in axes
    ]
    wanted = _wanted(table)[np.ix_(*lines)]
    some = [node[chosen] for node, chosen in zip(axes, lines, strict=True)]
    points = amplitude_pairs(some[0], some[1], modes)[wanted.ravel()]
    parts = spread(
        lambda part: friction_rate_correction(reduced, law, part, amplitude_range, coarse), points
    )
    rate_correction = np.zeros((*wanted.shape, modes * modes), dtype=complex)
    rate_correction[wanted] = np.concatenate(list(parts)).reshape(-1, modes * modes)
    for axis in range(2):
        rate_correction = np.apply_along_axis(
            partial(np.interp, axes[axis], some[axis]), axis, rate_correction
        )
    even = [(j != k, j != k) for j in range(modes) for k in range(modes)]
    return replace(table, rate_correction=surface_values(*axes, rate_correction, even))


def _wanted(table: Table) -> Flags:
    """Nodes (n_a, n_b) that what is looked up may depend on."""
    if table.region is None:
        return np.ones((table.node_a.size, table.node_b.size), dtype=bool)
    combinations = corners(table.region)
    for _ in range(_STRIDE):
        combinations = with_neighbours(combinations)
    return combinations
