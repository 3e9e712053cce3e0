"""Schedules of scenes: their parts are those of the whole."""

import tracemalloc

import numpy as np
import pytest

from slipmode.rom import combination_resonances
from slipmode.runner import load_scene
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.script import Script

pytestmark = pytest.mark.quick

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


def test_points_are_breakpoints_and_the_multiples_of_the_step_that_are_none():
    """On steps that do, nearly do, and do not divide the times of the breakpoints."""
    random = np.random.default_rng(1)
    for step in [0.1, 0.3, 1.0, 7.0, *random.uniform(0.01, 20.0, 30)]:
        combinations = 7 * step + 1e-10 * step
        times = np.unique([0.7, 2.0, combinations, 5 * step, *random.uniform(0.0, 30.0, 3)])
        script = Script(tuple(times.tolist()), tuple(random.uniform(size=times.size).tolist()))
        duration = 20.0
        made = Schedule({"force_A": script}, duration, step)
        fixed = np.array([0.0, *(b for b in script.breaks if b < duration), duration])
        regular = step * np.arange(np.ceil(duration / step))
        apart = np.abs(regular[:, np.newaxis] - fixed).min(axis=1)
        expected = np.sort(np.append(fixed, regular[apart > 1e-9 * step]))
        np.testing.assert_array_equal(made.time(), expected)
        np.testing.assert_array_equal(made.durations(), np.diff(expected))
        assert made.steps == expected.size - 1
        np.testing.assert_array_equal(made.inputs(["force_A"])[:, 0], script.value(expected[:-1]))


def test_extremes_are_those_of_all_ends_of_steps(schedule):
    reached = np.concatenate((schedule.inputs(NAMES), schedule.at_ends(NAMES)))
    least, largest = schedule.extremes(NAMES)
    np.testing.assert_array_equal(least, reached.min(axis=0))
    np.testing.assert_array_equal(largest, reached.max(axis=0))
    force = schedule.inputs([f"force_{mode}" for mode in MODES])
    np.testing.assert_allclose(largest[[0, 3]], force.max(axis=0), rtol=1e-15)
    assert np.all(force.max(axis=0) > 0.0)


def test_mean_frequency_is_weighted_by_the_force():
    force, sweep = Script.through([[0, 0.0], [4, 2.0], [4, 1.0]]), Script.through([[2, 1], [8, 4]])
    scripts = {"force_A": force, "frequency_A": sweep, "phase_A": Script.constant(0.0)}
    made = Schedule(scripts, 10.0, 0.7)
    fine = (np.arange(200_000) + 0.5) * (10.0 / 200_000)
    expected = np.average(sweep.value(fine), weights=force.value(fine))
    assert made.mean_frequency(["A"]) == pytest.approx([expected], rel=1e-9)


@pytest.mark.parametrize("duration", [1.0, 800.0, 1e7])
def test_the_mean_of_a_held_frequency_is_that_frequency(duration):
    scripts = {"force_A": Script.through([[0, 0.1], [800, 0.3]]), "phase_A": Script.constant(0.0)}
    scripts["frequency_A"] = Script.constant(0.9825)
    assert Schedule(scripts, duration, 1.0).mean_frequency(["A"]) == [0.9825]


def test_memory_does_not_grow_with_the_number_of_steps():
    force = Script.through([[10.0 * k, 0.1 + 0.05 * (k % 2)] for k in range(50)])
    scripts = {"force_A": force, "phase_A": Script.constant(0.0)}
    scripts["frequency_A"] = Script.through([[0, 0.94], [1e7, 1.02]])

    def peak(duration):
        tracemalloc.start()
        made = Schedule(scripts, duration, 1.0)
        made.mean_frequency(["A"])
        made.extremes(["force_A", "frequency_A"])
        for first in (0, made.steps // 2, made.steps - 1000):
            made.inputs(["force_A", "frequency_rate_A"], slice(first, first + 1000))
            made.at_points(["phase_A"], slice(first, first + 1001))
        used = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return used

    peak(1e3)  # what is imported and cached once
    assert peak(1e7) < 1.1 * peak(1e5)


def test_combination_resonances_do_not_depend_on_how_long_a_frequency_is_held():
    path = np.array([[0.98, 1.65], [1.0, 1.66], [1.0, 2.98], [0.98, 1.65]])
    assert combination_resonances(np.repeat(path, 3, axis=0)) == combination_resonances(path) != ()


def test_combination_resonances_of_a_sweep_are_those_that_it_passes():
    """From far below to far above: with its ends alone they would be missed."""
    start, end = np.array([[0.9, 1.3]]), np.array([[0.9, 4.0]])
    between = start + np.linspace(0.0, 1.0, 5000)[:, np.newaxis] * (end - start)
    expected = combination_resonances(between)
    assert combination_resonances(start, end) == expected
    assert len(expected) > len(combination_resonances(np.vstack((start, end))))
