"""Scenes with several modes on one tone: their motion, recordings and refusals."""

import numpy as np
import pytest
from beside_oracle import relative_rms
from oracles.system import System, Tone, jenkins
from oracles.time_integration import steady_harmonics
from rrd import verified
from scene_motion import Force, integrated

from slipmode import rom, runner

FOLDER = runner.shipped_scenes()["square-plate"].parent
TEXT = (FOLDER / "square-plate.toml").read_text()
HERTZ = 2.0 * np.pi
PLATE, AT = rom.load_structure(FOLDER / "square-plate.npz"), np.eye(36)
MATRICES = (each.toarray() for each in (PLATE.mass, PLATE.damping, PLATE.stiffness))
SYSTEM = System(*MATRICES, AT[:, [10]], [jenkins(0.8, 1e4)])


SECOND = "[forcing.B]\ndof = 10\namplitude = 3.0\nfrequency = [[0, 544], [0.4, 548]]\n[run]"


@pytest.mark.oracle
@pytest.mark.slow
@pytest.mark.parametrize(("second", "allowed"), [(False, 0.012), (True, 0.045)])
def test_the_motion_of_a_plate_is_the_independent_one(second, allowed, tmp_path):
    """From rest, with a sweep, and steps of amplitude and phase, on one tone and on two."""
    amplitude, phase = [[0, 1], [0.2, 1], [0.2, 0.6]], [[0, 0], [0.3, 0], [0.3, 1]]
    text = TEXT.replace("amplitude = 1.0", f"amplitude = {amplitude}\nphase = {phase}")
    text = text.replace("[8, 288]", "[0.4, 280]")
    text = text.replace("duration = 8.0", "duration = 0.4").replace("3.0, 3.04", "0.3, 0.4")
    sweep = [[0, 268 * HERTZ], [0.4, 280 * HERTZ]]
    later = [[time, angle - 0.5 * np.pi] for time, angle in phase]
    forces = [Force(AT[k].tolist(), amplitude, sweep, p) for k, p in ((13, phase), (8, later))]
    if second:
        text = text.replace("A = [1, 2]", "A = [1, 2]\nB = [4, 5]").replace("[run]", SECOND)
        fast = [[0, 544 * HERTZ], [0.4, 548 * HERTZ]]
        forces.append(Force(AT[10].tolist(), [[0, 3.0]], fast, [[0, 0]]))
    run = runner.run(runner.parse_scene(text, FOLDER), tmp_path)
    data = run.read()
    exact = integrated(SYSTEM, forces, 0.4, 256)
    moved, contact = (data.channels[topic] for topic in ("/elastic", "/contact/0"))
    x, force = exact.at(contact.time)[:, 10], exact.contact_force(contact.time)[:, 0]
    assert relative_rms(moved.values[:, 1], exact.at(moved.time)[:, 13]) < allowed
    assert relative_rms(contact.column("x"), x) < allowed
    assert relative_rms(contact.column("f"), force) < 0.03
    warned = [line for line in run.plan.warnings if "transients have errors of about 5" in line]
    assert len(warned) == second  # motion at combinations of the two frequencies
    energy = data.channels["/energy"]
    spent = np.trapezoid(force, x)
    ends = np.interp(contact.time[[0, -1]], energy.time, energy.column("dissipated_energy"))
    assert np.diff(ends)[0] == pytest.approx(spent, rel=0.015)


def test_the_shipped_plate_keeps_its_numbers(shipped_scene):
    """The peaks of A and A2, and what the damper does between them."""
    shipped = shipped_scene("square-plate")
    data = shipped.read()
    modes, forcing = (data.channels[topic] for topic in ("/modes", "/forcing"))
    peak = [modes.column(f"{name}_abs").argmax() for name in ("A", "A2")]
    found = [modes.column("A_abs").max(), modes.column("A2_abs").max()]
    np.testing.assert_allclose(found, [7.008e-5, 4.789e-5], rtol=2e-3)
    np.testing.assert_allclose(
        forcing.column("A_frequency")[peak] / HERTZ, [273.9, 274.4], atol=0.1
    )
    assert data.channels["/contact_share"].values[0, 1] == pytest.approx(0.60, abs=0.01)
    assert not shipped.plan.warnings and verified(shipped.rrd)
    with pytest.raises(rom.SlipmodeError, match=r"modes: this needs one mode on each tone"):
        runner.make_plan(shipped.plan.scene)


@pytest.mark.oracle
@pytest.mark.slow
def test_the_curve_of_a_plate_is_the_independent_steady_motion():
    """At the peaks of both modes and between them, within the stated error."""
    span = np.array([273.0, 278.0]) * HERTZ
    curve = runner.scene_response_curve(runner.load_scene("square-plate"), None, span)
    for k in {*np.abs(curve.amplitude).argmax(axis=0).tolist(), len(curve.frequency) // 2}:
        tone = Tone(curve.frequency[k], AT[13] - 1j * AT[8])
        exact = steady_harmonics(SYSTEM, [tone], [[1]], steps=512)
        rows = 0.5 * curve.response.reduced.mode_shapes.T @ SYSTEM.M
        error = np.abs(curve.amplitude[k] - rows @ exact.amplitude[0])
        assert np.all(error <= curve.error[k] + np.abs(rows) @ exact.error[0])
    with pytest.raises(rom.SlipmodeError, match="vary = 'force_A': must be 'frequency_A'"):
        runner.scene_response_curve(runner.load_scene("square-plate"), "force_A", (0.5, 1.0))


def test_the_plate_is_compared_with_full_order(tmp_path):
    """Measured: displacement and force 0.1 %, velocity 0.3 % without higher harmonics."""
    text = TEXT.replace("duration = 8.0", "duration = 3.04")
    found = runner.validate(runner.parse_scene(text, FOLDER), tmp_path)
    subjects = [line.subject for line in found.comparisons]
    assert subjects[0] == "modal displacement" and subjects[-1] == "friction force"
    assert all(line.error < 0.005 and line.reference_error < 0.001 for line in found.comparisons)
    recording = runner.read(found.recordings[0])
    assert {"/contact/0", "/full/contact/0"} <= recording.channels.keys()
    two = text.replace("A = [1, 2]", "A = [1, 2]\nB = [4, 5]").replace("[run]", SECOND)
    with pytest.raises(rom.SlipmodeError, match=r"forcing\.A\.quadrature: must be left out"):
        runner.validate(runner.parse_scene(two.replace("ture = 8", "ture = 0"), FOLDER), tmp_path)
