"""How the cost of a contact step grows with the number of contacts."""

from __future__ import annotations

import math
import time
from functools import cache, partial
from itertools import pairwise

import numpy as np

from slipmode import rom
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import contact_harmonics
from slipmode.rom.laws.friction import limits
from slipmode.runner.report.hard.cases.contacts import many_contacts
from slipmode.runner.report.hard.hard_case import HardCase

_CONTACTS = (1, 2, 10, 30, 100)
_STEPS = 64  # per period
_POINTS = 16  # amplitudes, from sticking to slipping: two groups of lanes
_REPEATS = 3
_ALPHA = 0.02  # [m/s]
# 2 where one contact after the other begins or ceases to slip, and where conjugate gradients take
# as many products however many contacts; a factorisation at every stage would make it 3. In
# between, caches that the matrices of 100 contacts no longer fit.
_BOUND = 2.5


@cache
def cost(contacts: int, alpha: float | None = None) -> float:
    """CPU time of a step of all contacts at one amplitude [s].

    Under tanh friction with `alpha` [m/s]; None: exact Coulomb friction.
    """
    case = many_contacts(contacts)
    law = case.law if alpha is None else rom.Tanh(limits(case.law, contacts).tolist(), alpha)
    reduced = rom.reduce(case.structure, (0,), carrier=case.frequency)
    amplitudes = np.linspace(0.25, 4.0, _POINTS)[:, np.newaxis]
    grid = Discretisation(_STEPS, 1)
    spent = []
    for _ in range(_REPEATS):
        started = time.process_time()
        solved = contact_harmonics(reduced, law, amplitudes, grid, tolerance=1e-4)
        spent.append((time.process_time() - started) / int(solved.marched.sum()))
    return min(spent)


def exponent(few: int, many: int, alpha: float | None = None) -> float:
    """P of cost proportional to N_c^p between two numbers of contacts."""
    return math.log(cost(many, alpha) / cost(few, alpha)) / math.log(many / few)


def growth_cases() -> list[HardCase]:
    """From each number of contacts to the next."""
    return [
        HardCase(
            f"{few} to {many} contacts, {name}",
            "work that grows with the cube of their number",
            "exponent of the cost of a step",
            _BOUND,
            partial(exponent, few, many, alpha),
        )
        for name, alpha in (("Coulomb", None), ("tanh", _ALPHA))
        for few, many in pairwise(_CONTACTS)
    ]
