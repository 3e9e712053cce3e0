"""Speed against error of steady complex amplitudes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.cases import Case
from benchmarks.measure import wall_time
from benchmarks.peers.hbm import Balance, HarmonicBalance
from benchmarks.report.sections import OURS, Row, Section, position
from benchmarks.slow_case import steady_displacement
from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.reduction import Formulation

T = TypeVar("T")

_RANGE = (4.0, 2.0)  # of the table that serves all cases
_CARRIER = (0.98, 1.65)
_SURFACE = ((0.9, 1.1), (1.6, 1.8))  # [rad/s]
_NEIGHBOUR = 0.002  # distance of the frequency whose solution is continued [rad/s]


@dataclass(frozen=True, eq=False)
class SteadyReference:
    """Converged carriers (modes,) of several cases, each mode in the DOF that observes it.

    `error` is the worst relative error, as full order states it.
    """

    cases: list[Case]
    amplitudes: list[Complexes]
    error: float

    @classmethod
    def of(cls, cases: Sequence[Case]) -> SteadyReference:
        """Integrate each case until its carriers no longer change."""
        amplitudes, errors = [], []
        for case in cases:
            found = _by_full_order(case, 3e-6, None)
            own = np.diag(found.amplitude)
            amplitudes.append(own)
            errors.append((np.diag(found.error) / np.abs(own))[forced(case)].max())
        return cls(list(cases), amplitudes, float(max(errors)))

    def errors(self, found: Sequence[Complexes]) -> tuple[float, float]:
        """Return the worst and the mean relative error over the forced modes of all cases."""
        each = np.concatenate(
            [
                np.abs(a / exact - 1.0)[forced(case)]
                for a, exact, case in zip(found, self.amplitudes, self.cases, strict=True)
            ]
        )
        return float(each.max()), float(each.mean())


def _by_full_order(case: Case, tolerance: float, step: float | None) -> full.SteadyAmplitude:
    return full.steady_amplitude(
        *(case.structure, case.law, case.excitation),
        outputs=case.observed,
        tolerance=tolerance,
        step=step,
    )


def forced(case: Case) -> NDArray[np.intp]:
    """Return the modes with a force."""
    return np.flatnonzero(np.any(case.excitation.patterns != 0.0, axis=1))


def slow_rows(
    reference: SteadyReference,
    tolerances: Sequence[float],
    surface: int,
    formulation: Formulation = "consistent",
) -> Iterator[Row]:
    """Yield our steady states, one by one and as points of a resonance surface."""
    method = OURS if formulation == "consistent" else "paper formulation"
    base, last = reference.cases[0], reference.cases[-1]
    reduced = rom.reduce(base.structure, formulation=formulation)
    if formulation == "consistent":
        reduced = reduced.at_carrier(_CARRIER)
    axes = [np.linspace(*ends, surface) for ends in _SURFACE]
    for tolerance in tolerances:
        tabulate = partial(rom.tabulate, reduced, base.law, _RANGE, tolerance)
        table_seconds, model = wall_time(tabulate, 1)
        seconds, found = _each(partial(_steady, model), reference.cases)
        carriers = [
            steady_displacement(model, case, a)
            for case, a in zip(reference.cases, found, strict=True)
        ]
        errors = reference.errors(carriers)
        yield Row(f"{method}, one state", f"table {tolerance:g}", errors, seconds, table_seconds)
        seconds, _ = wall_time(partial(rom.resonance, model, last.force, *axes), 1)
        setting = f"table {tolerance:g}, each of {surface} x {surface}"
        yield Row(f"{method}, surface", setting, errors, seconds / surface**2, table_seconds)


def _steady(model: rom.Model, case: Case) -> Complexes:
    return rom.steady(model, case.frequency, case.force)


def full_rows(
    reference: SteadyReference, settings: Sequence[tuple[float, float]]
) -> Iterator[Row]:
    """Yield time integration until the carriers repeat."""
    for step, tolerance in settings:
        integrate = partial(_by_full_order, tolerance=tolerance, step=step)
        seconds, found = _each(integrate, reference.cases)
        errors = reference.errors([np.diag(each.amplitude) for each in found])
        yield Row("full order", f"step {step:g} s and half, change {tolerance:g}", errors, seconds)


def balance_rows(reference: SteadyReference, highest: Sequence[int]) -> Iterator[Row]:
    """Yield harmonic balance, from zero and from the solution at a neighbouring frequency."""
    for order in highest:
        seconds, found = _each(partial(_balance, order), reference.cases)
        pairs = list(zip(reference.cases, found, strict=True))
        errors = reference.errors([_observed(*pair) for pair in pairs])
        yield Row("harmonic balance", f"order {order}", errors, seconds)
        nearby = [
            wall_time(partial(_balance, order, _neighbour(case), balance.contact), 3)[0]
            for case, balance in pairs
        ]
        yield Row("harmonic balance, continued", f"order {order}", errors, float(np.mean(nearby)))


def _balance(order: int, case: Case, start: Complexes | None = None) -> Balance:
    return HarmonicBalance(case, order).solve(start)


def _neighbour(case: Case) -> Case:
    return replace(case, frequency=tuple(each - _NEIGHBOUR for each in case.frequency))


def _observed(case: Case, balance: Balance) -> Complexes:
    """Carrier of each mode where it is observed, (modes,); 1 for modes without a force."""
    amplitude = np.ones(len(case.force), dtype=complex)
    for row, mode in enumerate(forced(case)):
        amplitude[mode] = balance.displacement[row, case.observed[mode]]
    return amplitude


def _each(solve: Callable[[Case], T], cases: Sequence[Case]) -> tuple[float, list[T]]:
    """Mean time of a case, and all results."""
    measured = [wall_time(partial(solve, case), 3) for case in cases]
    return float(np.mean([seconds for seconds, _ in measured])), [found for _, found in measured]


def section(reference: SteadyReference, rows: Sequence[Row], tolerance: float) -> Section:
    """Return the section; other methods are compared at one table tolerance."""
    methods = (f"{OURS}, surface", f"{OURS}, one state")
    return Section(
        title="steady amplitudes",
        task=f"complex amplitudes, mean time of a state; {len(reference.cases)} states",
        run="state",
        errors=("worst", "mean"),
        reference_error=reference.error,
        rows=tuple(rows),
        ours=tuple(position(rows, method, f"table {tolerance:g}") for method in methods),
    )
