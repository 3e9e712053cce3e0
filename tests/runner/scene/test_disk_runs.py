"""Runs, curves, FMUs and studies of bladed disks, against waves and all sectors in full."""

from dataclasses import replace

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.rom import SlipmodeError
from slipmode.runner import (
    export_fmu,
    parse_scene,
    run_study,
    scene_backbone,
    scene_response_curve,
    shipped_scenes,
    validate,
)

DISK = shipped_scenes()["bladed-disk"].read_text(encoding="utf-8")
DISK_24, LAW = rom.lumped_disk(24, 1e-5), rom.Jenkins(1.0, 5e4)
NO_RERUN = "[log]\nrerun = false\n"
RANGE = "[model]\ntolerance = 0.05\namplitude = [2e-4, 4e-5]\n"
SECOND_WAVE = """[forcing.B]
dof = 2
amplitude = 20.0
engine_order = 19
rotor_speed = 1957
"""


def recorded(text, folder, name="scene"):
    scene = replace(parse_scene(text, "."), name=name)
    return runner.run(scene, folder).read().channels


def column(channels, topic, name):
    return channels[topic].column(name)


SHORT = (
    DISK.replace("[[0, 3780], [4, 4040]]", "[[0, 3900], [0.3, 3960]]")
    .replace("duration = 4.0", "duration = 0.3")
    .replace("step = 0.01", "step = 0.002")
    .replace("[1.5, 1.55]", "[0.2, 0.3]")
)
BACKWARD = SHORT.replace("order = 3", "order = 21").replace(
    "[[0, 3900], [0.3, 3960]]", "[[0, 557.2], [0.3, 565.7]]"
)


@pytest.mark.parametrize(
    "text", [SHORT, f"{BACKWARD}[initial]\nA = [0.0, 6e-5]\n"], ids=["forward", "backward"]
)
def test_a_run_through_resonance_is_that_of_all_sectors(text, tmp_path):
    """24 sectors that speed up, integrated in full."""
    found = validate(parse_scene(text + NO_RERUN, "."), tmp_path)
    assert found.coordinates == 72
    subjects = ("modal displacement", "contact displacement", "contact velocity", "friction force")
    assert tuple(each.subject for each in found.comparisons) == subjects
    for each in found.comparisons:
        # measured 3.8e-3 to 6.2e-3 from rest: the amplitude grows while contacts slip
        assert each.error < 8e-3, each.subject
        assert each.reference_error < 5e-4, each.subject


GROUPS = """[[contacts]]
law = "jenkins"
contacts = [0]
limit = 1.0
stiffness = 5.0e4

[[contacts]]
law = "jenkins"
contacts = [1]
limit = 0.5
stiffness = 2.0e4

[modes]"""


def test_contacts_of_different_laws_in_a_file_of_one_sector(tmp_path):
    """Tips of neighbours touch, and the middle of each blade touches the ground."""
    contact = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
    np.savez(
        tmp_path / "sector.npz",
        mass=np.diag([0.6, 0.35, 0.25, 0.6]),
        stiffness=DISK_24.stiffness.toarray(),
        contact=contact,
        labels=[[11, 3], [12, 3], [13, 3], [21, 3]],
    )
    first, second = SHORT.index("[[contacts]]"), SHORT.index("[modes]")
    text = (SHORT[:first] + GROUPS + SHORT[second + len("[modes]") :]).replace(
        'model = "lumped-disk"',
        'matrices = "sector.npz"\ninterface = [[11, 21]]\nnext_contacts = [[0, 13, "z"]]',
    )
    found = validate(parse_scene(text + NO_RERUN, tmp_path), tmp_path)
    for each in found.comparisons:
        assert each.error < 8e-3, each.subject  # measured 1.6e-3 to 4.9e-3


def test_validation_takes_one_engine_order(tmp_path):
    text = SHORT.replace("A = 0", "A = 0\nB = 1") + RANGE + SECOND_WAVE
    with pytest.raises(SlipmodeError, match=r"^forcing\.B: must be left out, or"):
        validate(parse_scene(text, "."), tmp_path)


