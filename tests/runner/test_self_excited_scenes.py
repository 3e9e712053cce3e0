"""Scenes with self-excited modes: what is planned, where they settle, what stops them."""

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.fmu import StoppedError
from slipmode.runner import parse_scene, scene_performance, validate

SCENE = """
[structure]
model = "two-mass"
damping = 0.01
[friction]
law = "{law}"
limit = 2.0
{alpha}
[modes]
A = 0
B = 1
[aerodynamics]
{aerodynamics}
[initial]
{initial}
[run]
duration = 1500
step = 5
[log]
rerun = false
{more}
"""
FORCED = """
[forcing.A]
dof = 0
amplitude = 0.1
frequency = 0.985
[model]
tolerance = 0.02
"""


def scene(aerodynamics="A = [0.0, -0.02]", initial="A = [0.9, 0.0]", more="", alpha=None):
    law = "coulomb" if alpha is None else "tanh"
    alpha = "" if alpha is None else f"alpha = {alpha}"
    text = SCENE.format(
        law=law, alpha=alpha, aerodynamics=aerodynamics, initial=initial, more=more
    )
    return parse_scene(text, ".")


def decisions(plan):
    return {(each.subject, each.choice): each for each in plan.decisions}


def test_a_mode_settles_to_its_limit_cycle(tmp_path):
    recording = runner.run(scene(), tmp_path)
    assert ("mode A", "self-excited") in decisions(recording.plan)
    assert ("mode B", "left out") in decisions(recording.plan)
    stable = rom.limit_cycles(recording.model)[0]
    modes = runner.load(recording.mcap)["/modes"]
    assert modes.column("A_abs")[-1] == pytest.approx(abs(stable.amplitude[0]), rel=1e-4)
    a = modes.column("A_re") + 1j * modes.column("A_im")
    own = recording.model.reduced.frequency[0] + np.angle(a[-1] / a[-2]) / 5.0
    assert own == pytest.approx(stable.frequency[0], rel=1e-5)


def test_full_order_has_the_same_forces(tmp_path):
    # a start that slips leaves a phase of its own, and so does fast growth
    stuck = scene("A = [0.0, -0.014]", initial="A = [0.6, 0.0]")
    found = {each.subject: each.error for each in validate(stuck, tmp_path).comparisons}
    assert found["modal displacement"] < 3e-3  # measured 2.1e-3, 1.8e-3 at 256 steps a period
    assert found["energy dissipated by friction"] < 1e-2


def test_beside_a_forced_mode(tmp_path):
    of_both = scene("B = [0.0, -0.1]", "B = [0.2, 0.0]", FORCED, alpha=0.02)
    recording = runner.run(of_both, tmp_path)
    cycle = rom.limit_cycles(recording.model, (0.985, None), ({0: 0.1}, {}))[0]
    assert cycle.stable
    modes = runner.load(recording.mcap)["/modes"]
    now = [modes.column(f"{mode}_abs")[-1] for mode in "AB"]
    np.testing.assert_allclose(now, np.abs(cycle.amplitude), rtol=5e-3)


def test_one_at_rest_is_modelled_and_warned_of():
    plan = runner.make_plan(scene("B = [0.0, -0.1]", "", FORCED, alpha=0.02))
    warned = decisions(plan)["mode B", "starts at rest"]
    assert warned.level == "warning"
    assert "give initial.B a value other than 0" in warned.reason
    assert plan.amplitude[1] > 0.5  # room for it, should something start it
    started = runner.make_plan(scene("B = [0.0, -0.1]", "B = [0.2, 0.0]", FORCED, alpha=0.02))
    assert ("mode B", "starts at rest") not in decisions(started)


def test_one_that_friction_does_not_hold_is_refused():
    with pytest.raises(rom.SlipmodeError, match=r"^aerodynamics\.A: friction does not"):
        runner.make_plan(scene("A = [0.0, -0.04]"))


def test_past_the_unstable_limit_cycle_the_run_ends_and_says_why(tmp_path):
    far = scene(initial="A = [5.5, 0.0]", more="[model]\namplitude = [7.0, 1.0]")
    with pytest.raises(StoppedError, match=r"\|A\| leaves the friction table.* self-excited"):
        runner.run(far, tmp_path)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"aerodynamics": "A = 0.1"}, "aerodynamics.A: must be a list of 2 numbers"),
        ({"aerodynamics": "A = [0.1]"}, "aerodynamics.A: must be a list of 2 numbers"),
        ({"aerodynamics": "A = [nan, 0.0]"}, "aerodynamics.A[0]: must be finite"),
        ({"aerodynamics": "C = [0.0, 0.0]"}, "aerodynamics.C: unknown key; allowed: A, B"),
        ({"more": '[model]\nformulation = "paper"'}, "model.formulation: must be"),
        ({"initial": ""}, "forcing: no mode moves"),
    ],
)
def test_refused_in_one_line(given, message):
    with pytest.raises(rom.SlipmodeError) as refused:
        scene(**given)
    assert str(refused.value).startswith(message)
    assert "\n" not in str(refused.value)


def test_what_a_single_run_costs_is_in_the_plan(tmp_path, capsys):
    """It integrates at full order, where the damping of a self-excited mode is negative."""
    of = tmp_path / "flutter.toml"
    of.write_text(scene().text)
    assert main(["plan", str(of)]) == 0
    assert "s of processor time" in capsys.readouterr().out


def test_full_order_of_a_self_excited_scene_is_that_of_slow_time(tmp_path):
    reached = []
    for more in ("", '[model]\ntable = "none"'):
        recording = runner.run(scene(initial="A = [0.6, 0.0]", more=more), tmp_path)
        reached.append(runner.load(recording.mcap)["/modes"].column("A_abs")[-1])
    assert reached[1] == pytest.approx(reached[0], rel=5e-3)


def test_a_design_needs_a_force_and_knows_the_aerodynamics():
    with pytest.raises(rom.SlipmodeError, match=r"^forcing\.A: must not be 0"):
        scene_performance(scene())
    with pytest.raises(rom.SlipmodeError, match=r"^mode: A has no damping at .*rom.limit_cycles"):
        scene_performance(scene(more=f"{FORCED}amplitude = [4.0, 1.0]"))
