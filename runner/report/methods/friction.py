"""Speed against error of the friction functions: the paper's scheme (31) and characteristics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from scipy.stats import qmc

from slipmode import rom
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.friction_terms import friction_functions
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.report.measure import OURS, Row, Section, timed
from slipmode.runner.report.peers.paper_scheme import paper_scheme

ERRORS = ("worst of S", "Q_B at (2.5, 0.3)")
WEAK_MODE = (2.5, 0.3)
_LARGEST = 4.0
_CONVERGED = Discretisation(steps=1024, lines=64)
_HALF = Discretisation(steps=512, lines=32)
_PERIODIC = 1e-6  # of the reference
_WANTED = 1e-3  # error of the setting of ours that decides


class FrictionReference:
    """Converged friction functions of the paper's structure and formulation.

    Parameters
    ----------
    alpha : float
        [m/s]
    points : int
        Amplitude pairs over [0, 4]^2, beside the weak mode under strong dither.
    """

    def __init__(self, alpha: float, points: int) -> None:
        self.law = rom.Tanh(limit=2.0, alpha=alpha)
        self.reduced = rom.reduce(rom.two_mass(), formulation="paper")
        spread = qmc.Halton(2, scramble=False).random(points)[1:] * _LARGEST
        self.amplitudes: Floats = np.vstack([WEAK_MODE, spread])
        self.Q = self.solve(_CONVERGED)
        self.error = self.errors(self.solve(_HALF))[0]

    def solve(self, grid: Discretisation, periodic: float = _PERIODIC) -> Complexes:
        """Our characteristics, marched until the harmonics repeat to `periodic`."""
        return friction_functions(self.reduced, self.law, self.amplitudes, grid, periodic)

    def solve_as_printed(self, steps: int, corner: bool) -> Complexes:
        """The paper's scheme."""
        return paper_scheme(self.reduced, self.law, self.amplitudes, steps, corner=corner)

    def errors(self, Q: Complexes) -> tuple[float, float]:
        """Worst error of S = Q |a| relative to its largest, and that of Q_B at the weak mode."""
        S, exact = Q * self.amplitudes, self.Q * self.amplitudes
        spread = np.abs(S - exact).max(axis=0) / np.abs(exact).max(axis=0)
        return float(spread.max()), float(np.abs(Q[0, 1] / self.Q[0, 1] - 1.0))


def friction_rows(
    reference: FrictionReference, torus: Sequence[tuple[int, int, float]], grids: Sequence[int]
) -> Iterator[Row]:
    """Time per amplitude pair on one processor core, both in C with the same contact solver."""
    count = len(reference.amplitudes)
    for steps, lines, periodic in torus:
        grid = Discretisation(steps, lines)
        seconds, Q = timed(partial(reference.solve, grid, periodic), 9)
        setting = f"{steps} steps, {lines} lines"
        yield Row(OURS, setting, reference.errors(Q), seconds / count)
    for corner, name in ((True, "from the corner"), (False, "from both axes")):
        for steps in grids:
            seconds, Q = timed(partial(reference.solve_as_printed, steps, corner), 1)
            setting = f"{steps} x {steps}"
            yield Row(f"scheme (31) {name}", setting, reference.errors(Q), seconds / count)


def section(reference: FrictionReference, rows: Sequence[Row]) -> Section:
    """The rows as a section; the others are compared with our cheapest setting at 0.1 %."""
    ours = [k for k, row in enumerate(rows) if row.method == OURS]
    exact = [k for k in ours if rows[k].error <= _WANTED] or ours
    return Section(
        key=f"friction functions, alpha {reference.law.alpha:g}",
        title=f"friction functions, alpha {reference.law.alpha:g}",
        task=f"Q_A and Q_B of one amplitude pair, {len(reference.amplitudes)} pairs, one core",
        errors=ERRORS,
        reference_error=reference.error,
        rows=tuple(rows),
        ours=(min(exact, key=lambda k: rows[k].seconds),),
    )
