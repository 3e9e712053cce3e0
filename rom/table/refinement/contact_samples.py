"""Contact terms where a friction table asks for them, on several threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus import ContactTerms
from slipmode.rom.table.refinement.sampling import Columns

_Solved = TypeVar("_Solved")

_POINTS_PER_TASK = 16  # fixed, so that the answer does not depend on the number of threads


def in_tasks(
    pool: Executor, solve: Callable[..., _Solved], amplitudes: Floats, *beside: Complexes
) -> Iterator[_Solved]:
    """What `solve` finds at many amplitudes, in tasks of a fixed size on the threads of a pool.

    `beside` are further arguments of it, (points, ...).
    """
    firsts = range(0, len(amplitudes), _POINTS_PER_TASK)
    if len(firsts) == 1:
        return iter([solve(amplitudes, *beside)])
    tasks = [slice(first, first + _POINTS_PER_TASK) for first in firsts]
    return pool.map(solve, *([each[task] for task in tasks] for each in (amplitudes, *beside)))


class ContactSamples:
    """Contact terms at many amplitudes, spread over threads.

    Attributes
    ----------
    solve : callable
        Contact terms at amplitudes (points, modes), from harmonics P near theirs if there are any.
    periodicity : float
        Largest distance from periodicity so far.
    solved : int
        Contact problems so far.
    """

    def __init__(
        self,
        solve: Callable[..., ContactTerms],
        columns: Columns,
        pool: Executor,
        bar: tqdm[Any],
        check: Callable[[ContactTerms], None],
        contacts: int,
    ) -> None:
        self.solve = solve
        self._contacts = contacts
        self._columns = columns
        self._pool = pool
        self._bar = bar
        self._check = check
        self.periodicity = 0.0
        self.solved = 0

    def __call__(self, amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        """The tabulated columns, then those that are carried along, (points, columns).

        `near` are about these, (points, carried).
        """
        parts = []
        beside = [] if near is None or not self._columns.carried else [self._harmonics(near)]
        for terms in in_tasks(self._pool, self.solve, amplitudes, *beside):
            self._check(terms)
            beyond = np.hstack((terms.P.reshape(len(terms.S), -1), terms.left_out))
            carried = beyond[:, : self._columns.carried]
            lost = (terms.power - terms.leaving)[:, np.newaxis]
            parts.append(np.hstack((terms.S, terms.T, lost, carried)))
            self.periodicity = max(self.periodicity, float(terms.residual.max()))
            self.solved += len(terms.S)
            self._bar.update(len(terms.S))
        return np.concatenate(parts)

    def _harmonics(self, carried: Complexes) -> Complexes:
        """P (points, orders, N_c) of columns that are carried; the last are what it leaves out."""
        return carried.reshape(len(carried), -1, self._contacts)[:, :-1]
