"""The paper's formulation has its carriers at the natural frequencies, in scenes too: they run."""

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.runner import parse_scene

SCENE = """
[structure]
model = "two-mass"
[friction]
law = "tanh"
limit = 2.0
alpha = 0.02
[modes]
A = 0
B = 1
[forcing.A]
dof = 0
amplitude = 0.05
frequency = 0.97
[run]
duration = 800
step = 4
[model]
formulation = "{formulation}"
"""


BOTH = """
[forcing.B]
dof = 1
amplitude = 0.05
frequency = 1.66
"""


@pytest.mark.parametrize(
    ("formulation", "more", "carrier"),
    [
        ("paper", "", [1.0]),
        ("paper", BOTH, [1.0, 1.7]),
        ("consistent", BOTH, [0.97, 1.66]),
    ],
)
def test_carriers_of_a_scene(formulation, more, carrier):
    plan = runner.make_plan(parse_scene(SCENE.format(formulation=formulation) + more, "."))
    np.testing.assert_allclose(plan.excited.reduced.carrier, carrier, rtol=1e-12)


def test_a_scene_from_rest_runs(tmp_path):
    recording = runner.run(parse_scene(SCENE.format(formulation="paper"), "."), tmp_path)
    steady = rom.steady(recording.model, 0.97, [{0: 0.05}])
    modes = runner.load(recording.mcap)["/modes"]
    assert modes.column("A_abs")[-1] == pytest.approx(abs(steady[0]), rel=0.05)
