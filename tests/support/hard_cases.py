"""Errors of slow time against full order, from rest or through a whole scene."""

from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.measure import worst_rms
from benchmarks.slow_case import SlowCase
from slipmode.rom import full
from slipmode.runner import parse_scene, validate

SCENE = """
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
USUAL = {
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


def signal_error(case):
    """RMS of the displacements from rest against full order, relative, the worst of all."""
    return error_of(SlowCase.tabulate(case, 3e-3))


def error_of(slow):
    """RMS of the displacements by a given model."""
    case, marcher = slow.case, slow.march(1.0)
    motion = marcher.motion(marcher(), case.times)
    exact = full.integrate(
        case.structure,
        case.law,
        case.excitation,
        case.times,
        outputs=case.observed,
        steps_per_period=512,
    )
    return worst_rms(marcher.elastic(motion), exact.displacement)


def scene_text(**changed):
    """A scene of both modes on the paper's structure, in TOML."""
    return SCENE.format(**(USUAL | changed))


def scene_error(**changed):
    """RMS of the modal displacements in the contact window of a scene, as `validate` has it."""
    with TemporaryDirectory() as folder:
        found = validate(parse_scene(scene_text(**changed), Path()), folder)
    return next(c.error for c in found.comparisons if c.subject == "modal displacement")
