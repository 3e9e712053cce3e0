"""Speed against error of friction functions: the paper's scheme (31) and characteristics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from scipy.stats import qmc

from benchmarks.measure import wall_time
from benchmarks.peers.paper_scheme import paper_scheme
from benchmarks.report.sections import OURS, Row, Section
from slipmode import rom
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation

WEAK_MODE = (2.5, 0.3)  # |A|, |B|: scheme (31) does not converge to Q_B there
_LARGEST = 4.0  # of |A| and |B|
_REQUIRED = 1e-3  # error of our setting that decides


class FrictionReference:
    """Converged friction functions of the paper's structure and formulation.

    Parameters
    ----------
    alpha : float
        [m/s]
    points : int
        Amplitude pairs over [0, 4]^2, besides `WEAK_MODE`.
    """

    def __init__(self, alpha: float, points: int) -> None:
        self.law = rom.Tanh(limit=2.0, alpha=alpha)
        self.reduced = rom.reduce(rom.two_mass(), formulation="paper")
        spread = qmc.Halton(2, scramble=False).random(points)[1:] * _LARGEST
        self.amplitudes: Floats = np.vstack([WEAK_MODE, spread])
        self.Q = self.solve(Discretisation(steps=1024, lines=64), 1e-6)
        self.error = self.errors(self.solve(Discretisation(steps=512, lines=32), 1e-6))[0]

    def solve(self, grid: Discretisation, periodic: float) -> Complexes:
        """Return Q by characteristics, marched until harmonics repeat to a tolerance."""
        return (
            ContactProblem.of(self.reduced, self.law).on(grid, periodic).solve(self.amplitudes).Q
        )

    def errors(self, Q: Complexes) -> tuple[float, float]:
        """Return the worst error of S = Q |a|, and the error of Q_B at the weak mode."""
        S, exact = Q * self.amplitudes, self.Q * self.amplitudes
        spread = np.abs(S - exact).max(axis=0) / np.abs(exact).max(axis=0)
        return float(spread.max()), float(np.abs(Q[0, 1] / self.Q[0, 1] - 1.0))


def friction_rows(
    reference: FrictionReference, torus: Sequence[tuple[int, int, float]], grids: Sequence[int]
) -> Iterator[Row]:
    """Yield times of one amplitude pair; both sides in C, with the same contact solver."""
    count = len(reference.amplitudes)
    for steps, lines, periodic in torus:
        solve = partial(reference.solve, Discretisation(steps, lines), periodic)
        seconds, Q = wall_time(solve, 9)
        setting = f"{steps} steps, {lines} lines"
        yield Row(OURS, setting, reference.errors(Q), seconds / count)
    scheme = partial(paper_scheme, reference.reduced, reference.law, reference.amplitudes)
    for corner, start in ((True, "the corner"), (False, "both axes")):
        for steps in grids:
            seconds, Q = wall_time(partial(scheme, steps, corner=corner), 1)
            errors = reference.errors(Q)
            yield Row(f"scheme (31) from {start}", f"{steps} x {steps}", errors, seconds / count)


def section(reference: FrictionReference, rows: Sequence[Row]) -> Section:
    """Return the section; the baseline is our fastest setting with an error of 0.1 %."""
    ours = [k for k, row in enumerate(rows) if not row.is_peer]
    exact = [k for k in ours if rows[k].error <= _REQUIRED] or ours
    return Section(
        title=f"friction functions, alpha {reference.law.alpha:g}",
        task=f"Q_A and Q_B of one amplitude pair, {len(reference.amplitudes)} pairs, one core",
        run="amplitude pair",
        errors=("worst of S", "Q_B at (2.5, 0.3)"),
        reference_error=reference.error,
        rows=tuple(rows),
        ours=(min(exact, key=lambda k: rows[k].seconds),),
    )
