"""Our signals against full order, from rest or through a whole scene."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.runner.report.cases.cases import Case
from slipmode.runner.report.measure import relative_rms
from slipmode.runner.report.methods.ours import SlowCase
from slipmode.runner.scene.scene import parse_scene
from slipmode.runner.validation.validate import validate

_TOLERANCE = 3e-3  # of the friction table
_REFERENCE_STEPS = 512  # per period

_SCENE = """
[structure]
model = "two-mass"
damping = {damping}
[friction]
law = "{law}"
limit = {limit}
{alpha}
[modes]
A = 0
B = 1
[forcing.A]
dof = 0
amplitude = {force_A}
frequency = {frequency_A}
phase = {phase_A}
[forcing.B]
dof = 1
amplitude = {force_B}
frequency = {frequency_B}
[run]
duration = {duration}
step = {step}
[model]
{model}
[[contact]]
window = {window}
samples_per_period = 32
"""
_USUAL: dict[str, object] = {
    "damping": 0.01,
    "law": "tanh",
    "limit": 2.0,
    "alpha": "alpha = 0.02",
    "force_A": 0.15,
    "force_B": 0.25,
    "frequency_A": 0.98,
    "frequency_B": 1.65,
    "phase_A": 0.0,
    "duration": 600.0,
    "step": 1.0,
    "model": "",
    "window": [0.0, 600.0],
}


def reference(case: Case) -> Floats:
    """Displacement of the observed DOFs by full order at a small step, (samples, observed)."""
    return full.integrate(
        *(case.structure, case.law, case.excitation, case.times),
        outputs=case.observed,
        steps_per_period=_REFERENCE_STEPS,
    ).displacement


def signal_error(case: Case) -> float:
    """RMS of the displacements from rest against full order, relative, the worst of all."""
    return error_of(SlowCase.tabulate(case, _TOLERANCE))


def error_of(slow: SlowCase) -> float:
    """The same with a model that is there already."""
    marcher = slow.march(1.0)
    motion = marcher.motion(marcher(), slow.case.times)
    return relative_rms(marcher.elastic(motion), reference(slow.case))


def scene_text(**changed: object) -> str:
    """A scene of both modes on the paper's structure, in TOML."""
    return _SCENE.format(**(_USUAL | changed))


def scene_error(**changed: object) -> float:
    """RMS of the modal displacements in the contact window of a scene, as `validate` has it."""
    scene = parse_scene(scene_text(**changed), Path())
    with TemporaryDirectory() as folder:
        found = validate(scene, folder)
    return next(c.error for c in found.comparisons if c.subject == "modal displacement")


def largest(values: NDArray[Any]) -> float:
    """The largest absolute value."""
    return float(np.abs(values).max())
