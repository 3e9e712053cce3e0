"""Costs of contact solves: make bench-table.

The cost of a friction table per contact solve over a bare loop of the same arithmetic, and the
growth of the cost of a step with the number of contacts. Times are of one processor core.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.cases import many_contacts
from benchmarks.measure import processor_time
from benchmarks.peers.bare_contacts import bare_march
from slipmode import rom
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.friction import limits

CONTACTS = (1, 2, 10, 30, 100)
ALPHA = 0.02  # [m/s]
_LARGEST = (4.0, 4.0)
_TOLERANCE = 1e-3
_ROUNDS = 7


def contact_solves() -> dict[str, float]:
    """Return seconds for each contact, stage and phase line, shortest of several rounds.

    "bare loop" is bare_contacts.c, "marches" are the marches at the nodes of the table of the
    paper's structure, "whole table" includes the choice of a resolution and all checks.
    """
    law = rom.Tanh(limit=2.0, alpha=ALPHA)
    reduced = rom.reduce(rom.two_mass(beta=0.01))
    tabulate = partial(rom.tabulate, reduced, law, _LARGEST, _TOLERANCE, threads=1)
    model = tabulate()
    grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
    axes = np.meshgrid(*model.table.axes, indexing="ij")
    nodes = np.stack(axes, axis=-1).reshape(-1, 2)
    smallest = 0.1 * np.array(_LARGEST)
    problem = ContactProblem.of(reduced, law, model.combinations)
    march = partial(problem.on(grid, 0.1 * _TOLERANCE, smallest).solve, nodes)
    solves = int(march().marched.sum()) * 2 * grid.lines * reduced.n_contacts
    rounds = [  # side by side, so that all see the same machine
        (
            bare_march(reduced, law, (2.0, 1.0), problem.orders, grid.steps, 20_000)[0],
            processor_time(march)[0] / solves,
            processor_time(tabulate)[0] / solves,
        )
        for _ in range(_ROUNDS)
    ]
    least = np.min(rounds, axis=0).tolist()
    return dict(zip(("bare loop", "marches", "whole table"), least, strict=True))


def step_cost(contacts: int, alpha: float | None = None) -> float:
    """Return the processor time of a step of all contacts at one amplitude [s].

    Under tanh friction with `alpha` [m/s]; None: Coulomb friction. Amplitudes range from sticking
    to slipping.
    """
    case = many_contacts(contacts)
    law = case.law if alpha is None else rom.Tanh(limits(case.law, contacts).tolist(), alpha)
    reduced = rom.reduce(case.structure, (0,), carrier=case.frequency)
    amplitudes = np.linspace(0.25, 4.0, 16)[:, np.newaxis]
    grid = Discretisation(steps=64, lines=1)
    march = partial(ContactProblem(reduced, law).on(grid, 1e-4).solve, amplitudes)
    seconds, found = processor_time(march, 3)
    return seconds / int(found.marched.sum())


def main() -> None:
    """Print both."""
    found = contact_solves()
    for name, seconds in found.items():
        ratio = seconds / found["bare loop"]
        print(f"{name:14} {seconds * 1e9:6.1f} ns per contact solve, {ratio:.2f} bare loops")
    for law, alpha in (("tanh", ALPHA), ("Coulomb", None)):
        costs = ", ".join(f"{1e6 * step_cost(contacts, alpha):.2g}" for contacts in CONTACTS)
        print(f"a step of {', '.join(map(str, CONTACTS))} {law} contacts: {costs} us")


if __name__ == "__main__":
    main()
