"""How fast motion is had, marched or summed: decided by what a sum of harmonics leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.harmonics import left_out, mean_square
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.short_repr import short_repr
from slipmode.runner.plan.amplitude_range import Excited

ORDERS = (RESPONSE_ORDER, RESPONSE_ORDER + 2, RESPONSE_ORDER + 4)
_GRID = Discretisation(128, 16)
_PARTS = (1.0, 0.5)  # of the largest amplitudes


@dataclass(frozen=True, eq=False)
class Truncation:
    """What sums of harmonics leave out, measured at the amplitudes of a scene.

    Attributes
    ----------
    contact : (orders,) ndarray
        Of what the contact problem has as unknown, the displacement or, of elastic contacts, the
        lack of force, at worst, relative to its RMS, for sums up to each of ORDERS.
    elastic : (orders,) ndarray
        Of the wanted DOFs' displacement likewise; 0 without such DOFs.
    """

    contact: Floats
    elastic: Floats

    __repr__ = short_repr

    def order_within(self, tolerance: float) -> int | None:
        """Lowest order that leaves out no more of the elastic motion; None: too many needed."""
        enough = np.flatnonzero(self.elastic <= tolerance)
        return ORDERS[enough[0]] if enough.size else None


def measure_truncation(
    excited: Excited,
    amplitude: Sequence[float],
    combinations: Sequence[CombinationResonance],
    dofs: Sequence[int],
) -> Truncation:
    """Solve the contact problem at and below the largest amplitudes (modes,)."""
    reduced, rows = excited.reduced, list(dofs)
    modes = len(excited.modes)
    grid = _GRID if modes == 2 else Discretisation(_GRID.steps, 1)
    points = np.array(np.meshgrid(*(np.multiply(_PARTS, a) for a in amplitude)))
    points = points.reshape(modes, -1).T
    problem = ContactProblem.of(reduced, excited.law, combinations, ORDERS[-1])
    terms = problem.on(grid, 1e-3).solve(points)
    whole = terms.left_out**2 + mean_square(terms.orders, terms.P)
    shapes = reduced.mode_shapes[rows], reduced.contact_shapes[rows]
    motion = np.sqrt(2.0 * points**2 @ shapes[0].T ** 2 + whole @ shapes[1].T ** 2)
    contact, elastic = [], []
    for order in ORDERS:
        kept = [q for q, (n, m) in enumerate(terms.orders) if abs(n) + abs(m) <= order]
        beyond = left_out([terms.orders[q] for q in kept], terms.P[:, kept], whole)
        moved = beyond @ np.abs(shapes[1]).T
        contact.append(_largest_part(beyond, np.sqrt(whole)))
        elastic.append(_largest_part(moved, motion))
    return Truncation(np.array(contact), np.array(elastic))


def _largest_part(part: Floats, whole: Floats) -> float:
    ratio = np.divide(part, whole, out=np.zeros_like(part), where=whole > 0)
    return float(ratio.max(initial=0.0))
