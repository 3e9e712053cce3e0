"""The modes and harmonics that a friction table may have: the best first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.higher_order_harmonics import (
    change_by_harmonics,
    higher_order_harmonics,
)
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.resolution import trial_grid
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.nonresonant import (
    HIGHEST_HARMONIC,
    RESPONSE_ORDER,
    with_responding,
)
from slipmode.rom.short_repr import frozen


@frozen
class Candidate:
    """A contact problem for a table, and what it neglects; see `Accuracy`.

    Attributes
    ----------
    problem : ContactProblem
    is_simplest : bool
        Whether modes respond to harmonics up to `RESPONSE_ORDER` alone.
    neglected_response, neglected_modes : float
    allowed : float
        Interpolation error as a part of the budget's [-].
    """

    problem: ContactProblem
    is_simplest: bool = True
    neglected_response: float = 0.0
    neglected_modes: float = 0.0
    allowed: float = 1.0


def candidates(
    problem: ContactProblem, amplitude_range: Floats, tolerance: float
) -> Iterator[Candidate]:
    """Yield modes and harmonics for the table of a problem: the best first, which may not settle.

    With one mode, modes respond to all harmonics of a direct steady state. Where the contact
    motion does not converge so, and with two modes, they respond to harmonics up to the 15th,
    with two modes first to weaker ones, too. Where it does not converge so either, weak modes
    and harmonics beyond the fifth are left out. The table states the neglected response.
    """
    reduced, budget, ends = problem.reduced, ErrorBudget(tolerance), amplitude_range
    if reduced.formulation == "paper":
        yield Candidate(problem)
        return
    all_orders = HIGHEST_HARMONIC[1]
    first = (
        (all_orders, all_orders, budget.response)
        if len(reduced.modes) == 1
        else (RESPONSE_ORDER, 15, 0.5 * budget.response)
    )
    strongest: dict[Order, float] | None = None  # of the first attempt; None: not known
    for of_modes, highest, smallest in (first, (RESPONSE_ORDER, 15, budget.response)):
        few, share = with_responding(reduced, budget.modes, of_modes)
        own = replace(problem, reduced=few)
        grid = trial_grid(own, tolerance)
        try:
            higher = higher_order_harmonics(own, grid, ends, smallest, highest)
            strongest = higher if strongest is None else strongest
            # Tables of two modes take half the time without them.
            if higher and len(reduced.modes) == 2:
                change = change_by_harmonics(own, higher, grid, ends, budget.response)
                if change <= budget.harmonics:
                    yield Candidate(own, True, change, share, 1.0 - change / tolerance)
        except UnsettledError:
            continue
        left = [strongest[order] for order in strongest if order not in higher]
        wide = replace(own, orders=(*own.orders, *higher))
        yield Candidate(wide, not higher, max(left, default=0.0), share)
    unknown = np.inf if strongest is None else max(strongest.values(), default=0.0)
    few, share = with_responding(reduced, tolerance, RESPONSE_ORDER)
    yield Candidate(replace(problem, reduced=few), True, unknown, share)
