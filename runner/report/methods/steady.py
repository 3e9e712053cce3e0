"""Speed against error on steady complex amplitudes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.reduction import Formulation
from slipmode.runner.report.cases.cases import Case
from slipmode.runner.report.measure import OURS, Row, Section, timed
from slipmode.runner.report.methods.ours import steady_displacement
from slipmode.runner.report.peers.hbm import Balance, HarmonicBalance

T = TypeVar("T")

ERRORS = ("worst", "mean")
_RANGE = (4.0, 2.0)  # of the table that serves all cases
_CARRIER = (0.98, 1.65)
_SURFACE = ((0.9, 1.1), (1.6, 1.8))  # [rad/s]
_NEIGHBOUR = 0.002  # distance of the frequency whose solution is continued [rad/s]


@dataclass(frozen=True, eq=False)
class SteadyReference:
    """Converged carriers of several cases, each forced mode in the DOF that observes it.

    Attributes
    ----------
    cases : list of Case
    amplitudes : list of (modes,) complex ndarray
    error : float
        Worst relative error, as stated by the full order.
    """

    cases: list[Case]
    amplitudes: list[Complexes]
    error: float

    @classmethod
    def of(cls, cases: Sequence[Case]) -> SteadyReference:
        """Integrate each case until its carriers no longer change."""
        amplitudes, errors = [], []
        for case in cases:
            found = full.steady_amplitude(
                *(case.structure, case.law, case.excitation), outputs=case.observed, tolerance=3e-6
            )
            own = np.diag(found.amplitude)
            amplitudes.append(own)
            errors.append((np.diag(found.error) / np.abs(own))[forced(case)].max())
        return cls(list(cases), amplitudes, float(max(errors)))

    def errors(self, found: Sequence[Complexes]) -> tuple[float, float]:
        """Worst and mean relative error over the forced modes of all cases."""
        each = np.concatenate(
            [
                np.abs(a / exact - 1.0)[forced(case)]
                for a, exact, case in zip(found, self.amplitudes, self.cases, strict=True)
            ]
        )
        return float(each.max()), float(each.mean())


def forced(case: Case) -> NDArray[np.intp]:
    """Modes that a force acts on."""
    return np.flatnonzero(np.any(case.excitation.patterns != 0.0, axis=1))


def slow_rows(
    reference: SteadyReference,
    tolerances: Sequence[float],
    surface: int,
    formulation: Formulation = "consistent",
) -> Iterator[Row]:
    """Ours: a state by itself, and as one of a resonance surface."""
    method = OURS if formulation == "consistent" else "paper formulation"
    base = reference.cases[0]
    reduced = rom.reduce(base.structure, formulation=formulation)
    if formulation == "consistent":
        reduced = reduced.at_carrier(_CARRIER)
    for tolerance in tolerances:
        tabulate = partial(rom.tabulate, reduced, base.law, _RANGE, tolerance)
        table_seconds, model = timed(tabulate, 1)
        seconds, found = _each(partial(_steady, model), reference.cases)
        carriers = [
            steady_displacement(model, case, a)
            for case, a in zip(reference.cases, found, strict=True)
        ]
        errors = reference.errors(carriers)
        yield Row(f"{method}, one state", f"table {tolerance:g}", errors, seconds, table_seconds)
        per_state = _surface_seconds(model, reference.cases[-1], surface)
        setting = f"table {tolerance:g}, each of {surface} x {surface}"
        yield Row(f"{method}, surface", setting, errors, per_state, table_seconds)


def _steady(model: rom.Model, case: Case) -> Complexes:
    return rom.steady(model, case.frequency, case.force)


def _surface_seconds(model: rom.Model, case: Case, points: int) -> float:
    axes = [np.linspace(*ends, points) for ends in _SURFACE]
    seconds, _ = timed(lambda: rom.resonance(model, case.force, *axes), 3)
    return seconds / points**2


def full_rows(
    reference: SteadyReference, settings: Sequence[tuple[float, float]]
) -> Iterator[Row]:
    """Time integration until the carriers repeat."""
    for step, tolerance in settings:

        def settle(case: Case, h: float = step, tol: float = tolerance) -> Complexes:
            found = full.steady_amplitude(
                *(case.structure, case.law, case.excitation),
                outputs=case.observed,
                tolerance=tol,
                step=h,
            )
            return np.diag(found.amplitude)

        seconds, found = _each(settle, reference.cases)
        setting = f"step {step:g} s and half, change {tolerance:g}"
        yield Row("full order", setting, reference.errors(found), seconds)


def balance_rows(reference: SteadyReference, highest: Sequence[int]) -> Iterator[Row]:
    """Harmonic balance: from nothing, and from the solution at a neighbouring frequency."""
    for order in highest:
        seconds, found = _each(partial(_balance, order), reference.cases)
        errors = reference.errors(
            [
                _observed(case, balance)
                for case, balance in zip(reference.cases, found, strict=True)
            ]
        )
        yield Row("harmonic balance", f"order {order}", errors, seconds)
        nearby = [
            timed(partial(_balance, order, _neighbour(case), balance.contact), 3)[0]
            for case, balance in zip(reference.cases, found, strict=True)
        ]
        yield Row("harmonic balance, continued", f"order {order}", errors, float(np.mean(nearby)))


def _balance(order: int, case: Case, start: Complexes | None = None) -> Balance:
    return HarmonicBalance(case, order).solve(start)


def _neighbour(case: Case) -> Case:
    return replace(case, frequency=tuple(each - _NEIGHBOUR for each in case.frequency))


def _observed(case: Case, balance: Balance) -> Complexes:
    """Carrier of each mode where it is observed, (modes,); 1 where there is no force."""
    amplitude = np.ones(len(case.force), dtype=complex)
    for row, mode in enumerate(forced(case)):
        amplitude[mode] = balance.displacement[row, case.observed[mode]]
    return amplitude


def _each(solve: Callable[[Case], T], cases: Sequence[Case]) -> tuple[float, list[T]]:
    """Mean over the cases of the time that one takes, and all answers."""
    measured = [timed(partial(solve, case), 3) for case in cases]
    return float(np.mean([seconds for seconds, _ in measured])), [found for _, found in measured]


def section(reference: SteadyReference, rows: Sequence[Row], tolerance: float) -> Section:
    """The rows as a section: a state of a surface, and one by itself, at a table tolerance."""
    wanted = (f"{OURS}, surface", f"{OURS}, one state")
    ours = {
        row.method: k
        for k, row in enumerate(rows)
        if row.setting.split(",")[0] == f"table {tolerance:g}"
    }
    return Section(
        key="steady",
        title="steady amplitudes",
        task=f"complex amplitudes, mean time of a state; {len(reference.cases)} states",
        errors=ERRORS,
        reference_error=reference.error,
        rows=tuple(rows),
        ours=tuple(ours[method] for method in wanted),
    )
