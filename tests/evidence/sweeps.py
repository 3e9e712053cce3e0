"""A scene of one mode whose forcing frequency sweeps, run by slipmode and integrated beside it."""

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

SPAN, CYCLES = 0.03, 300  # to each side of the drawn frequency; of the whole sweep
ALLOWED = 0.01  # RMS error of a scene without a warning
STEPS = 512  # of the independent solution, per mean period

SCENE = """
title = "A sweep through a resonance"
[structure]
matrices = "body.npz"
{contacts}
[modes]
A = {mode}
[forcing.A]
vector = {force}
amplitude = 1.0
frequency = [[0, {first}], [{end}, {last}]]
[run]
duration = {end}
step = {step}
[[elastic]]
window = [{begin}, {end}]
samples_per_period = 32
[output]
elastic = [{dof}]
[log]
mcap = true
rerun = false
"""


def _contacts(laws: list[Sliders]) -> str:
    """Return the contacts of a scene."""
    return "".join(
        f'[[contacts]]\nlaw = "sliders"\ncontacts = [{i}]\n'
        f"limit = {np.array(law.limits).tolist()}\n"
        f"stiffness = {np.array(law.stiffnesses).tolist()}\n"
        for i, law in enumerate(laws)
    )


class _Warnings(logging.Handler):
    """The warnings that the command line prints."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


def sweep(given: Case) -> list[Answer]:
    """Displacement of the DOF that moves most; a warning with a figure states any error."""
    tone, dof = given.tones[0], int(np.argmax(np.abs(given.shapes[:, 0])))
    end = CYCLES * 2.0 * np.pi / tone.Omega
    first, last = tone.Omega * (1.0 - SPAN), tone.Omega * (1.0 + SPAN)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        structure_and_law(given)[0].save(folder / "body.npz")
        scene = SCENE.format(
            contacts=_contacts(list(given.system.laws)),
            mode=given.modes[0],
            force=tone.F.real.tolist(),
            **{"first": first, "last": last, "dof": dof},
            **{"begin": 0.3 * end, "end": end, "step": 0.5 * end / CYCLES},
        )
        (folder / "sweep.toml").write_text(scene)
        printed = _Warnings()
        logging.getLogger("slipmode").addHandler(printed)
        recording = limited(lambda: runner.run(str(folder / "sweep.toml"), name))
        logging.getLogger("slipmode").removeHandler(printed)
        found = runner.load(recording.mcap)["/elastic"]
    warned = any("RMS error" in line and "%" in line for line in printed.lines)

    def signal(t: np.ndarray) -> np.ndarray:
        return np.cos(first * t + 0.5 * (last - first) * t**2 / end)[:, np.newaxis]

    def displacement(steps: int) -> np.ndarray:
        motion = integrate(
            *(given.system, tone.F.real[:, np.newaxis], signal),
            *(end, steps * CYCLES, steps // 128),
        )
        return CubicSpline(motion.t, motion.x[:, dof])(found.time)

    exact, coarse = displacement(STEPS), displacement(STEPS // 2)
    size = np.linalg.norm(exact)
    true = float(np.linalg.norm(found.values[:, 0] - exact) / size)
    own = float(np.linalg.norm(exact - coarse) / size)
    what = "RMS, warned" if warned else "RMS"
    return [Answer(what, true, np.inf if warned else ALLOWED, own)]
