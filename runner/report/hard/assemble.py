"""The table of hard cases: measured, printed, and kept as numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from tqdm import tqdm

from slipmode.runner.report.hard.hard_case import HardCase, Outcome
from slipmode.runner.report.hard.matrix import CASES
from slipmode.runner.report.hard.others import DURATION, PATIENCE, Attempt, attempts
from slipmode.runner.report.measure import one_thread
from slipmode.runner.report.text import aligned

_LEGEND = f"""\
A case meets its bound, or is refused with the reason. Other integrators do the first
{DURATION:g} s of the same motion, without our model: wall time and RMS error of the displacements,
or why there are none ("too slow" after {PATIENCE:g} s of wall time, "gives up" by its own
account)."""


@dataclass(frozen=True, eq=False)
class HardReport:
    """Every case as measured.

    Attributes
    ----------
    outcomes : list of Outcome
    others : list of list of Attempt
        Other integrators, per outcome.
    """

    outcomes: list[Outcome]
    others: list[list[Attempt]]

    def text(self) -> str:
        """The table, what could go wrong in each case, and the reasons."""
        methods = list(dict.fromkeys(a.method for found in self.others for a in found))
        head = ("case", "quantity", "bound", "measured", "verdict", *methods)
        lines = [
            (*_line(outcome), *_cells(found, methods))
            for outcome, found in zip(self.outcomes, self.others, strict=True)
        ]
        risks = [(o.case.name, o.case.risk) for o in self.outcomes]
        refused = [(o.case.name, o.reason) for o in self.outcomes if o.reason]
        parts = [
            [_LEGEND],
            aligned([head, *lines]),
            ["what could go wrong", *aligned(risks)],
        ]
        if refused:
            parts.append(["refused because", *aligned(refused)])
        return "\n\n".join("\n".join(part) for part in parts)

    def numbers(self) -> list[dict[str, Any]]:
        """The same as plain numbers, for JSON."""
        return [
            {
                "case": outcome.case.name,
                "risk": outcome.case.risk,
                "quantity": outcome.case.quantity,
                "bound": outcome.case.bound,
                "measured": _number(outcome.measured),
                "verdict": outcome.verdict,
                "reason": outcome.reason,
                "others": [asdict(a) | {"error": _number(a.error)} for a in found],
            }
            for outcome, found in zip(self.outcomes, self.others, strict=True)
        ]


def hard_report(
    output: str | PathLike[str] | None = None,
    cases: Sequence[HardCase] = CASES,
    *,
    progress: bool = False,
) -> HardReport:
    """Measure every case, and other integrators where there is a motion to compare.

    Parameters
    ----------
    output : path, optional
        Folder for hard.json.
    progress : bool
        Show a progress bar.
    """
    found = HardReport([], [])
    with one_thread(), tqdm(cases, unit=" cases", desc="hard", disable=not progress) as bar:
        for case in bar:
            bar.set_postfix_str(case.name)
            found.outcomes.append(case.judge())
            found.others.append(attempts(case.motion) if case.motion else [])
    if output is not None:
        folder = Path(output)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "hard.json").write_text(json.dumps(found.numbers(), indent=1) + "\n")
    return found


def _line(outcome: Outcome) -> tuple[str, ...]:
    case = outcome.case
    measured = "" if math.isnan(outcome.measured) else f"{outcome.measured:.1e}"
    return (case.name, case.quantity, f"{case.bound:.1e}", measured, outcome.verdict)


def _cells(found: Sequence[Attempt], methods: Sequence[str]) -> tuple[str, ...]:
    by_name = {attempt.method: attempt for attempt in found}
    return tuple(_cell(by_name[name]) if name in by_name else "" for name in methods)


def _cell(attempt: Attempt) -> str:
    if attempt.failure:
        return attempt.failure
    return f"{attempt.seconds * 1e3:.3g} ms {attempt.error:.0e}"


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
