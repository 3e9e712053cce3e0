"""Rows, one per method and setting, and sections of rows on the same task."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

OURS = "slipmode"  # the first word of our methods' names


@dataclass(frozen=True)
class Row:
    """One method at one setting."""

    method: str
    setting: str
    errors: tuple[float, ...]  # the decisive one first; NaN where a method has none
    seconds: float  # median wall time of one run
    table_seconds: float = 0.0  # once, before any run
    note: str = ""

    @property
    def error(self) -> float:
        """The decisive error."""
        return self.errors[0]

    @property
    def name(self) -> str:
        """Method and setting."""
        return f"{self.method}, {self.setting}"

    @property
    def is_peer(self) -> bool:
        """Whether this is another method than ours."""
        return not self.method.startswith(OURS)


@dataclass(frozen=True)
class Section:
    """Rows on the same task, measured against the same reference."""

    title: str
    task: str
    run: str  # what times are of: "run", "state" or "amplitude pair"
    errors: tuple[str, ...]  # names
    reference_error: float  # decisive error of the reference, as the reference states it
    rows: tuple[Row, ...]
    ours: tuple[int, ...]  # our rows that other methods are compared with, the baseline first

    @property
    def baseline(self) -> Row:
        """Our row that decides ratios and numbers of runs."""
        return self.rows[self.ours[0]]

    def ratio(self, row: Row) -> float:
        """Return the time of a row over the time of the baseline."""
        return row.seconds / self.baseline.seconds

    def break_even(self, row: Row) -> float:
        """Return the number of runs after which our table pays; infinite where the row is faster.

        NaN where the row is less accurate than the baseline, or is ours.
        """
        if not row.is_peer or not row.error <= self.baseline.error:
            return float("nan")
        saved = row.seconds - self.baseline.seconds
        cost = self.baseline.table_seconds - row.table_seconds
        return max(cost, 0.0) / saved if saved > 0 else float("inf")

    def rivals(self, ours: Row) -> list[Row]:
        """Return the fastest setting of each other method that is as accurate as a row of ours."""
        fastest: dict[str, Row] = {}
        for row in self.rows:
            if row.is_peer and row.error <= ours.error:
                best = fastest.setdefault(row.method, row)
                fastest[row.method] = min(best, row, key=lambda each: each.seconds)
        return list(fastest.values())


def by_method(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return the rows of each method, in the order of their settings."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.method, []).append(row)
    return found


def position(rows: Sequence[Row], method: str, setting: str) -> int:
    """Return the number of a row whose setting begins with these words."""
    return next(
        k for k, r in enumerate(rows) if r.method == method and r.setting.startswith(setting)
    )