@pytest.mark.slow
def test_two_engine_orders_come_to_the_steady_state_of_their_waves(tmp_path):
    text = DISK.replace("A = 0", "A = 0\nB = 1").replace("[[0, 3780], [4, 4040]]", "3900")
    text = text.replace("duration = 4.0", "duration = 1.0").replace("[1.5, 1.55]", "[0.95, 0.96]")
    scene = parse_scene(text + RANGE + SECOND_WAVE + NO_RERUN, ".")
    recording = runner.run(scene, tmp_path)
    channels = recording.read().channels
    sizes = [column(channels, "/modes", f"{mode}_abs")[-1] for mode in "AB"]
    frequency = [3 * 3900 * np.pi / 30.0, 19 * 1957 * np.pi / 30.0]
    force = [np.array([0.0, 0.0, each]) for each in (4.0, 20.0)]
    expected = np.abs(rom.steady(recording.model, frequency, force))
    np.testing.assert_allclose(sizes, expected, rtol=1e-3)
    # sectors 8 apart have the same phase of nodal diameter 3, another of -5
    assert channels["/disk"].values.shape == (398, 48)  # the whole window
    first, ninth = (channels["/disk"].column(f"x_{j}") for j in (0, 8))
    apart = np.sqrt(np.mean((first - ninth) ** 2) / np.mean(first**2))
    assert 0.01 < apart < 1.0


def test_curve_and_backbone_are_those_of_the_wave():
    scene = parse_scene(DISK, ".")
    wave = rom.travelling_wave(DISK_24, LAW, 3)
    curve = scene_response_curve(scene)
    at = int(np.argmax(np.abs(curve.amplitude[:, 0])))
    (state,) = wave.steady_states(curve.parameter[at], {2: 4.0})
    assert abs(curve.amplitude[at, 0]) == pytest.approx(abs(state.amplitude), rel=1e-3)
    backbone = scene_backbone(scene)
    assert backbone.frequency.max() == pytest.approx(wave.frequency, rel=1e-6)


def test_an_fmu_does_the_same_steps(tmp_path):
    scene = replace(parse_scene(DISK + NO_RERUN, "."), name="disk")
    path = export_fmu(scene, tmp_path / "disk.fmu", headroom=1.0)
    alone = runner.run(scene, tmp_path / "alone").read().channels
    driven = runner.run(scene, tmp_path / "driven", fmu=path).read().channels
    for topic in ("/modes", "/contact/0", "/elastic"):
        np.testing.assert_array_equal(alone[topic].values, driven[topic].values)


def test_a_decay_needs_no_engine_order(tmp_path):
    """From an amplitude at which contacts stick: |a| falls with the modal damping."""
    wave = rom.travelling_wave(DISK_24, LAW, -4)
    text = f"""
[structure]
model = "lumped-disk"
damping = 1e-5
[[contacts]]
law = "jenkins"
limit = 1.0
stiffness = 5.0e4
[modes]
A = 0
nodal_diameters = [-4]
[initial]
A = [4e-6, 0.0]
[run]
duration = 0.5
step = 0.01
{NO_RERUN}"""
    size = column(recorded(text, tmp_path), "/modes", "A_abs")
    damping = wave.wave.own.damping[0, 0].real
    time = np.linspace(0.0, 0.5, size.size)
    np.testing.assert_allclose(size, 4e-6 * np.exp(-0.5 * damping * time), rtol=1e-3)


STUDY = """
scene = "disk.toml"
[[vary]]
key = "forcing.A.rotor_speed"
values = [3850, 3900, 3950]
[[vary]]
key = "contacts.0.limit"
values = [0.5]
[outputs]
steady = true
dofs = [2]
"""


@pytest.mark.slow
def test_a_study_varies_rotor_speed_and_limits(tmp_path):
    (tmp_path / "disk.toml").write_text(DISK, encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    data = run_study(tmp_path / "study.toml", tmp_path).dataset().load()
    assert data["status"].values.tolist() == [1, 1, 1]
    for k in range(3):
        rpm, limit = (float(data[key][k]) for key in ("forcing.A.rotor_speed", "contacts.0.limit"))
        wave = rom.travelling_wave(DISK_24, rom.Jenkins(limit, 5e4), 3)
        (state,) = wave.steady_states(3 * rpm * np.pi / 30.0, {2: 4.0})
        assert float(data["steady"][k, 0]) == pytest.approx(abs(state.amplitude), rel=2e-3)
