"""The whole report: what is measured, in which order, and where it is written."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import Any

from tqdm import tqdm

from runner.report import friction, signals, steady
from runner.report.accuracy import check
from runner.report.cases import Case, steady_cases
from runner.report.figures import Figure, figures
from runner.report.measure import Row, Section
from runner.report.peers import first_order
from runner.report.picture import HAS_MATPLOTLIB, HOW_TO_GET_IT, draw
from runner.report.scope import FULL, QUICK, Scope
from runner.report.text import render

_STEADY_SETTINGS = ((1.0, 1e-2), (0.5, 1e-2), (0.5, 1e-3), (0.25, 1e-4))
_CRAIG_BAMPTON_MODES = (2, 4, 8)


@dataclass(frozen=True, eq=False)
class Report:
    """Everything that was measured.

    Attributes
    ----------
    sections : list of Section
        Speed against error, one task each.
    structures : list of Section
        Accuracy on other structures.
    figures : list of Figure
    written : list of Path
        JSON and pictures.
    notes : list of str
        What could not be done, and how to get it.
    """

    sections: list[Section]
    structures: list[Section]
    figures: list[Figure]
    written: list[Path]
    notes: list[str]

    def text(self) -> str:
        """The report as tables."""
        return render(self.sections, self.structures, self.figures)

    def numbers(self) -> dict[str, Any]:
        """The report as plain numbers, for JSON."""
        return {
            "slipmode": version("slipmode"),
            "machine": f"{platform.system()} {platform.machine()}, Python "
            f"{platform.python_version()}",
            "sections": [_plain(section) for section in self.sections],
            "structures": [_plain(section) for section in self.structures],
            "figures": [asdict(figure) for figure in self.figures],
            "notes": self.notes,
        }


def report(
    output: str | PathLike[str] | None = None, *, quick: bool = False, progress: bool = False
) -> Report:
    """Measure everything.

    Parameters
    ----------
    output : path, optional
        Folder for report.json, speed-error.png and speed-error.svg.
    quick : bool
        Fewer cases, peers and settings: under a minute instead of several.
    progress : bool
        Show a progress bar.
    """
    scope = QUICK if quick else FULL
    found = Report([], [], [], [], _missing())
    tasks = [
        *((found.sections, task) for task in _speed_tasks(scope)),
        *((found.structures, partial(_accuracy, make, scope)) for make in scope.structures),
    ]
    with (
        _one_thread(),
        tqdm(total=len(tasks) + 1, unit=" tasks", desc="report", disable=not progress) as bar,
    ):
        for target, task in tasks:
            target.append(task(lambda row: bar.set_postfix_str(row.name)))
            bar.update()
        found.figures.extend(figures())
        bar.update()
    if output is not None:
        _write(found, Path(output))
    return found


Shown = Callable[[Row], object]
Task = Callable[[Shown], Section]


def _speed_tasks(scope: Scope) -> Iterator[Task]:
    for make in scope.signals:
        yield partial(_signals, make, scope)
    yield partial(_steady, scope)
    for alpha in scope.alphas:
        yield partial(_friction, alpha, scope)
    for make in scope.chains:
        yield partial(_chain, make, scope)


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
    return signals.section(reference, f"signals, {name}", _collect(rows(), shown))


def _steady(scope: Scope, shown: Shown) -> Section:
    cases = steady_cases()
    reference = steady.SteadyReference.of([cases[k] for k in scope.steady])

    def rows() -> Iterator[Row]:
        yield from steady.slow_rows(reference, scope.tables, scope.surface)
        yield from steady.slow_rows(reference, scope.tables[-1:], scope.surface, "paper")
        yield from steady.full_rows(reference, _STEADY_SETTINGS)
        yield from steady.balance_rows(reference, scope.harmonics)

    return steady.section(reference, _collect(rows(), shown))


def _friction(alpha: float, scope: Scope, shown: Shown) -> Section:
    reference = friction.FrictionReference(alpha, scope.points)
    rows = friction.friction_rows(reference, scope.torus, scope.grids)
    return friction.section(reference, _collect(rows, shown))


def _chain(make: Callable[[], Case], scope: Scope, shown: Shown) -> Section:
    reference = signals.Reference.of(make())

    def rows() -> Iterator[Row]:
        yield from signals.slow_rows(reference, scope.tables[:2], scope.flows)
        yield from signals.full_rows(reference, scope.refinements[:3])
        yield from signals.craig_bampton_rows(
            reference, _CRAIG_BAMPTON_MODES, scope.refinements[:3]
        )

    name = reference.case.name
    return signals.section(reference, f"signals, {name}", _collect(rows(), shown))


def _accuracy(make: Callable[[], Case], scope: Scope, shown: Shown) -> Section:
    section = check(make(), scope.tables[1], scope.refinements[:3])
    shown(section.baseline)
    return section


def _collect(rows: Iterator[Row], shown: Shown) -> list[Row]:
    collected = []
    for row in rows:
        collected.append(row)
        shown(row)
    return collected


def _one_thread() -> AbstractContextManager[object]:
    """BLAS on one thread: matrices this small only lose by more, peers above all."""
    if find_spec("threadpoolctl") is None:
        return nullcontext()
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1)  # type: ignore[no-any-return, unused-ignore]


def _missing() -> list[str]:
    notes = [] if HAS_MATPLOTLIB else [HOW_TO_GET_IT]
    if not first_order.HAS_CVODE:
        notes.append("no CVODE: scikit-sundae is missing; pip install 'slipmode[report]'")
    if find_spec("threadpoolctl") is None:
        notes.append(
            "BLAS may use several threads and slow the peers down: threadpoolctl is missing; "
            "pip install 'slipmode[report]'"
        )
    return notes


def _write(found: Report, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / "report.json"
    target.write_text(json.dumps(found.numbers(), indent=1) + "\n")
    found.written.append(target)
    if HAS_MATPLOTLIB:
        found.written.extend(draw(found.sections, folder))


def _plain(section: Section) -> dict[str, Any]:
    """A section with ratios and break-even; null where there is no number."""
    rows = [
        {
            "method": row.method,
            "setting": row.setting,
            "errors": {
                name: _number(error)
                for name, error in zip(section.errors, row.errors, strict=True)
            },
            "seconds": row.seconds,
            "table_seconds": row.table_seconds,
            "ratio": section.ratio(row),
            "break_even": _runs(section.break_even(row)),
            "note": row.note,
        }
        for row in section.rows
    ]
    return {
        "key": section.key,
        "title": section.title,
        "task": section.task,
        "reference_error": section.reference_error,
        "baseline": section.ours,
        "rows": rows,
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _runs(value: float) -> float | str | None:
    return "never" if math.isinf(value) else _number(value)
