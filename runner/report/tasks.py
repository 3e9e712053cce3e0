"""What the report measures, in which order: each task makes one section."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from slipmode.runner.report.cases.cases import Case, steady_cases
from slipmode.runner.report.measure import Row, Section
from slipmode.runner.report.methods import friction, signals, steady
from slipmode.runner.report.methods.accuracy import check
from slipmode.runner.report.peers import first_order
from slipmode.runner.report.scope import Scope

Shown = Callable[[Row], object]
Task = Callable[[Shown], Section]

_STEADY_SETTINGS = ((0.25, 1e-2), (0.25, 1e-4))  # step [s], change from window to window
_CRAIG_BAMPTON_MODES = (2, 4, 8)


def speed_tasks(scope: Scope) -> Iterator[Task]:
    """Speed against error, one task a section."""
    for make in scope.signals:
        yield partial(_signals, make, scope)
    yield partial(_steady, scope)
    for alpha in scope.alphas:
        yield partial(_friction, alpha, scope)
    for make in scope.chains:
        yield partial(_chain, make, scope)


def accuracy_tasks(scope: Scope) -> Iterator[Task]:
    """Accuracy on other structures."""
    for make in scope.structures:
        yield partial(_accuracy, make, scope)


def _signals(make: Callable[[], Case], scope: Scope, shown: Shown) -> Section:
    reference = signals.Reference.of(make())

    def rows() -> Iterator[Row]:
        yield from signals.slow_rows(reference, scope.tables, scope.flows)
        yield from signals.slow_rows(reference, scope.tables[-1:], scope.flows[:1], "paper")
        yield from signals.full_rows(reference, scope.refinements)
        peers: list[tuple[str, first_order.Integrate, tuple[float, ...]]]
        peers = [("LSODA", first_order.lsoda, scope.tolerances)]
        if first_order.HAS_CVODE:
            peers.append(("CVODE", first_order.cvode, scope.tolerances))
        peers.append(("BDF", first_order.bdf, scope.slow_tolerances))
        peers.append(("Radau", first_order.radau, scope.slow_tolerances[:1]))
        for name, integrate, tolerances in peers:
            yield from signals.first_order_rows(reference, name, integrate, tolerances)

    name = reference.case.name
    collected = _collect(rows(), shown)
    return signals.section(reference, f"signals, {name}", collected, scope.tables[1], scope.flows)


def _steady(scope: Scope, shown: Shown) -> Section:
    cases = steady_cases()
    reference = steady.SteadyReference.of([cases[k] for k in scope.steady])

    def rows() -> Iterator[Row]:
        yield from steady.slow_rows(reference, scope.tables, scope.surface)
        yield from steady.slow_rows(reference, scope.tables[-1:], scope.surface, "paper")
        yield from steady.full_rows(reference, _STEADY_SETTINGS)
        yield from steady.balance_rows(reference, scope.harmonics)

    return steady.section(reference, _collect(rows(), shown), scope.tables[1])


def _friction(alpha: float, scope: Scope, shown: Shown) -> Section:
    reference = friction.FrictionReference(alpha, scope.points)
    rows = friction.friction_rows(reference, scope.torus, scope.grids)
    return friction.section(reference, _collect(rows, shown))


def _chain(make: Callable[[], Case], scope: Scope, shown: Shown) -> Section:
    reference = signals.Reference.of(make())

    def rows() -> Iterator[Row]:
        yield from signals.slow_rows(reference, scope.tables[:2], scope.flows)
        yield from signals.full_rows(reference, scope.refinements[:4])
        yield from signals.craig_bampton_rows(
            reference, _CRAIG_BAMPTON_MODES, scope.refinements[:4]
        )

    name = reference.case.name
    collected = _collect(rows(), shown)
    return signals.section(reference, f"signals, {name}", collected, scope.tables[1], scope.flows)


def _accuracy(make: Callable[[], Case], scope: Scope, shown: Shown) -> Section:
    section = check(make(), scope.tables[1], scope.refinements[:4])
    shown(section.baseline)
    return section


def _collect(rows: Iterator[Row], shown: Shown) -> list[Row]:
    collected = []
    for row in rows:
        collected.append(row)
        shown(row)
    return collected
