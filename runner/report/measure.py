"""What the report consists of: sections of rows, one row per method and setting."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TypeVar

import numpy as np

from slipmode.rom.arrays import Floats

T = TypeVar("T")

OURS = "slipmode"  # what our methods' names begin with
_LONG = 1.0  # what takes longer is measured once [s]


@dataclass(frozen=True)
class Row:
    """One method at one setting.

    Attributes
    ----------
    method, setting : str
    errors : tuple of float
        In the order of the section's `errors`, the decisive one first; NaN where the method has
        no such quantity.
    seconds : float
        Median wall time of one run.
    table_seconds : float
        Once, before any run; 0 where nothing is prepared.
    note : str
    """

    method: str
    setting: str
    errors: tuple[float, ...]
    seconds: float
    table_seconds: float = 0.0
    note: str = ""

    @property
    def error(self) -> float:
        """The decisive error."""
        return self.errors[0]

    @property
    def name(self) -> str:
        """Method and setting."""
        return f"{self.method}, {self.setting}"


@dataclass(frozen=True)
class Section:
    """Rows on the same task, measured against the same reference.

    Attributes
    ----------
    key : str
        Short name.
    title : str
    task : str
        What one run is, and what the errors are relative to.
    errors : tuple of str
        Names of the errors.
    reference_error : float
        What the reference says of its own decisive error.
    rows : tuple of Row
    ours : tuple of int
        Numbers of our rows that other methods are compared with, the decisive one first.
    """

    key: str
    title: str
    task: str
    errors: tuple[str, ...]
    reference_error: float
    rows: tuple[Row, ...]
    ours: tuple[int, ...]

    @property
    def baseline(self) -> Row:
        """The row of ours that decides."""
        return self.rows[self.ours[0]]

    def ratio(self, row: Row) -> float:
        """Time relative to ours."""
        return row.seconds / self.baseline.seconds

    def is_peer(self, row: Row) -> bool:
        """Whether the row belongs to another method than ours."""
        return not row.method.startswith(OURS)

    def break_even(self, row: Row) -> float:
        """Runs after which our table is paid for; infinite where the row's method is faster.

        NaN where the row is less exact than ours, or is ours.
        """
        if not self.is_peer(row) or not row.error <= self.baseline.error:
            return float("nan")
        saved = row.seconds - self.baseline.seconds
        cost = self.baseline.table_seconds - row.table_seconds
        return max(cost, 0.0) / saved if saved > 0 else float("inf")

    def rivals(self, ours: Row) -> list[Row]:
        """The cheapest setting of every other method that is as exact as a row of ours."""
        cheapest: dict[str, Row] = {}
        for row in self.rows:
            if self.is_peer(row) and row.error <= ours.error:
                best = cheapest.setdefault(row.method, row)
                cheapest[row.method] = min(best, row, key=lambda each: each.seconds)
        return list(cheapest.values())


def timed(function: Callable[[], T], repeats: int = 5) -> tuple[float, T]:
    """Median wall time of several calls after a first one, and the last result.

    What takes long is not called again.
    """
    started = time.perf_counter()
    result = function()
    seconds = [time.perf_counter() - started]
    if seconds[0] < _LONG:
        seconds.clear()
        for _ in range(repeats):
            started = time.perf_counter()
            result = function()
            seconds.append(time.perf_counter() - started)
    return statistics.median(seconds), result


def relative_rms(found: Floats, exact: Floats) -> float:
    """RMS of the difference over the RMS of the exact signal, the worst column."""
    difference = np.linalg.norm(found - exact, axis=0)
    return float((difference / np.linalg.norm(exact, axis=0)).max())


def one_thread() -> AbstractContextManager[object]:
    """BLAS on one thread: matrices this small only lose by more, peers above all."""
    if find_spec("threadpoolctl") is None:
        return nullcontext()
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1)  # type: ignore[no-any-return, unused-ignore]
