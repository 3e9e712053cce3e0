"""Scenes that name nodes and directions, of matrices that know them."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import Labels
from slipmode.runner import make_plan, parse_scene

pytestmark = pytest.mark.quick

SCENE = """
title = "Nodes"
[structure]
matrices = "beam.npz"
contacts = [[31, "y"]]
rayleigh = [0.001, 0.05]
[[contacts]]
law = "jenkins"
limit = 50.0
stiffness = 200.0
[modes]
A = 0
[forcing.A]
node = 34
direction = "y"
amplitude = 0.02
frequency = 0.3
[run]
duration = 100.0
step = 10.0
[[elastic]]
window = [50.0, 60.0]
[output]
elastic = [0]
nodes = [[33, "y"]]
"""


@pytest.fixture
def folder(tmp_path):
    stiffness = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    stiffness[-1, -1] = 1.0
    labels = Labels(np.arange(30, 35), np.full(5, 2))
    rom.Structure(np.eye(5), stiffness, contact=[0], labels=labels).save(tmp_path / "beam.npz")
    return tmp_path


def test_forces_outputs_and_contacts_are_where_the_nodes_are(folder):
    scene = parse_scene(SCENE, folder)
    plan = make_plan(scene)
    assert plan.scene.output.elastic == (0, 3)
    np.testing.assert_array_equal(plan.excited.force_patterns, [[0, 0, 0, 0, 1.0]])
    structure = scene.structure.build()
    np.testing.assert_array_equal(structure.directions, np.eye(5)[:, [1]])
    damping = 0.001 * structure.mass + 0.05 * structure.stiffness
    np.testing.assert_allclose(structure.damping, damping, rtol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("node = 34", "node = 99", "forcing.A: node 99: is not in the structure"),
        ('direction = "y"', 'direction = "z"', "node 34: has no free direction z, allowed: y"),
        ('direction = "y"', 'direction = "up"', "forcing.A.direction: "),
        ("node = 34\n", "node = 34\ndof = 1\n", "forcing.A.dof: give exactly one"),
        ("node = 34\n", "dof = 1\n", "forcing.A.direction: needs node, which is missing"),
        ('[[33, "y"]]', '[[30, "y"]]', "output.nodes: DOFs must differ from"),
        ('[[33, "y"]]', '[["y", 33]]', "output.nodes: must be [node, direction]"),
        ('[[31, "y"]]', '[[31, 1.5, "y"]]', "structure.contacts: must be [node, direction]"),
        ('[[31, "y"]]', '[[7, "y"]]', "beam.npz: node 7: is not in the structure"),
        ("rayleigh =", "damping = 0.1\nrayleigh =", "structure.rayleigh: give one of damping"),
        ("rayleigh = [0.001, ", "rayleigh = [", "structure.rayleigh: must be a list of 2"),
    ],
)
def test_refuses_in_one_line(folder, old, new, message):
    assert old in SCENE
    with pytest.raises(rom.SlipmodeError) as refusal:
        make_plan(parse_scene(SCENE.replace(old, new, 1), folder))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_nodes_need_matrices_that_name_them(folder):
    stiffness = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    rom.Structure(np.eye(5), stiffness, contact=[0]).save(folder / "beam.npz")
    without = SCENE.replace('contacts = [[31, "y"]]\n', "")
    with pytest.raises(rom.SlipmodeError, match=r"^forcing\.A: the matrices name no nodes"):
        make_plan(parse_scene(without, folder))
