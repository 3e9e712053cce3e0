"""Scenes of one mode, run by slipmode and as FMUs, and integrated beside them from rest."""

import logging
import tempfile
from pathlib import Path

import numpy as np
from oracles.families import Case
from oracles.system import Sliders
from oracles.time_integration import integrate
from scipy.interpolate import CubicSpline

from evidence.answers import Answer, limited, structure_and_law
from slipmode import runner

SPAN, CYCLES = 0.03, 300  # of a sweep: to each side of the drawn frequency; periods of a run
ALLOWED = 0.01  # RMS error of a scene without a warning
STEPS = 512  # of the independent solution, per mean period

SCENE = """
title = "A passage through a resonance, or a start from rest"
[structure]
matrices = "body.npz"
{contacts}
[modes]
A = {mode}
[forcing.A]
vector = {force}
amplitude = 1.0
frequency = {frequency}
[run]
duration = {end}
step = {step}
[[{window}]]
window = [{begin}, {end}]
samples_per_period = 32
[output]
elastic = [{dof}]
[log]
mcap = true
rerun = false
"""


class _Warnings(logging.Handler):
    """The warnings that the command line prints."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


class _Passage:
    """A case whose forcing frequency sweeps over a span, or stays for a span of 0."""

    def __init__(self, given: Case, span: float) -> None:
        self.case, self.tone = given, given.tones[0]
        self.end = CYCLES * 2.0 * np.pi / self.tone.Omega
        self.first, self.last = self.tone.Omega * (1.0 - span), self.tone.Omega * (1.0 + span)
        self.dof = int(np.argmax(np.abs(given.shapes[:, 0])))
        self.contact = int(np.argmax(np.abs(given.system.W.T @ given.shapes[:, 0])))
        self.warned = False

    def scene(self, folder: str, begin: float, window: str = "elastic") -> str:
        """Write the scene and its matrices; return its path."""
        structure_and_law(self.case)[0].save(Path(folder) / "body.npz")
        contacts = "".join(
            f'[[contacts]]\nlaw = "sliders"\ncontacts = [{i}]\n'
            f"limit = {np.array(law.limits).tolist()}\n"
            f"stiffness = {np.array(law.stiffnesses).tolist()}\n"
            for i, law in enumerate(self.case.system.laws)
        )
        sweep = f"[[0, {self.first}], [{self.end}, {self.last}]]"
        text = SCENE.format(
            **{"contacts": contacts, "mode": self.case.modes[0], "dof": self.dof},
            **{"force": self.tone.F.real.tolist(), "step": 0.5 * self.end / CYCLES},
            **{"window": window, "begin": begin * self.end, "end": self.end},
            frequency=self.first if self.first == self.last else sweep,
        )
        path = Path(folder) / "passage.toml"
        path.write_text(text)
        return str(path)

    def run(self, begin: float, window: str = "elastic") -> dict:
        """Return the channels of a run, and set whether it warned."""
        printed = _Warnings()
        logging.getLogger("slipmode").addHandler(printed)
        with tempfile.TemporaryDirectory() as folder:
            path = self.scene(folder, begin, window)
            found = runner.load(limited(lambda: runner.run(path, folder)).mcap)
        logging.getLogger("slipmode").removeHandler(printed)
        self.warned = any("RMS error" in line and "%" in line for line in printed.lines)
        return found

    def exact(self, steps: int) -> tuple[CubicSpline, CubicSpline]:
        """Return the displacement of the DOF and of the contact against time."""

        def signal(t: np.ndarray) -> np.ndarray:
            change = 0.5 * (self.last - self.first) * t**2 / self.end
            return np.cos(self.first * t + change)[:, np.newaxis]

        system = self.case.system
        columns = self.tone.F.real[:, np.newaxis]
        motion = integrate(system, columns, signal, self.end, steps * CYCLES, steps // 128)
        moved = motion.x @ system.W[:, self.contact]
        return CubicSpline(motion.t, motion.x[:, self.dof]), CubicSpline(motion.t, moved)

    def compared(self, found: np.ndarray, exact: np.ndarray, coarse: np.ndarray) -> list[Answer]:
        """Return the RMS error; a warning with a figure states any error."""
        size = np.linalg.norm(exact)
        true, own = (float(np.linalg.norm(each - exact) / size) for each in (found, coarse))
        stated = np.inf if self.warned else ALLOWED
        return [Answer("RMS, warned" if self.warned else "RMS", true, stated, own)]


def _displacement(given: Case, span: float, begin: float) -> list[Answer]:
    passage = _Passage(given, span)
    found = passage.run(begin)["/elastic"]
    exact, coarse = (passage.exact(steps)[0](found.time) for steps in (STEPS, STEPS // 2))
    return passage.compared(found.values[:, 0], exact, coarse)


def sweep(given: Case) -> list[Answer]:
    """Displacement of the DOF that moves most, in a sweep."""
    return _displacement(given, SPAN, 0.3)


def rest(given: Case) -> list[Answer]:
    """Displacement of the DOF that moves most, from rest at a constant frequency."""
    return _displacement(given, 0.0, 0.0)


def slider_force(law: Sliders, x: np.ndarray) -> np.ndarray:
    """Return the force along displacements from rest (samples,), which may be much denser."""
    k, reach = np.array(law.stiffnesses), np.divide(law.limits, law.stiffnesses)
    s, found = np.zeros(k.size), np.empty(x.size)
    for i, each in enumerate(x):
        s = np.clip(s, each - reach, each + reach)
        found[i] = k @ (each - s)
    return found


def contact_force(given: Case) -> list[Answer]:
    """Force of the contact that moves most, in a sweep."""
    passage = _Passage(given, SPAN)
    found = passage.run(0.3, "contact")[f"/contact/{passage.contact}"]
    law, t = given.system.laws[passage.contact], np.linspace(0.0, passage.end, 256 * CYCLES + 1)
    exact, coarse = (
        np.interp(found.time, t, slider_force(law, passage.exact(steps)[1](t)))
        for steps in (STEPS, STEPS // 2)
    )
    return passage.compared(found.column("f"), exact, coarse)


def fmu(given: Case) -> list[Answer]:
    """Displacement by the exported FMU, stepped by FMPy from rest."""
    import fmpy

    passage = _Passage(given, 0.0)
    interval = 0.37 * passage.end / CYCLES
    with tempfile.TemporaryDirectory() as folder:
        path = passage.scene(folder, 0.0)
        made = limited(lambda: runner.export_fmu(path, Path(folder) / "passage.fmu"))
        name, stop = f"x_{passage.dof}", interval * int(passage.end / interval)
        found = fmpy.simulate_fmu(
            str(made),
            stop_time=stop,
            output_interval=interval,
            output=[name],
            fmi_type="CoSimulation",
        )
    exact, coarse = (passage.exact(steps)[0](found["time"]) for steps in (STEPS, STEPS // 2))
    return passage.compared(found[name], exact, coarse)
