"""slipmode validate: a scene by slow time and by full-order integration."""

import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom.full.convergence import relative_rms
from slipmode.runner import (
    Validation,
    load_scene,
    make_plan,
    parse_scene,
    read,
    shipped_scenes,
    validate,
)
from slipmode.runner.scene.sections import Window
from slipmode.runner.validation import validate as validation
from slipmode.runner.view.phase_portraits import portraits

# relative errors as measured, with a tenth to spare
BOUNDS = {
    "two-mode": {
        "modal displacement": 9e-4,
        "contact displacement": 1.2e-3,
        "contact velocity": 1.9e-2,
        "friction force": 6e-4,
        "energy dissipated by friction": 1.3e-3,
    },
    "one-mode": {"modal displacement": 1.2e-4, "energy dissipated by friction": 7e-5},
}
ON_COORDINATES = {
    "modal displacement": 1.42e-4,
    "contact displacement": 2.35e-4,
    "friction force": 2.02e-4,
    "energy dissipated by friction": 2.6e-5,
}


@pytest.mark.parametrize("name", BOUNDS)
def test_shipped_scenes_agree_with_full_order(name, tmp_path):
    text = load_scene(name).text
    if name == "one-mode":  # its table at the default of 1e-3 is good to 3.8e-4
        text += "\n[model]\ntolerance = 1e-4\n"
    found = validate(parse_scene(text, "."), tmp_path)
    errors = {line.subject: line for line in found.comparisons}
    for subject, bound in BOUNDS[name].items():
        assert errors[subject].error < bound, subject
        # of half as many steps: that of the reference is a quarter of it, or less
        assert errors[subject].reference_error < 0.4 * bound, subject


def test_the_times_that_are_compared_are_said_and_recorded(tmp_path, capsys):
    assert main(["validate", "one-mode", "-o", str(tmp_path)]) == 0
    line = capsys.readouterr().out.splitlines()[0]
    start, end = load_scene("one-mode").contact[0].start, load_scene("one-mode").contact[0].end
    assert line == f"compared: slow time and full order, t = {start:g} to {end:g} s"
    recording = read(tmp_path / "one-mode.validation.mcap")
    assert line in [event.message for event in recording.events]


def test_without_a_window_the_last_periods_are_compared(tmp_path):
    text = SCENE.format(structure='model = "two-mass"', limit=2.0, frequency=1.66)
    found = validate(parse_scene(text, "."), tmp_path)
    (window,) = found.windows
    assert window.end == 200.0
    assert window.start == pytest.approx(200.0 - 20 * 2 * np.pi / 0.99, rel=0.02)
    assert f"t = {window.start:g} to 200 s" in found.compared()


def test_a_scene_without_a_table_is_compared_on_its_reduced_coordinates(tmp_path, capsys):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    (tmp_path / "none.toml").write_text(f'{text}\n[model]\ntable = "none"\n', encoding="utf-8")
    found = validate(tmp_path / "none.toml", tmp_path)
    errors = {line.subject: line.error for line in found.comparisons}
    # measured, with a tenth to spare: all coordinates of two masses are reduced ones
    for subject, bound in ON_COORDINATES.items():
        assert errors[subject] < bound, subject
    assert found.reduced == "reduced coordinates"
    recording = read(tmp_path / "none.validation.mcap")
    assert found.compared() in [event.message for event in recording.events]
    assert {"/contact/0", "/full/contact/0"} <= recording.channels.keys()


def test_both_motions_are_in_one_recording(tmp_path):
    found = validate("one-mode", tmp_path)
    recording = read(next(path for path in found.recordings if path.suffix == ".mcap"))
    for contact in range(2):
        _, time, ours = recording.channels[f"/contact/{contact}"]
        _, full_time, full = recording.channels[f"/full/contact/{contact}"]
        np.testing.assert_array_equal(time, full_time)
    assert not np.array_equal(ours, full)


