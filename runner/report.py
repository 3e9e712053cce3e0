"""The report: what slipmode costs and how exact it is, measured here and now."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy.stats import qmc

import rom
from fmu import Component
from rom.torus import Discretisation, contact_terms
from runner.plan import make_plan
from runner.scene import load_scene

T = TypeVar("T")

_PAPER_LAW = rom.Tanh(limit=2.0, alpha=0.02)
_CONVERGED = Discretisation(steps=1024, lines=64)
_CHECKED_POINTS = 200


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    subject : str
        What was measured, and under which conditions.
    value : float
    unit : str
        "" for a relative error.
    """

    subject: str
    value: float
    unit: str


def report(path: str | PathLike[str] | None = None) -> list[Figure]:
    """Measure everything; write the figures to a JSON file where a path is given."""
    figures = [*table_figures(), *slow_flow_figures(), *memory_figures()]
    if path is not None:
        target = Path(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(json.dumps([asdict(figure) for figure in figures], indent=1) + "\n")
    return figures


def table_figures() -> list[Figure]:
    """The friction table of the paper's structure up to |A|, |B| = 4, tolerance 1e-3."""
    reduced = rom.reduce(rom.two_mass(beta=0.01))
    seconds, model = _timed(lambda: rom.tabulate(reduced, _PAPER_LAW, (4.0, 4.0), 1e-3), 3)
    points = qmc.Halton(2, scramble=False).random(_CHECKED_POINTS + 1)[1:] * 4.0
    exact = contact_terms(reduced, _PAPER_LAW, points, _CONVERGED, 1e-6).S
    error = np.abs(model.table(points) - exact).max(axis=0) / np.abs(exact).max(axis=0)
    subject = "two-mode table, |A|, |B| <= 4, alpha 0.02, tolerance 1e-3"
    return [
        Figure(f"{subject}: time to build", seconds, "s"),
        Figure(f"{subject}: worst error between nodes", float(error.max()), ""),
    ]


def slow_flow_figures() -> list[Figure]:
    """The slow flow of the shipped two-mode scene at relative tolerance 1e-6."""
    plan = make_plan(load_scene("two-mode"))
    model, _ = plan.model()

    def amplitudes(tolerance: float) -> tuple[float, np.ndarray]:
        component = Component(model, plan.excited.force, tolerance=tolerance)
        inputs = plan.schedule.inputs(component.input_names)

        def once() -> np.ndarray:
            component.reset()
            return component.run(plan.schedule.durations, inputs)

        seconds, outputs = _timed(once, 9)
        return seconds, outputs[:, 1:5]

    seconds, loose = amplitudes(1e-6)
    _, tight = amplitudes(1e-12)
    subject = "slow flow of two-mode, 1500 s in steps of 1 s, tolerance 1e-6"
    return [
        Figure(f"{subject}: time", seconds * 1e3, "ms"),
        Figure(
            f"{subject}: error against tolerance 1e-12",
            float(np.abs(loose - tight).max() / np.abs(tight).max()),
            "",
        ),
    ]


def memory_figures() -> list[Figure]:
    """Peak memory of `slipmode run two-mode` beyond what importing rerun takes."""
    importing = _peak_of("import rerun")
    running = _peak_of(
        "import tempfile, runner\n"
        "with tempfile.TemporaryDirectory() as folder: runner.run('two-mode', folder)"
    )
    return [Figure("two-mode run: peak memory over importing rerun", running - importing, "MB")]


def _timed(function: Callable[[], T], repeats: int) -> tuple[float, T]:
    """Median wall time of several calls after a first one, and the last result."""
    result = function()
    seconds = []
    for _ in range(repeats):
        started = time.perf_counter()
        result = function()
        seconds.append(time.perf_counter() - started)
    return statistics.median(seconds), result


def _peak_of(code: str) -> float:
    """Peak resident memory of a Python process that runs the code [MB]."""
    ask = "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    command = [sys.executable, "-c", f"{code}\n{ask}"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    return int(answer.stdout.split()[-1]) / 1024
