"""What a plan states beside what the run does: amplitude range and carriers."""

import re

import numpy as np
import pytest
from runs import TANH_ON_BOTH_MODES

from slipmode import runner
from slipmode.runner import make_plan, parse_scene

# The force acts on the contact: what it moves past the mode is half of the effective amplitude.
ON_CONTACT = """
[structure]
model = "two-mass"
damping = 0.05
[friction]
law = "coulomb"
limit = 2.0
[limits]
scale = {scale}
[modes]
A = 0
[forcing.A]
dof = 2
amplitude = 1.5
frequency = 0.9
[run]
duration = 300
step = 1.0
[model]
tolerance = 1e-2
{model}
[log]
rerun = false
mcap = false
"""
SCALES = ("1.0", "[[0, 1.0], [150, 0.2]]", "[[0, 1.0], [150, 1.0], [150, 0.1]]")


@pytest.mark.parametrize("scale", SCALES)
def test_runs_stay_in_the_range_where_limits_change(tmp_path, scale):
    """A table is read at effective amplitudes relative to the limits at their time."""
    text = ON_CONTACT.format(scale=scale, model="")
    assert runner.run(parse_scene(text, "."), tmp_path).steps >= 300
    small = make_plan(parse_scene(ON_CONTACT.format(scale="0.1", model=""), "."))
    constant = make_plan(parse_scene(ON_CONTACT.format(scale="1.0", model=""), "."))
    # ten times by homogeneity, and friction takes less of the motion
    assert 10.0 < small.amplitude[0] / constant.amplitude[0] < 20.0


FORMULATION = f"""
[structure]
model = "two-mass"
{TANH_ON_BOTH_MODES}[forcing.A]
dof = 0
amplitude = 0.05
frequency = 0.97
[run]
duration = 800
step = 4
[model]
formulation = "{{}}"
[log]
rerun = false
"""
FORCE_B = "[forcing.B]\ndof = 1\namplitude = 0.05\nfrequency = 1.66\n"
CARRIERS = [
    ("paper", "", [1.0]),
    ("paper", FORCE_B, [1.0, 1.7]),
    ("consistent", FORCE_B, [0.97, 1.66]),
]


@pytest.mark.oracle
@pytest.mark.parametrize(("formulation", "more", "carrier"), CARRIERS)
def test_carriers_are_natural_frequencies_or_those_of_the_forces(formulation, more, carrier):
    plan = make_plan(parse_scene(FORMULATION.format(formulation) + more, "."))
    np.testing.assert_allclose(plan.excited.reduced.carrier, carrier, rtol=1e-12)


LONG = """
structure = {{model = "two-mass", damping = 0.05}}
friction = {{law = "tanh", limit = 2.0, alpha = 0.1}}
modes = {{A = 0, B = 1}}
forcing.A = {{dof = 0, amplitude = {force}, frequency = {frequency_A}, phase = {phase}}}
forcing.B = {{dof = 1, amplitude = 0.25, frequency = {frequency_B}}}
run = {{duration = {duration}, step = {step}}}
log = {{rerun = false}}
"""
HELD = {"force": 0.15, "frequency_A": 0.98, "frequency_B": 1.65, "phase": 0.0, "step": 10.0}
HELD |= {"duration": 2e4}
EVENTS = {
    "held": {},
    "step": {"force": "[[0, 0.02], [1e4, 0.02], [1e4, 0.15]]"},
    "ramp": {"force": "[[0, 0.0], [2e4, 0.15]]"},
    "sweeps": {
        "frequency_A": "[[0, 1.02], [2e4, 0.94]]",
        "frequency_B": "[[0, 1.6], [2e4, 1.75]]",
    },
    "phase": {"phase": "[[0, 0.0], [2e4, 6.0]]"},
    "beat": {"frequency_A": 0.99, "frequency_B": 1.6502},
}


def long_scene(**changes):
    return parse_scene(LONG.format(**HELD | changes), ".")


@pytest.mark.parametrize("events", EVENTS.values(), ids=EVENTS)
def test_the_planned_range_of_a_long_scene_holds_its_run(events, tmp_path):
    """The plan follows less than half of the scene; its margin is 0.15."""
    recording = runner.run(long_scene(**events), tmp_path)
    modes = recording.read().channels["/modes"]
    for planned, mode in zip(recording.plan.amplitude, "AB", strict=True):
        peak = modes.column(f"{mode}_abs").max()
        assert peak < planned < 1.3 * peak


FRICTION = 'law = "tanh", limit = 2.0, alpha = 0.1'
EXTREME = [
    ("limit = 2.0", "limit = 1e30"),
    (FRICTION, 'law = "coulomb", limit = 1e-30'),
    ("amplitude = 0.25", "amplitude = 1e-30"),
    (r"amplitude = 0\.\d+", "amplitude = 1e30"),
    ("alpha = 0.1", "alpha = 1e-30"),
    ("alpha = 0.1", "alpha = 1e30"),
    ("damping = 0.05", "damping = 1e-30"),
    ("damping = 0.05", "damping = 0.05, k_c1 = 1e15"),
    ("damping = 0.05", "damping = 0.05, contact_mass = 1e-30"),
]


@pytest.mark.parametrize("change", EXTREME, ids=str)
def test_extreme_values_have_a_plan(change):
    text = LONG.format(**HELD | {"duration": 50.0, "step": 1.0})
    changed, count = re.subn(*change, text)
    assert count
    assert np.isfinite(make_plan(parse_scene(changed, ".")).amplitude).all()
