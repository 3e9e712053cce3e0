"""Single figures: friction table, slow flow, memory."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import qmc

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.contact.friction_terms import contact_terms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.plan.plan import make_plan
from slipmode.runner.report.measure import timed
from slipmode.runner.report.methods.contact_solves import contact_solves
from slipmode.runner.scene.scene import load_scene

_PAPER_LAW = rom.Tanh(limit=2.0, alpha=0.02)
_CONVERGED = Discretisation(steps=1024, lines=64)
_CHECKED_POINTS = 200
# Linux counts the parent's memory into ru_maxrss, but not into VmHWM [kB].
_ASK = """
try:
    status = open("/proc/self/status").read()
    print(status.split("VmHWM:")[1].split()[0])
except OSError:
    import resource
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    subject : str
        What was measured, and under which conditions.
    value : float
    unit : str
        "" for a relative error or a ratio.
    """

    subject: str
    value: float
    unit: str


def figures() -> list[Figure]:
    """Measure all of them."""
    return [*table_figures(), *scene_figures(), *slow_flow_figures(), *memory_figures()]


def table_figures() -> list[Figure]:
    """The friction table of the paper's structure up to |A|, |B| = 4, tolerance 1e-3."""
    reduced = rom.reduce(rom.two_mass(beta=0.01))
    seconds, model = timed(lambda: rom.tabulate(reduced, _PAPER_LAW, (4.0, 4.0), 1e-3), 3)
    points = qmc.Halton(2, scramble=False).random(_CHECKED_POINTS + 1)[1:] * 4.0
    exact = contact_terms(reduced, _PAPER_LAW, points, _CONVERGED, 1e-6).S
    error = np.abs(model.table(points) - exact).max(axis=0) / np.abs(exact).max(axis=0)
    nodes = model.table.node_a.size * model.table.node_b.size
    solves = contact_solves()
    subject = "two-mode table, |A|, |B| <= 4, alpha 0.02, tolerance 1e-3"
    return [
        Figure(f"{subject}: time to build", seconds, "s"),
        Figure(f"{subject}: time to build, per node", seconds / nodes * 1e6, "us"),
        Figure(f"{subject}: worst error between nodes", float(error.max()), ""),
        Figure(
            f"{subject}: time of one core per contact solve, over a bare loop's",
            solves.tabulated / solves.bare,
            "",
        ),
    ]


def scene_figures() -> list[Figure]:
    """The friction table of the shipped two-mode scene."""
    scene = load_scene("two-mode")
    plan = make_plan(scene)
    reduced, law = plan.excited.reduced, plan.excited.law
    build = partial(
        rom.tabulate,
        reduced,
        law,
        plan.amplitude,
        scene.model.tolerance,
        combinations=plan.combinations,
    )
    return [Figure("table of the two-mode scene: time to build", timed(build, 5)[0], "s")]


def slow_flow_figures() -> list[Figure]:
    """The slow flow of the shipped two-mode scene at relative tolerance 1e-6."""
    plan = make_plan(load_scene("two-mode"))
    model, _ = plan.model()

    def amplitudes(tolerance: float) -> tuple[float, np.ndarray]:
        component = Component(model, plan.excited.force_patterns, tolerance=tolerance)
        durations = plan.schedule.durations()
        inputs = plan.schedule.inputs(component.input_names)

        def once() -> np.ndarray:
            component.reset()
            return component.run(durations, inputs)

        seconds, outputs = timed(once, 9)
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
        "import tempfile; from slipmode import runner\n"
        "with tempfile.TemporaryDirectory() as folder: runner.run('two-mode', folder)"
    )
    return [Figure("two-mode run: peak memory over importing rerun", running - importing, "MB")]


def _peak_of(code: str) -> float:
    """Peak resident memory of a Python process that runs the code [MB]."""
    command = [sys.executable, "-c", f"{code}\n{_ASK}"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    return int(answer.stdout.split()[-1]) / 1024
