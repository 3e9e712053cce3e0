"""Times and errors, measured in the same way by every benchmark."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from importlib.util import find_spec
from typing import TypeVar

from slipmode.rom.arrays import Floats
from slipmode.rom.full.convergence import relative_rms

T = TypeVar("T")

_LONG = 1.0  # a call that takes longer is not repeated [s]


def wall_time(function: Callable[[], T], repeats: int = 5) -> tuple[float, T]:
    """Return the median wall time of several calls after a first one, and the last result [s].

    The time of the first call is returned if it is longer than 1 s.
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


def processor_time(function: Callable[[], T], repeats: int = 1) -> tuple[float, T]:
    """Return the least processor time of several calls, and the last result [s].

    Processor time counts all threads of this process and no other programs.
    """
    seconds = []
    for _ in range(repeats):
        started = time.process_time()
        result = function()
        seconds.append(time.process_time() - started)
    return min(seconds), result


def worst_rms(found: Floats, exact: Floats) -> float:
    """Return the relative RMS error of the worst signal; both arrays are (samples, signals)."""
    return float(relative_rms(found, exact).max())


def one_thread() -> AbstractContextManager[object]:
    """Return a context with BLAS on one thread: more threads only slow small matrices down."""
    if find_spec("threadpoolctl") is None:
        return nullcontext()
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1)  # type: ignore[no-any-return, unused-ignore]
