"""Fast motion in windows, marched or as a sum of harmonics: decided by the error of the sum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.harmonics import left_out, mean_square
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.short_repr import frozen
from slipmode.rom.validity import Finding
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.sections import Scene, Window

ORDERS = (RESPONSE_ORDER, RESPONSE_ORDER + 2, RESPONSE_ORDER + 4)


@frozen
class Truncation:
    """Errors of sums of harmonics at the amplitudes of a scene."""

    # (orders,): RMS of the neglected part of the contacts' displacement, or of elastic contacts'
    # force deficit, relative to its RMS, for sums up to each of ORDERS
    contact: Floats
    # (orders,): The relative RMS of the neglected part of the displacement of output DOFs; 0
    # without any
    elastic: Floats

    def order_within(self, tolerance: float) -> int | None:
        """Return the lowest order with an elastic error of at most `tolerance`, or None."""
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
    grid = Discretisation(128, 16 if modes == 2 else 1)  # coarse: the error needs one digit
    points = np.array(np.meshgrid(*((a, 0.5 * a) for a in amplitude)))
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
        contact.append(_largest_ratio(beyond, np.sqrt(whole)))
        elastic.append(_largest_ratio(moved, motion))
    return Truncation(np.array(contact), np.array(elastic))


def _largest_ratio(part: Floats, whole: Floats) -> float:
    ratio = np.divide(part, whole, out=np.zeros_like(part), where=whole > 0)
    return float(ratio.max(initial=0.0))


def plan_fast_motion(
    scene: Scene, excited: Excited, truncation: Truncation | None
) -> tuple[int | None, list[Finding]]:
    """Return the order of the harmonics summed in elastic windows, if any, and the decisions.

    `truncation` is None if no window needs it: there is none, or all of the scene is integrated.
    """
    if not scene.windows:
        return None, [Finding("fast motion", "none", "no [[contact]] or [[elastic]] window")]
    order, contact, elastic = None, ("integrated", ""), ("integrated", "")
    if truncation is not None:
        tolerance = scene.model.tolerance
        order = truncation.order_within(tolerance) if scene.elastic else None
        sums = f"harmonics to order {ORDERS[-1]} neglect"
        quantity = "displacement" if excited.reduced.contacts is None else "slip"
        why = f"{sums} {truncation.contact[-1]:.2g} of the {quantity}, more of the velocity"
        contact = "marched", why
        elastic = "marched", f"{sums} {truncation.elastic[-1]:.2g} of it, above {tolerance:g}"
        if order is not None:
            error = truncation.elastic[ORDERS.index(order)]
            why = f"they neglect {error:.1g} of it, model.tolerance is {tolerance:g}"
            elastic = f"harmonics to order {order} summed", why
    decisions = [_window("contact motion", window, *contact) for window in scene.contact]
    decisions += [_window("elastic motion", window, *elastic) for window in scene.elastic]
    if dofs := ", ".join(map(str, scene.output.elastic)):
        decisions.append(Finding("elastic DOFs", dofs, "output.elastic, in every window"))
    return order, decisions


def _window(subject: str, window: Window, how: str, why: str) -> Finding:
    choice = f"{window.start:g} to {window.end:g} s, {how}"
    samples = f"{window.samples_per_period} samples per period"
    return Finding(subject, choice, f"{samples}; {why}" if why else samples)