SCENE = """
title = "strained"
[structure]
{structure}
[friction]
law = "tanh"
limit = {limit}
alpha = 0.02
[modes]
A = 0
B = 1
[forcing.A]
dof = 0
amplitude = 0.05
frequency = 0.99
[forcing.B]
dof = 1
amplitude = 0.05
frequency = {frequency}
[run]
duration = 200.0
step = 1.0
"""


def warnings(structure, folder=".", limit=2.0, frequency=1.66):
    text = SCENE.format(structure=structure, limit=limit, frequency=frequency)
    decisions = make_plan(parse_scene(text, folder)).decisions
    return [f"{d.subject} {d.choice}: {d.reason}" for d in decisions if d.level == "warning"]


def test_a_sound_scene_has_no_warning():
    assert warnings('model = "two-mass"') == []
    assert all(d.level == "info" for d in make_plan(load_scene("two-mode")).decisions)


def test_modes_that_are_not_separated_are_named_with_their_distance():
    found = warnings('model = "two-mass"\nk2 = 1.1', frequency=1.06)
    assert [line.split(":")[0] for line in found] == [
        f"mode {m} is close to another mode" for m in "AB"
    ]
    assert "4.9 %" in found[0]  # sqrt(1.1) - 1


def test_a_mode_that_does_not_touch_the_contacts_is_named(tmp_path):
    stiffness = np.diag([1.0, 2.89, 40.0])
    stiffness[1, 2] = stiffness[2, 1] = -2.89
    rom.Structure(np.diag([1.0, 1.0, 0.01]), stiffness, 0.01, contact=(2,)).save(
        tmp_path / "apart.npz"
    )
    (found,) = warnings('matrices = "apart.npz"', tmp_path)
    assert found.startswith("mode A does not move the contacts")


def test_contact_motion_that_is_not_small_is_measured():
    found = warnings('model = "two-mass"\nk_c1 = 1.5', limit=0.05)
    assert found[0].startswith(
        "mode A is strongly perturbed: contact motion changes the modal stiffness by 52 %, "
    )
    assert [line.split(":")[0] for line in found[1:]] == ["contact stiffness is low"]


def test_contacts_that_are_soft_against_the_modes_are_measured():
    found = warnings('model = "two-mass"\nk_c1 = 2.5\nk_c2 = 5\nk_p = 0.6')
    assert any(
        re.search("stiffness is low: .* reduces the contact stiffness by 5. %", line)
        for line in found
    )


SHARED = (
    SCENE.format(structure='model = "two-mass"', limit=2.0, frequency=1.65)
    .replace(
        "dof = 0\namplitude = 0.05\nfrequency = 0.99",
        "dof = 0\namplitude = 0.15\nfrequency = 0.98",
    )
    .replace("dof = 1\namplitude = 0.05", "vector = [-0.1, 0.25, 0.0, 0.0]\namplitude = {}")
)


def test_a_force_on_both_modes_that_jumps(tmp_path):
    """The modes go on as they were, and contacts that stick leave nothing but that."""
    text = SHARED.format("[[0.0, 0.3], [50.0, 0.3], [50.0, 1.0]]")
    scene = parse_scene(text.replace("limit = 2.0", "limit = 1e9"), ".")
    (warning,) = make_plan(scene).warnings
    assert warning.startswith("friction does not act: ")
    found = validate(scene, tmp_path)
    errors = {line.subject: line.error for line in found.comparisons}
    # measured 2.8e-4; without what the force of B leaves of mode A 8.1e-3
    assert errors["modal displacement"] < 3.2e-4


def test_from_rest_under_a_force_on_both_modes(tmp_path):
    found = validate(parse_scene(SHARED.format("1.0"), "."), tmp_path)
    errors = {line.subject: line.error for line in found.comparisons}
    # measured 0.65 %, 1.00 %; with amplitudes that begin at 0: 1.06 %, 1.41 %
    assert errors["modal displacement"] < 7.3e-3
    assert errors["contact displacement"] < 1.13e-2


