"""The amplitude range that a dry run finds: friction limits over time, and forces on contacts."""

import pytest

from slipmode import runner
from slipmode.fmu import StoppedError
from slipmode.runner import make_plan, parse_scene

# The force acts on the contact: what it moves past the mode is half of the effective amplitude.
SCENE = """
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
SCALES = {
    "constant": "1.0",
    "ramp": "[[0, 1.0], [150, 0.2]]",
    "small": "0.1",
    "jump": "[[0, 1.0], [150, 1.0], [150, 0.1]]",
}


@pytest.mark.parametrize("scale", SCALES.values(), ids=SCALES)
def test_runs_stay_in_the_range_where_limits_change(tmp_path, scale):
    """Effective amplitudes relative to the limits at their time are what the table is read at."""
    recording = runner.run(parse_scene(SCENE.format(scale=scale, model=""), "."), tmp_path)
    assert recording.steps >= 300


def test_the_shift_by_the_force_is_divided_by_the_scale_of_the_limits():
    constant, small = (
        make_plan(parse_scene(SCENE.format(scale=scale, model=""), ".")).amplitude[0]
        for scale in ("1.0", "0.1")
    )
    assert 10.0 < small / constant < 20.0  # friction takes less of the motion, too


def test_limits_that_drop_below_the_table_end_the_run_with_a_reason(tmp_path):
    text = SCENE.format(scale=SCALES["jump"], model="amplitude = [1.0]")
    said = r"stopped at t = 150 s: limit_scale = 0\.1 puts the amplitudes outside the friction"
    with pytest.raises(StoppedError, match=said):
        runner.run(parse_scene(text, "."), tmp_path)
