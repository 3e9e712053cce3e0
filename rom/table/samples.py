"""The columns of a table at its nodes, spread over threads.

Where modes respond strongly to the contacts, a search that begins with contacts that stick may end
nowhere although there is a periodic motion. It is continued from neighbours that do settle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.settled import UNSETTLED
from slipmode.rom.contact.torus import ContactTerms
from slipmode.rom.table.refinement import Columns

_Solved = TypeVar("_Solved")

_POINTS_PER_TASK = 16  # fixed, so that the answer does not depend on the number of threads
_NEIGHBOURS = 4  # from which a point that does not settle is tried
_LEAST_STEP = 1 / 8  # of the way from one


def in_tasks(
    pool: Executor, solve: Callable[[Floats], _Solved], amplitudes: Floats
) -> Iterator[_Solved]:
    """What `solve` finds at many amplitudes, in tasks of a fixed size on the threads of a pool."""
    starts = range(0, len(amplitudes), _POINTS_PER_TASK)
    return pool.map(solve, [amplitudes[start : start + _POINTS_PER_TASK] for start in starts])


class Samples:
    """Rows of columns at amplitudes (points, modes).

    Parameters
    ----------
    solve : callable
        Contact terms at amplitudes (points, modes), `start` (orders, N_c): harmonics to begin
        with.
    columns : Columns
    amplitude_range : (modes,) ndarray
    pool : Executor
    bar : tqdm
    check : callable
        Refuses contact terms that are not periodic.
    """

    def __init__(
        self,
        solve: Callable[..., ContactTerms],
        columns: Columns,
        amplitude_range: Floats,
        pool: Executor,
        bar: tqdm[Any],
        check: Callable[[ContactTerms], None],
    ) -> None:
        self._solve = solve
        self._carried = columns.carried
        self._range = amplitude_range
        self._pool = pool
        self._bar = bar
        self._check = check
        self._settled = np.empty((0, amplitude_range.size))
        self.periodicity = 0.0
        self.solved = 0

    def __call__(self, amplitudes: Floats) -> Complexes:
        """At amplitudes (points, modes), (points, columns)."""
        parts = []
        for terms in in_tasks(self._pool, self._solve, amplitudes):
            parts.append(terms)
            self._bar.update(len(terms.S))
        rows = np.concatenate([self._row(terms) for terms in parts])
        residual = np.concatenate([terms.residual for terms in parts])
        settled = residual <= UNSETTLED
        self._settled = np.vstack((self._settled, amplitudes[settled]))
        for point in np.flatnonzero(~settled):
            found = self._continued(amplitudes[point])
            if found is None:
                self._check(parts[point // _POINTS_PER_TASK])
            else:
                rows[point], residual[point] = self._row(found)[0], found.residual[0]
        self.periodicity = max(self.periodicity, float(residual.max()))
        self.solved += len(rows)
        return rows

    def _row(self, terms: ContactTerms) -> Complexes:
        beyond = np.hstack((terms.P.reshape(len(terms.S), -1), terms.left_out))
        lost = (terms.power - terms.leaving)[:, np.newaxis]
        return np.hstack((terms.S, terms.T, lost, beyond[:, : self._carried]))

    def _continued(self, amplitude: Floats) -> ContactTerms | None:
        """From the nearest neighbours one after the other."""
        apart = np.abs((self._settled - amplitude) / self._range).max(axis=1)
        for neighbour in self._settled[np.argsort(apart, kind="stable")[:_NEIGHBOURS]]:
            found = self._led_to(amplitude, neighbour)
            if found is not None:
                return found
        return None

    def _led_to(self, amplitude: Floats, neighbour: Floats) -> ContactTerms | None:
        """Step by step from a neighbour; None where that way is barred."""
        start, reached, step = self._solve(neighbour[np.newaxis]).P[0], 0.0, 1.0
        while step >= _LEAST_STEP:
            part = min(reached + step, 1.0)
            between = neighbour + part * (amplitude - neighbour)
            terms = self._solve(between[np.newaxis], start=start)
            if terms.residual[0] > UNSETTLED:
                step *= 0.5
            elif part == 1.0:
                return terms
            else:
                start, reached = terms.P[0], part
        return None
