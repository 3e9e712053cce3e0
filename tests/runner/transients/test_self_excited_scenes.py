"""Scenes with self-excited modes: independent integration, limit cycles, what stops them."""

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from oracles.system import Tanh
from scene_motion import Force, integrated

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.fmu import StoppedError
from slipmode.runner import parse_scene, scene_performance

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
duration = {end}
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


def scene(
    aerodynamics="A = [0.0, -0.02]", initial="A = [0.9, 0.0]", more="", alpha=None, end=1500
):
    law = "coulomb" if alpha is None else "tanh"
    alpha = "" if alpha is None else f"alpha = {alpha}"
    given = {"law": law, "alpha": alpha, "end": end}
    given |= {"aerodynamics": aerodynamics, "initial": initial, "more": more}
    return parse_scene(SCENE.format(**given), ".")


def decisions(plan):
    return {(each.subject, each.choice): each for each in plan.decisions}


@pytest.mark.oracle
@pytest.mark.parametrize("table", ["whole", "none"])
def test_a_forced_self_excited_mode_moves_as_the_independent_motion(table, tmp_path):
    """The aerodynamic coefficient i c of mode j adds c / omega phi phi^T to the damping."""
    more = (
        "[forcing.A]\ndof = 0\namplitude = 0.15\nfrequency = 0.98\n[model]\n"
        f'tolerance = 1e-3\ntable = "{table}"\n[output]\nelastic = [0]\n'
        "[[elastic]]\nwindow = [0, 300]\nsamples_per_period = 32\n"
    )
    given = scene("A = [0.0, -0.015]", "", more, alpha=0.02, end=300)
    moved = runner.run(given, tmp_path).read().channels["/elastic"]
    structure = rom.two_mass(beta=0.01)
    system = with_laws(structure, 2 * [Tanh(2.0, 0.02)])
    row = system.M @ rom.reduce(structure, (0,)).mode_shapes[:, 0]
    system.C[:] += np.outer(row, row) * -0.015 / 1.0
    force = Force([1.0, 0.0, 0.0, 0.0], 0.15, 0.98)
    exact = integrated(system, [force], 300.0, 512).at(moved.time)[:, 0]
    assert relative_rms(moved.values[:, 0], exact) < 1e-2


@pytest.mark.oracle
def test_a_mode_settles_to_its_limit_cycle(tmp_path):
    """There, Coulomb friction dissipates what the flow supplies, less structural damping."""
    recording = runner.run(scene(), tmp_path)
    assert ("mode A", "self-excited") in decisions(recording.plan)
    assert ("mode B", "left out") in decisions(recording.plan)
    stable = rom.limit_cycles(recording.model)[0]
    data = runner.load(recording.mcap)
    modes = data["/modes"]
    assert modes.column("A_abs")[-1] == pytest.approx(abs(stable.amplitude[0]), rel=1e-4)
    a = modes.column("A_re") + 1j * modes.column("A_im")
    own = recording.model.reduced.frequency[0] + np.angle(a[-1] / a[-2]) / 5.0
    assert own == pytest.approx(stable.frequency[0], rel=1e-5)
    supplied = (0.02 - 0.01) * 2.0 * abs(a[-1]) ** 2  # less beta omega^2 of mode A
    assert data["/energy"].column("dissipated_power")[-1] == pytest.approx(supplied, rel=3e-2)


@pytest.mark.oracle
def test_a_self_excited_mode_beside_a_forced_one_settles_to_the_limit_cycle(tmp_path):
    of_both = scene("B = [0.0, -0.1]", "B = [0.2, 0.0]", FORCED, alpha=0.02)
    recording = runner.run(of_both, tmp_path)
    cycle = rom.limit_cycles(recording.model, (0.985, None), ({0: 0.1}, {}))[0]
    assert cycle.stable
    modes = runner.load(recording.mcap)["/modes"]
    now = [modes.column(f"{mode}_abs")[-1] for mode in "AB"]
    np.testing.assert_allclose(now, np.abs(cycle.amplitude), rtol=5e-3)


def test_past_the_unstable_limit_cycle_the_run_ends_and_says_why(tmp_path):
    far = scene(initial="A = [5.5, 0.0]", more="[model]\namplitude = [7.0, 1.0]")
    with pytest.raises(StoppedError, match=r"\|A\| leaves the friction table.* self-excited"):
        runner.run(far, tmp_path)


@pytest.mark.oracle
def test_full_order_reaches_the_limit_cycle_of_slow_time_at_a_stated_cost(tmp_path, capsys):
    reached = []
    for more in ("", '[model]\ntable = "none"'):
        recording = runner.run(scene(initial="A = [0.6, 0.0]", more=more), tmp_path)
        reached.append(runner.load(recording.mcap)["/modes"].column("A_abs")[-1])
    assert reached[1] == pytest.approx(reached[0], rel=5e-3)
    of = tmp_path / "flutter.toml"
    of.write_text(scene().text)
    assert main(["plan", str(of)]) == 0
    assert "s of processor time" in capsys.readouterr().out


def test_what_friction_cannot_hold_is_refused():
    with pytest.raises(rom.SlipmodeError, match=r"^aerodynamics\.A: friction does not"):
        runner.make_plan(scene("A = [0.0, -0.04]"))
    with pytest.raises(rom.SlipmodeError, match=r"^forcing\.A: must not be 0"):
        scene_performance(scene())
    with pytest.raises(rom.SlipmodeError, match=r"^mode: A has no damping at .*rom.limit_cycles"):
        scene_performance(scene(more=f"{FORCED}amplitude = [4.0, 1.0]"))
