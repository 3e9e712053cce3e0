"""All sectors of a bladed disk: recorded, and drawn as a ring."""

import subprocess

import numpy as np
import pytest
from rrd import RERUN

from slipmode.runner import load, replay
from slipmode.runner.recording.load import Selection
from slipmode.runner.view.spatial import disk_view

SECTORS = 24


@pytest.fixture(scope="module")
def recorded(shipped_scene):
    return load(shipped_scene("bladed-disk").mcap)


def test_sectors_move_one_after_the_other(recorded):
    """Nodal diameter 3: sector j is ahead of sector 0 by j eighths of a period."""
    disk, elastic = recorded["/disk"], recorded["/elastic"]
    first = disk.column("x_0")
    same = np.interp(disk.time, elastic.time, elastic.column("x_2"))
    np.testing.assert_allclose(first, same, atol=1e-6 * np.abs(first).max())
    for j in range(1, SECTORS):
        # measured within 1.5e-3: the window has 7.8 periods
        ahead = np.corrcoef(first, disk.column(f"x_{j}"))[0, 1]
        assert ahead == pytest.approx(np.cos(2.0 * np.pi * 3 * j / SECTORS), abs=5e-3)
    np.testing.assert_allclose(disk.column("x_8"), first, rtol=1e-9, atol=1e-12)


def test_contact_states_go_round(recorded):
    disk, contact = recorded["/disk"], recorded["/contact/0"]
    states = np.stack([disk.column(f"state_{j}") for j in range(SECTORS)])
    own = contact.column("state")[np.searchsorted(contact.time, disk.time)]
    np.testing.assert_array_equal(states[0], own)
    assert {0.0, 1.0} == set(states.ravel())
    # at each instant some contacts stick and others slip
    assert (np.ptp(states, axis=0) > 0).mean() > 0.5
    np.testing.assert_array_equal(states[:8], states[8:16])


def test_blades_are_drawn_outwards():
    moved = np.array([[0.0, 2.0, 0.0, -2.0]])
    places = disk_view.ring(moved)[0]
    # counter-clockwise from the right; the second coordinate points down
    np.testing.assert_allclose(places, [[1, 0], [0, -1.3], [-1, 0], [0, 0.7]], atol=1e-12)


@pytest.mark.parametrize("scene", ["bladed-disk", "mistuned-disk"])
def test_replay_draws_the_disk_only_with_its_samples(scene, shipped_scene, tmp_path):
    out = tmp_path / "out.rrd"
    for selection, drawn in ((Selection(), True), (Selection(end=1.0), False)):
        replay(shipped_scene(scene).mcap, save=out, selection=selection)
        show = [RERUN, "rrd", "print", "-vvv", out]
        text = subprocess.run(show, capture_output=True, check=True, text=True).stdout
        for entity in ("/disk/blades", "/disk/contacts", "/disk/labels"):
            assert (entity in text) == drawn
