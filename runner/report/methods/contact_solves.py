"""What a friction table costs per contact solve, over a bare loop of the same arithmetic."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipmode import rom
from slipmode.rom.contact.friction_terms import contact_orders, contact_terms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.report.peers.bare_contacts import bare_march

_LAW = rom.Tanh(limit=2.0, alpha=0.02)
_LARGEST = (4.0, 4.0)
_TOLERANCE = 1e-3
_BARE_STEPS = 20_000
_ROUNDS = 7


@dataclass(frozen=True)
class ContactSolves:
    """Seconds for each contact, stage and phase line on one processor core, shortest of several.

    Attributes
    ----------
    bare : float
        By bare_contacts.c.
    marched : float
        In the marches at the nodes of the table.
    tabulated : float
        Of the whole table: with the choice of a resolution, the points that check it, Python.
    """

    bare: float
    marched: float
    tabulated: float


def contact_solves() -> ContactSolves:
    """Measure the paper's structure with the reaction of the modes, |A|, |B| <= 4."""
    reduced = rom.reduce(rom.two_mass(beta=0.01))
    model = rom.tabulate(reduced, _LAW, _LARGEST, _TOLERANCE)
    grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
    axes = np.meshgrid(*model.table.axes, indexing="ij")
    nodes = np.stack(axes, axis=-1).reshape(-1, 2)
    smallest = 0.1 * np.array(_LARGEST)
    orders = contact_orders(reduced, model.combinations)

    def tabulate() -> None:
        rom.tabulate(reduced, _LAW, _LARGEST, _TOLERANCE, threads=1)

    def march() -> int:
        terms = contact_terms(
            *(reduced, _LAW, nodes, grid, 0.1 * _TOLERANCE, smallest, model.combinations)
        )
        return int(terms.marched.sum()) * 2 * grid.lines * reduced.n_contacts

    solves = march()
    bare = marched = tabulated = math.inf
    for _ in range(_ROUNDS):  # side by side, so that all see the same machine
        marching = bare_march(reduced, _LAW, (2.0, 1.0), orders, grid.steps, _BARE_STEPS)
        bare = min(bare, marching.seconds)
        marched = min(marched, _seconds(march))
        tabulated = min(tabulated, _seconds(tabulate))
    return ContactSolves(bare, marched / solves, tabulated / solves)


def _seconds(function: Callable[[], object]) -> float:
    """Of the processor, not of the wall: other programs do not count."""
    started = time.process_time()
    function()
    return time.process_time() - started


def main() -> None:
    """Print them."""
    found = contact_solves()
    print(f"bare loop      {found.bare * 1e9:6.1f} ns per contact solve")
    for name, seconds in (("marches", found.marched), ("whole table", found.tabulated)):
        print(f"{name:14} {seconds * 1e9:6.1f} ns, {seconds / found.bare:.2f} times that")