def test_both_motions_are_shown_side_by_side(tmp_path):
    found = validate("one-mode", tmp_path)
    recorded = read(next(path for path in found.recordings if path.suffix == ".mcap"))
    shown = [each.entity for each in portraits([s.channel for s in recorded.channels.values()])]
    assert shown == [
        "/trajectory",
        *(f"/loop{full}/contact/{number}" for full in ("", "/full") for number in range(2)),
    ]
    said = [event.message for event in recorded.events]
    (line,) = [each for each in found.comparisons if each.subject == "friction force"]
    assert f"friction force: {100 * line.error:.2g} % from full order" in said


@pytest.fixture
def meshed(tmp_path):
    """A clamped bar of 120 masses with two elastic contacts, its first mode forced."""
    n = 120
    stiffness = scipy.sparse.diags_array(
        [np.full(n - 1, -400.0), np.append(np.full(n - 1, 800.0), 400.0), np.full(n - 1, -400.0)],
        offsets=[-1, 0, 1],
    )
    mass = scipy.sparse.diags_array(np.full(n, 0.05))
    rom.Structure(mass, stiffness, 0.01, contact=(60, 100)).save(tmp_path / "bar.npz")
    law = rom.Jenkins(limit=0.04, stiffness=4.0)
    omega = rom.reduce(rom.load_structure(tmp_path / "bar.npz"), (0,), law=law).frequency[0]
    text = f"""
title = "bar"
[structure]
matrices = "bar.npz"
[[contacts]]
law = "jenkins"
limit = 0.04
stiffness = 4.0
[modes]
A = 0
[forcing.A]
dof = 119
amplitude = 0.04
frequency = {0.98 * omega}
[run]
duration = 200.0
step = 2.0
[[contact]]
window = [180.0, 200.0]
"""
    return make_plan(parse_scene(text, tmp_path))


def test_large_structures_run_on_component_modes_and_say_what_that_changes(meshed, monkeypatch):
    """The statement covers what is found against all modes of the same structure."""
    times = np.linspace(180.0, 200.0, 400)
    exact = validation.reference(meshed, times)
    assert exact.coordinates == 120
    assert len(exact.comparisons) == 1
    monkeypatch.setattr(validation, "MOST_DOFS", 100)
    found = validation.reference(meshed, times)
    assert found.coordinates < 40
    assert np.ptp(found.motion.contact_force, axis=0).max() == pytest.approx(0.08)  # slips
    for signal in ("displacement", "velocity", "contact_displacement", "contact_force"):
        apart, *stated = (
            relative_rms(getattr(one, signal), getattr(other, signal)).max()
            for one, other in ((found.motion, exact.motion), *found.comparisons)
        )
        assert apart <= sum(stated), signal
        assert 0.0 < stated[1] < 0.05, signal
    np.testing.assert_array_equal(found.motion.time, exact.motion.time)


def test_a_validation_adds_the_errors_of_both_comparisons(meshed, monkeypatch, tmp_path):
    monkeypatch.setattr(validation, "MOST_DOFS", 100)
    found = validate(meshed.scene, tmp_path)
    assert found.coordinates < 40
    window = found.comparisons[0]
    assert window.subject == "modal displacement"
    assert window.error < 0.02
    full = validation.reference(meshed, np.linspace(180.0, 200.0, 400))
    errors = [relative_rms(a.displacement, b.displacement).max() for a, b in full.comparisons]
    assert window.reference_error == pytest.approx(sum(errors), rel=0.2)


def test_a_window_that_the_scene_integrates_at_full_order_is_named():
    window = Window(start=60.0, end=62.0, samples_per_period=64)
    found = Validation([], 0.0, 0.0, 0.0, [], 1, (window,), "slow time", ((0.0, 63.52),))
    assert "integrates 0 to 63.52 s at full order, so that slow time is not" in found.compared()
    later = replace(found, full_order=((0.0, 59.0),))
    assert later.compared() == "compared: slow time and full order, t = 60 to 62 s"
