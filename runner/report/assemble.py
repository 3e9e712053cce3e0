"""The whole report: everything that was measured, and where it is written."""

from __future__ import annotations

import json
import math
import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import Any

from tqdm import tqdm

from slipmode.runner.report.measure import Row, Section, one_thread
from slipmode.runner.report.methods.figures import Figure, figures
from slipmode.runner.report.peers import first_order
from slipmode.runner.report.picture import HAS_MATPLOTLIB, HOW_TO_GET_IT, draw
from slipmode.runner.report.scope import FULL, QUICK
from slipmode.runner.report.tasks import Task, accuracy_tasks, speed_tasks
from slipmode.runner.report.text import render


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
    tasks: list[tuple[list[Section], Task]] = [
        *((found.sections, task) for task in speed_tasks(scope)),
        *((found.structures, task) for task in accuracy_tasks(scope)),
    ]

    def shown(row: Row) -> None:
        bar.set_postfix_str(row.name)

    with (
        one_thread(),
        tqdm(total=len(tasks) + 1, unit=" tasks", desc="report", disable=not progress) as bar,
    ):
        for target, task in tasks:
            target.append(task(shown))
            bar.update()
        found.figures.extend(figures())
        bar.update()
    if output is not None:
        _write(found, Path(output))
    return found


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
        "ours": list(section.ours),
        "rows": rows,
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _runs(value: float) -> float | str | None:
    return "never" if math.isinf(value) else _number(value)
