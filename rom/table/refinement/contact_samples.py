"""Contact terms where a friction table asks for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import TorusProblem
from slipmode.rom.contact.resolution import Mapped
from slipmode.rom.contact.slip_onset import stick
from slipmode.rom.table.refinement.sampling import Columns

_Solved = TypeVar("_Solved")

_POINTS_PER_TASK = 16  # fixed, so that the answer does not depend on the number of threads


def in_tasks(
    mapped: Mapped, solve: Callable[..., _Solved], amplitudes: Floats, *beside: Complexes
) -> Iterable[_Solved]:
    """What `solve` finds at many amplitudes, in tasks of a fixed size.

    `beside` are further arguments of it, (points, ...).
    """
    firsts = range(0, len(amplitudes), _POINTS_PER_TASK)
    if len(firsts) == 1:
        return [solve(amplitudes, *beside)]
    tasks = [slice(first, first + _POINTS_PER_TASK) for first in firsts]
    return mapped(solve, *([each[task] for task in tasks] for each in (amplitudes, *beside)))


class ContactSamples:
    """Contact terms at many amplitudes, task by task.

    Attributes
    ----------
    carriers : (modes, N_c) complex ndarray
        P of the contacts at the largest amplitudes, once these were sampled [m].
    periodicity : float
        Largest distance from periodicity so far.
    solved : int
        Contact problems so far.
    """

    def __init__(
        self,
        torus: TorusProblem,
        columns: Columns,
        amplitude_range: Floats,
        mapped: Mapped,
        bar: tqdm[Any],
    ) -> None:
        self._torus = torus
        self._columns = columns
        self._largest = amplitude_range
        self._mapped = mapped
        self._bar = bar
        self._contacts = torus.problem.reduced.n_contacts
        self.carriers: Complexes = np.zeros((amplitude_range.size, self._contacts), dtype=complex)
        self.periodicity = 0.0
        self.solved = 0

    def __call__(self, amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        """The tabulated columns, then those that are carried along, (points, columns).

        `near` are about these, (points, carried). Nothing is solved where all contacts stick.
        """
        sticks = stick(self._torus.problem.reduced, self._torus.problem.law, amplitudes)
        columns = len(self._columns.orders) + self._columns.carried
        samples = np.zeros((len(amplitudes), columns), dtype=complex)
        if not sticks.all():
            begin = None if near is None else near[~sticks]
            samples[~sticks] = self._solved(amplitudes[~sticks], begin)
        return samples

    def _solved(self, amplitudes: Floats, near: Complexes | None) -> Complexes:
        parts, carriers = [], []
        beside = [] if near is None or not self._columns.carried else [self._harmonics(near)]
        for terms in in_tasks(self._mapped, self._torus.solve_on_more_lines, amplitudes, *beside):
            terms.check_periodic()
            columns = [terms.S, terms.T, (terms.power - terms.leaving)[:, np.newaxis]]
            if self._columns.carried:
                columns += [terms.P.reshape(len(terms.S), -1), terms.left_out]
            parts.append(np.concatenate(columns, axis=1))
            carriers.append(terms.P[:, : self._largest.size])
            self.periodicity = max(self.periodicity, float(terms.residual.max()))
            self.solved += len(terms.S)
            self._bar.update(len(terms.S))
        (at,) = np.nonzero((amplitudes == self._largest).all(axis=1))
        if at.size:
            self.carriers = np.concatenate(carriers)[at[0]]
        return np.concatenate(parts)

    def _harmonics(self, carried: Complexes) -> Complexes:
        """P (points, orders, N_c) of columns that are carried; the last are what it leaves out."""
        return carried.reshape(len(carried), -1, self._contacts)[:, :-1]
