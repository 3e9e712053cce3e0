"""Runs, curves, FMUs and studies of bladed disks, against waves and all sectors in full."""

from dataclasses import replace

import numpy as np
import pytest
from cyclic.full_annulus import law_of_all

from slipmode import rom, runner
from slipmode.rom import full
from slipmode.runner.curves.scene_curves import scene_backbone, scene_response_curve
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.scene.scene import parse_scene, shipped_scenes
from slipmode.runner.study.study import run_study

DISK = shipped_scenes()["bladed-disk"].read_text(encoding="utf-8")
DISK_24, LAW = rom.lumped_disk(24, 1e-5), rom.Jenkins(1.0, 5e4)
NO_RERUN = "[log]\nrerun = false\n"


def recorded(text, folder, name="scene"):
    scene = replace(parse_scene(text, "."), name=name)
    return runner.run(scene, folder).read().channels


def column(channels, topic, name):
    return channels[topic].column(name)


def test_a_run_through_resonance_is_that_of_all_sectors(tmp_path):
    """24 sectors that speed up, integrated in full."""
    speed = "[[0, 3900], [0.3, 3960]]"
    text = DISK.replace("[[0, 3780], [4, 4040]]", speed).replace(
        "duration = 4.0", "duration = 0.3"
    )
    text = text.replace("step = 0.01", "step = 0.002").replace("[1.5, 1.55]", "[0.2, 0.3]")
    channels = recorded(text + NO_RERUN, tmp_path)
    times = channels["/elastic"].time
    scene = parse_scene(text, ".")
    (start, end), annulus = scene.forcing["A"].frequency.values, DISK_24.annulus()
    pattern = DISK_24.around(4.0 * np.eye(3)[2].astype(complex), 3)
    excited = full.Excitation(
        patterns=np.array((pattern.real, -pattern.imag)),
        start=np.zeros(1),
        amplitude=np.ones((1, 2)),
        amplitude_rate=np.zeros((1, 2)),
        frequency=np.full((1, 2), start),
        frequency_rate=np.full((1, 2), (end - start) / 0.3),
        phase=np.array([[0.0, -0.5 * np.pi]]),
        phase_rate=np.zeros((1, 2)),
    )
    law = law_of_all(DISK_24, LAW)
    motion = full.integrate(annulus, law, excited, times, steps_per_period=256)
    pairs = {
        "tip": (column(channels, "/elastic", "x_2"), motion.displacement[:, 2], 6e-3),  # 4.1e-3
        "contact": (column(channels, "/contact/0", "x"), motion.contact_displacement[:, 0], 6e-3),
        "force": (column(channels, "/contact/0", "f"), motion.contact_force[:, 0], 1e-2),
    }
    for quantity, (found, expected, bound) in pairs.items():
        error = np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))
        assert error < bound, quantity


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
values = [3850, 3900]
[[vary]]
key = "contacts.0.limit"
values = [0.5, 1.0]
[outputs]
steady = true
dofs = [2]
"""


def test_a_study_varies_rotor_speed_and_limits(tmp_path):
    (tmp_path / "disk.toml").write_text(DISK, encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    data = run_study(tmp_path / "study.toml", tmp_path).dataset().load()
    assert data["status"].values.tolist() == [1, 1, 1, 1]
    for k in range(4):
        rpm, limit = (float(data[key][k]) for key in ("forcing.A.rotor_speed", "contacts.0.limit"))
        wave = rom.travelling_wave(DISK_24, rom.Jenkins(limit, 5e4), 3)
        (state,) = wave.steady_states(3 * rpm * np.pi / 30.0, {2: 4.0})
        assert float(data["steady"][k, 0]) == pytest.approx(abs(state.amplitude), rel=2e-3)
