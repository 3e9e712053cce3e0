"""Schedules of scenes: their parts are those of the whole."""

import numpy as np
import pytest

from slipmode.rom.reduction.combination import combination_resonances
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.scene.schedule import make_schedule

MODES = ("A", "B")
NAMES = [f"{quantity}_{mode}" for mode in MODES for quantity in ("force", "frequency", "phase")]


@pytest.fixture(scope="module")
def schedule():
    return make_schedule(load_scene("force-step"), {"A": 1.0, "B": 1.7})


@pytest.mark.parametrize("part", [slice(1), slice(190, 210), slice(-5, None), slice(5, 10**9)])
def test_parts_are_cut_from_the_whole(schedule, part):
    inputs = [*NAMES, "frequency_rate_A"]
    np.testing.assert_array_equal(schedule.inputs(inputs, part), schedule.inputs(inputs)[part])
    np.testing.assert_array_equal(schedule.at_points(NAMES, part), schedule.at_points(NAMES)[part])


def test_largest_force_is_that_of_all_ends_of_steps(schedule):
    start, end = schedule.forces(MODES)
    largest = np.maximum(np.abs(start), np.abs(end)).max(axis=0)
    np.testing.assert_allclose(schedule.largest_force(MODES), largest, rtol=1e-15)
    first = schedule.first_step()
    np.testing.assert_array_equal(first.forces(MODES)[0], start[:1])
    assert largest[0] > 0.0


def test_near_resonances_do_not_depend_on_how_long_a_frequency_is_held():
    path = np.array([[0.98, 1.65], [1.0, 1.66], [1.0, 2.98], [0.98, 1.65]])
    assert combination_resonances(np.repeat(path, 3, axis=0)) == combination_resonances(path) != ()
