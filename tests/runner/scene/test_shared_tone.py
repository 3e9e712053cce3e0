"""Scenes with several modes on one tone: their motion, recordings and refusals."""

import numpy as np
import pytest
from beside_oracle import relative_rms
from oracles.system import System, jenkins
from rrd import verified
from scene_motion import Force, integrated

from slipmode import rom, runner

FOLDER = runner.shipped_scenes()["square-plate"].parent
TEXT = (FOLDER / "square-plate.toml").read_text()
HERTZ = 2.0 * np.pi


@pytest.mark.oracle
@pytest.mark.slow
def test_the_motion_of_a_plate_is_the_independent_one(tmp_path):
    """From rest, with a sweep, and steps of amplitude and phase: within 1.2 %."""
    amplitude, phase = [[0, 1], [0.2, 1], [0.2, 0.6]], [[0, 0], [0.3, 0], [0.3, 1]]
    text = TEXT.replace("amplitude = 1.0", f"amplitude = {amplitude}\nphase = {phase}")
    text = text.replace("[8, 288]", "[0.4, 280]")
    text = text.replace("duration = 8.0", "duration = 0.4").replace("3.0, 3.04", "0.3, 0.4")
    data = runner.run(runner.parse_scene(text, FOLDER), tmp_path).read()
    plate = rom.load_structure(FOLDER / "square-plate.npz")
    matrices, at = (plate.mass, plate.damping, plate.stiffness), np.eye(36)
    system = System(*(each.toarray() for each in matrices), at[:, [10]], [jenkins(0.8, 1e4)])
    sweep = [[0, 268 * HERTZ], [0.4, 280 * HERTZ]]
    exact = integrated(system, [Force(at[13].tolist(), amplitude, sweep, phase)], 0.4, 256)
    moved, contact = (data.channels[topic] for topic in ("/elastic", "/contact/0"))
    assert relative_rms(moved.values[:, 1], exact.at(moved.time)[:, 13]) < 0.012
    assert relative_rms(contact.column("x"), exact.at(contact.time)[:, 10]) < 0.012
    assert relative_rms(contact.column("f"), exact.contact_force(contact.time)[:, 0]) < 0.03


def test_the_shipped_plate_keeps_its_numbers(shipped_scene):
    """The peaks of A and A2, and what the damper does between them."""
    shipped = shipped_scene("square-plate")
    data = shipped.read()
    modes, forcing = (data.channels[topic] for topic in ("/modes", "/forcing"))
    peak = [modes.column(f"{name}_abs").argmax() for name in ("A", "A2")]
    found = [modes.column("A_abs").max(), modes.column("A2_abs").max()]
    np.testing.assert_allclose(found, [6.449e-5, 3.614e-5], rtol=2e-3)
    np.testing.assert_allclose(
        forcing.column("A_frequency")[peak] / HERTZ, [274.2, 277.6], atol=0.1
    )
    assert data.channels["/contact_share"].values[0, 1] == pytest.approx(0.52, abs=0.01)
    assert not shipped.plan.warnings and verified(shipped.rrd)
    with pytest.raises(rom.SlipmodeError, match=r"modes\.A: this needs one mode on each tone"):
        runner.make_plan(shipped.plan.scene)
