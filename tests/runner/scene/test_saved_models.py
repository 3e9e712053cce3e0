"""Scenes with a saved model, `model.file`: against closed forms, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest
from rates.saved_models import (
    DROP,
    GROWTH,
    NATURAL,
    ONE_SHAPE,
    RANGE,
    REST,
    TWO_SHAPES,
    one_mode,
    one_rate,
    steady_sizes,
    two_modes,
    two_rates,
)
from recordings import table
from scipy.integrate import cumulative_trapezoid

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import load_scene, parse_scene

REST_OF_SCENE = """[run]
duration = 2.0
step = 0.005
[log]
rerun = false
"""
DECAY = f"""[model]
file = "one.npz"
[initial]
A = [{0.95 * RANGE}, 0.0]
{REST_OF_SCENE}[[elastic]]
window = [0.5, 0.6]
[output]
elastic = [0, 1]
"""
FORCED = f"""[model]
file = "one.npz"
[forcing.A]
dof = 0
amplitude = 8.0
frequency = {0.995 * NATURAL}
{REST_OF_SCENE}"""
BOTH = f"""[model]
file = "two.npz"
[forcing.A]
dof = 0
amplitude = 4.0
frequency = 121.6
[forcing.B]
vector = [0.0, 1.0, 0.5]
amplitude = [[0.0, 0.0], [1.0, 5.0]]
frequency = 242.6
{REST_OF_SCENE}[units]
frequency = "Hz"
""".replace("duration = 2.0", "duration = 9.0")
CONTACTS = """[model]
file = "contacts.npz"
[forcing.A]
dof = 0
amplitude = 0.15
frequency = 0.98
[run]
duration = 300.0
step = 1.0
[log]
rerun = false
[[contact]]
window = [250.0, 260.0]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    one_mode().save(path / "one.npz")
    two_modes().save(path / "two.npz")
    damaged = bytearray((path / "one.npz").read_bytes())
    damaged[len(damaged) // 2] ^= 0xFF
    (path / "damaged.npz").write_bytes(damaged)
    np.savez(path / "older.npz", header=np.array('{"format": 1, "hash": ""}'))
    return path


def recorded(text, folder, output, name="scene"):
    scene = replace(parse_scene(text, folder), name=name)
    return runner.run(scene, output).read().channels


def refusal(text, folder):
    with pytest.raises(SlipmodeError) as refused:
        runner.make_plan(parse_scene(text, folder))
    (line,) = str(refused.value).splitlines()
    return line


# Runs


@pytest.mark.oracle
def test_a_decay_has_its_closed_form(folder, tmp_path):
    """r' = -d r - g r^2, theta' = w - h r: r and its integral in closed form."""
    data = recorded(DECAY, folder, tmp_path)
    start, g, h = 0.95 * RANGE, GROWTH / RANGE, DROP / RANGE

    def size(t):
        left = np.exp(-REST * t)
        return start * left / (1.0 + g / REST * start * (1.0 - left))

    def angle(t):
        return NATURAL * t - h / g * np.log1p(g / REST * start * (1.0 - np.exp(-REST * t)))

    modes, elastic = data["/modes"], data["/elastic"]
    np.testing.assert_allclose(modes.column("A_abs"), size(modes.time), rtol=1e-4)  # 4.4e-5
    t = elastic.time
    for k in range(2):
        moved = 2.0 * ONE_SHAPE[k, 0] * size(t) * np.cos(angle(t))
        error = np.abs(elastic.column(f"x_{k}") - moved).max() / np.abs(moved).max()
        assert error <= 2e-4  # measured 7.4e-5
    energy = data["/energy"].column("dissipated_energy")  # without the damping at rest
    frequency = NATURAL - h * size(modes.time)
    power = 4.0 * NATURAL * frequency * g * size(modes.time) ** 3
    lost = cumulative_trapezoid(power, modes.time, initial=0.0)
    assert np.abs(energy - lost).max() <= 0.01 * lost[-1]  # measured 0.0073
    assert not [topic for topic in data if topic.startswith(("/contact", "/torus", "/phases"))]


@pytest.mark.oracle
def test_two_modes_become_steady_as_written_out(folder, tmp_path):
    data = recorded(BOTH, folder, tmp_path)
    modal = [4.0 * TWO_SHAPES[0, 0], 5.0 * abs(TWO_SHAPES[1, 1] + 0.5 * TWO_SHAPES[2, 1])]
    exact = steady_sizes(two_rates, modal, 2.0 * np.pi * np.array([121.6, 242.6]))
    found = [data["/modes"].column(f"{mode}_abs")[-1] for mode in "AB"]
    np.testing.assert_allclose(found, exact, rtol=1e-5)  # measured 1.2e-6
    assert data["/forcing"].column("B_force")[-1] == 5.0
    supplied, lost = (data["/energy"].column(f"{n}_power")[-1] for n in ("input", "dissipated"))
    at_rest = 2.0 * two_rates(np.zeros((1, 2)))[0][0]  # modal damping [1/s]
    by_damping = 2.0 * at_rest @ (2.0 * np.pi * np.array([121.6, 242.6]) * exact) ** 2
    assert supplied == pytest.approx(lost + by_damping, rel=1e-5)  # measured 6.8e-7


RIGID = '[friction]\nlaw = "coulomb"\nlimit = 2.0\n'


def test_a_saved_model_of_a_scene_runs_as_the_scene_does(tmp_path):
    """Bit for bit: the model is the same."""
    head = '[structure]\nmodel = "two-mass"\n[modes]\nA = 0\n[model]\ntransients = "slow"\n'
    text = CONTACTS.replace('[model]\nfile = "contacts.npz"\n', head + RIGID)
    made = runner.run(replace(parse_scene(text, "."), name="structure"), tmp_path)
    made.model.save(tmp_path / "contacts.npz")
    data, expected = recorded(CONTACTS, tmp_path, tmp_path), made.read().channels
    assert list(data) == list(expected)
    for topic, signals in expected.items():
        np.testing.assert_array_equal(data[topic].values, signals.values, err_msg=topic)


# Curves


@pytest.mark.oracle
def test_curve_and_backbone_commands_have_the_rates(folder, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    (folder / "forced.toml").write_text(FORCED, encoding="utf-8")
    ends = [str(end * NATURAL) for end in (0.985, 1.005)]
    of_scene = [str(folder / "forced.toml"), "-o", str(tmp_path), "--dof", "1"]
    assert main(["curve", *of_scene, "--span", *ends]) == 0
    found = table(tmp_path / "forced.curve.csv")
    size = np.hypot(found["A_re"], found["A_im"])
    for k in (0, size.argmax(), -1):
        (exact,) = steady_sizes(one_rate, [8.0 * ONE_SHAPE[0, 0]], [found["frequency_A"][k]])
        assert size[k] == pytest.approx(exact, rel=1e-4)
        moved = 2.0 * ONE_SHAPE[1, 0] * exact
        assert found["A at DOF 1 [m]"][k] == pytest.approx(moved, rel=1e-4)
    assert main(["backbone", *of_scene]) == 0
    found = table(tmp_path / "forced.backbone.csv")
    assert not capsys.readouterr().err
    damping, frequency = one_rate(found["amplitude"])
    np.testing.assert_allclose(found["frequency"], frequency, rtol=1e-4)
    np.testing.assert_allclose(found["damping"], damping / frequency, rtol=1e-3)


# Refusals

REFUSED = [
    (FORCED + '[structure]\nmodel = "two-mass"\n', "structure: must be left out, because"),
    (FORCED + '[friction]\nlaw = "coulomb"\nlimit = 2.0\n', "friction: must be left out"),
    (FORCED + "[[contact]]\nwindow = [0.0, 1.0]\n",
     "contact: must be left out, because the model of model.file has no contacts; [[elas"),
    (FORCED + "[forcing.B]\ndof = 0\namplitude = 1.0\nfrequency = 2.0\n",
     "forcing.B: must be left out, because [modes] or model.file has only mode A"),
    (FORCED.replace("dof = 0", 'node = 3\ndirection = "x"'),
     "forcing.A: the model of model.file names no nodes; give numbers of DOFs"),
    (FORCED.replace("[forcing", "tolerance = 1e-3\n[forcing"), "model.tolerance: must be left"),
    (DECAY.replace(f"[{0.95 * RANGE}", f"[{1.05 * RANGE}"), "initial: amplitude: mode A reaches"),
    (FORCED.replace("one.npz", "none.npz"), "model.file: no such model file: "),
    (FORCED.replace("one.npz", "damaged.npz"), "model.file: "),
    (FORCED.replace("one.npz", "older.npz"), "model.file: "),
]  # fmt: skip


@pytest.mark.quick
@pytest.mark.parametrize(("text", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_a_refusal_is_one_line_that_names_the_key(folder, text, said):
    line = refusal(text, folder)
    assert line.startswith(said)
    if "damaged.npz" in text:
        assert "not a readable model file" in line or "damaged: " in line
    if "older.npz" in text:
        assert "older.npz: model format 1 must be " in line


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("validate", "model.file: must be left out, because this needs a structure; give [struct"),
        ("fmu --contacts", "--contacts: must be left out, because the model of model.file has no"),
    ],
)
def test_commands_that_need_more_than_a_model_say_so(folder, tmp_path, capsys, arguments, said):
    path = tmp_path / "forced.toml"
    path.write_text(FORCED.replace("one.npz", str(folder / "one.npz")), encoding="utf-8")
    command, *options = arguments.split()
    assert main([command, str(path), *options]) == 1
    assert capsys.readouterr().err.startswith(f"slipmode: {said}")


def test_a_file_that_changes_is_read_again(folder, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(FORCED, encoding="utf-8")
    one_mode().save(tmp_path / "one.npz")
    assert load_scene(path).saved_model is load_scene(path).saved_model
    other = rom.model_of_rates(one_rate, (0.5 * RANGE,), mode_shapes=ONE_SHAPE)
    other.save(tmp_path / "one.npz")
    assert load_scene(path).saved_model.hash == other.hash
