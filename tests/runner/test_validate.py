"""slipmode validate: full order beside the independent integration; what a plan warns of."""

import re

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from oracles.system import Tanh
from scene_motion import Force, integrated

from slipmode import rom
from slipmode.runner import load_scene, make_plan, parse_scene, read, shipped_scenes, validate

INTERPOLATION = 2e-4  # of the contacts between 512 samples a period, relative


@pytest.fixture(scope="module", name="one_mode")
def validation_of_one_mode(tmp_path_factory):
    """What validate returns, its recording, and what the command prints."""
    folder = tmp_path_factory.mktemp("validated")
    found = validate("one-mode", folder)
    (path,) = (each for each in found.recordings if each.suffix == ".mcap")
    return found, read(path)


@pytest.mark.oracle
def test_both_motions_are_within_their_stated_errors(one_mode):
    """Full order within its reference error, and the error of slow time is the true one."""
    found, recording = one_mode
    scene = load_scene("one-mode")
    script = scene.forcing["A"]
    force = Force(
        *([1.0, 0.0, 0.0, 0.0], script.amplitude.values[0], script.frequency.values[0]),
    )
    law = scene.friction
    system = with_laws(rom.two_mass(beta=0.01), 2 * [Tanh(law.limit, law.alpha)])
    exact, coarse = (
        integrated(system, [force], scene.run.duration, n, samples=512) for n in (1024, 512)
    )
    errors = {line.subject: line for line in found.comparisons}
    for contact in range(2):
        _, time, slow = recording.channels[f"/contact/{contact}"]
        _, full_time, full = recording.channels[f"/full/contact/{contact}"]
        np.testing.assert_array_equal(time, full_time)
        theirs = exact.at(time)[:, 2 + contact]
        own = relative_rms(coarse.at(time)[:, 2 + contact], theirs) + INTERPOLATION
        stated = errors["contact displacement"]
        reference = stated.reference_error + own
        assert relative_rms(full[:, 0], theirs) <= reference
        assert relative_rms(slow[:, 0], theirs) <= stated.error + reference
    assert errors["modal displacement"].error < 1e-3  # the tolerance of the table
    assert errors["energy dissipated by friction"].error < 1e-3


def test_a_scene_without_a_table_is_compared_on_its_reduced_coordinates(tmp_path):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    (tmp_path / "none.toml").write_text(f'{text}\n[model]\ntable = "none"\n', encoding="utf-8")
    found = validate(tmp_path / "none.toml", tmp_path)
    assert found.reduced == "reduced coordinates"
    # all coordinates of two masses are reduced ones
    for line in found.comparisons:
        assert line.error <= 1e-3, line.subject
    recording = read(tmp_path / "none.validation.mcap")
    assert found.compared() in [event.message for event in recording.events]


SCENE = """
friction = {{law = "tanh", limit = {limit}, alpha = 0.02}}
modes = {{A = 0, B = 1}}
forcing.A = {{dof = 0, amplitude = 0.05, frequency = 0.99}}
forcing.B = {{dof = 1, amplitude = 0.05, frequency = {frequency}}}
run = {{duration = 200.0, step = 1.0}}
[structure]
{structure}
"""


def warnings(structure, folder=".", limit=2.0, frequency=1.66):
    text = SCENE.format(structure=structure, limit=limit, frequency=frequency)
    decisions = make_plan(parse_scene(text, folder)).decisions
    return [f"{d.subject} {d.choice}: {d.reason}" for d in decisions if d.level == "warning"]


@pytest.mark.parametrize(
    ("structure", "values", "message"),
    [
        ("k2 = 1.1", {"frequency": 1.06}, r"mode A is close to another mode: .*4\.9 %"),
        ("k_c1 = 1.5", {"limit": 0.05}, "mode A is strongly perturbed: .* stiffness by 52 %"),
        (
            "k_c1 = 2.5\nk_c2 = 5\nk_p = 0.6",
            {},
            "stiffness is low: .* reduces the contact stiffness by 5. %",
        ),
        ("", {"limit": 1e9}, "friction does not act"),
    ],
)
def test_a_plan_warns_of_strained_assumptions_with_their_figure(structure, values, message):
    assert warnings('model = "two-mass"') == []
    found = warnings(f'model = "two-mass"\n{structure}', **values)
    assert any(re.search(message, line) for line in found), found


def test_a_mode_that_does_not_touch_the_contacts_is_named(tmp_path):
    stiffness = np.diag([1.0, 2.89, 40.0])
    stiffness[1, 2] = stiffness[2, 1] = -2.89
    rom.Structure(np.diag([1.0, 1.0, 0.01]), stiffness, 0.01, contact=(2,)).save(
        tmp_path / "apart.npz"
    )
    (found,) = warnings('matrices = "apart.npz"', tmp_path)
    assert found.startswith("mode A does not move the contacts")
