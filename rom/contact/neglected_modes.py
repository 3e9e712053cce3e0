"""Which modes a friction table needs, and the error due to the modes that it neglects."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.error_norm import ErrorNorm, smallest_scale
from slipmode.rom.contact.friction_terms import contact_terms
from slipmode.rom.contact.settled import UNSETTLED
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.nonresonant import with_responding
from slipmode.rom.reduction.reduced import Reduced

_PROBES = np.array([[1.0, 1.0], [1.0, 0.3], [0.3, 1.0]])  # of the largest amplitudes


def responding_modes(
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    grid: Discretisation,
    combinations: Sequence[CombinationResonance],
    budget: ErrorBudget,
) -> tuple[Reduced, float]:
    """Return reduced matrices with the modes that a table needs, and the error by the others.

    The error is measured against all modes of `reduced` where the contacts move most, in terms of
    `ErrorNorm`. It is infinite where the contact motion does not converge with all modes.
    """
    if reduced.formulation == "paper" or not reduced.nonresonant_frequency.size:
        return reduced, 0.0
    smallest = budget.response
    few = with_responding(reduced, smallest)
    if few is reduced:
        return reduced, 0.0
    points = _PROBES[:, : amplitude_range.size] * amplitude_range
    solve = partial(
        contact_terms,
        law=law,
        amplitudes=points,
        grid=grid,
        tolerance=0.1 * budget.modes,
        smallest_scale=smallest_scale(amplitude_range),
        combinations=combinations,
    )
    every = solve(reduced)
    if every.residual.max() > UNSETTLED:
        return few, np.inf
    norm = ErrorNorm.of(reduced, amplitude_range).known(every.S)
    while few is not reduced:
        apart = np.abs(solve(few).S - every.S) / norm.scale(points, every.S)
        if apart.max() <= budget.modes:
            return few, float(apart.max())
        smallest *= 0.1
        few = with_responding(reduced, smallest)
    return reduced, 0.0
