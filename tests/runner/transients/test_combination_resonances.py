"""Combination resonances beside the independent integration; friction along a sweep."""

import re

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from oracles.system import Tanh
from scene_motion import Force, integrated

from slipmode import rom, runner
from slipmode.runner import load_scene, make_plan, parse_scene


@pytest.mark.oracle
def test_weak_modes_are_within_1_percent_between_steps_of_the_force(tmp_path):
    """Mode B is weak beside A; -5 A + 4 B and +6 A - 3 B are 3 and 5 % from a carrier."""
    text = load_scene("force-step").text
    window = text[text.index("[[contact]]") :]
    text = text.replace(window, "[[elastic]]\nwindow = [0, 1600]\nsamples_per_period = 16\n")
    text += "[output]\nelastic = [0, 1]\n[log]\nrerun = false\n"
    scene = parse_scene(text, ".")
    moved = runner.run(scene, tmp_path).read().channels["/elastic"]
    forces = []
    for dof, script in enumerate(scene.forcing.values()):
        points = np.transpose((script.amplitude.times, script.amplitude.values)).tolist()
        forces.append(Force(np.eye(4)[dof].tolist(), points, script.frequency.values[0]))
    system = with_laws(rom.two_mass(beta=0.01), 2 * [Tanh(2.0, 0.02)])
    exact = integrated(system, forces, 1600.0, 512).at(moved.time)
    for start in range(0, 1600, 200):
        part = (moved.time >= start) & (moved.time < start + 200.0)
        assert np.all(relative_rms(moved.values[part], exact[part, :2]) < 1e-2)


def test_the_plan_says_where_friction_follows_the_frequency():
    """Within the span of the sweep about its mean frequency: 0.985 to 1.015."""
    text = load_scene("one-mode").text
    constant = {d.subject for d in make_plan(parse_scene(text, ".")).decisions}
    assert "friction" not in constant
    sweep = re.sub(r"frequency = \S+", "frequency = [[0, 0.985], [800, 1.015]]", text)
    friction = text[text.index("[friction]") : text.index("[modes]")]
    contacts = '[[contacts]]\nlaw = "jenkins"\nlimit = 0.1\nstiffness = 2.0\n'
    decisions = make_plan(parse_scene(sweep.replace(friction, contacts), ".")).decisions
    (found,) = (each for each in decisions if each.subject == "friction")
    assert found.choice == "follows the forcing frequency" and "1.5 %" in found.reason
