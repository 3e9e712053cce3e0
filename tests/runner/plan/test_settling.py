"""What a dry run leaves out of long scenes, and that nothing new happens in it."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from stepping import model

from slipmode import runner
from slipmode.fmu import Component
from slipmode.runner import parse_scene
from slipmode.runner.plan import amplitude_range
from slipmode.runner.plan.amplitude_range import shortened
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.script import Script

SCENE = """
title = "A long scene"
[structure]
model = "two-mass"
damping = {damping}
[friction]
law = "tanh"
limit = 2.0
alpha = 0.1
[modes]
A = 0
B = 1
[forcing.A]
dof = 0
amplitude = {force}
frequency = {frequency_A}
phase = {phase}
[forcing.B]
dof = 1
amplitude = 0.25
frequency = {frequency_B}
[run]
duration = {duration}
step = 1.0
[log]
mcap = false
rerun = false
"""
HELD = {
    "damping": 0.05,
    "force": 0.15,
    "frequency_A": 0.98,
    "frequency_B": 1.65,
    "phase": 0.0,
    "duration": 1e5,
}


def scene(**changes):
    return parse_scene(SCENE.format(**HELD | changes), ".")


def dry_run(plan):
    """Last and largest amplitudes on a table of the scene's range, and how long it is followed."""
    excited, model = plan.excited, plan.model()[0]
    component = excited.component(model, 1e-8)
    stretches = amplitude_range.shortened(
        plan.schedule, model, excited.modes, component.input_names
    )
    *_, outputs = component.trace(stretches.durations, stretches.inputs)
    last = np.abs(outputs[-1, 1:5].view(complex))
    reached, _, complete = amplitude_range._path(excited, model, plan.schedule)
    assert complete
    return last, reached, stretches.durations.sum()


def whole(schedule, model, modes, names):
    lengths, inputs = schedule.stretches().durations(), schedule.stretches().inputs(names)
    return amplitude_range.Stretches(lengths, inputs, lengths, names)


EVENTS = {
    "held": {},
    "step": {"force": "[[0, 0.02], [5e4, 0.02], [5e4, 0.15]]"},
    "ramp": {"force": "[[0, 0.0], [1e5, 0.15]]"},
    "sweep": {"frequency_A": "[[0, 0.9], [1e5, 1.1]]"},
    "both sweep": {
        "frequency_A": "[[0, 1.02], [1e5, 0.94]]",
        "frequency_B": "[[0, 1.6], [1e5, 1.75]]",
    },
    "phase": {"phase": "[[0, 0.0], [1e5, 6.0]]"},
    "beat": {"frequency_A": 0.99, "frequency_B": 1.6502},
}


@pytest.mark.parametrize("events", EVENTS.values(), ids=EVENTS)
def test_nothing_new_happens_in_what_is_left_out(events, monkeypatch):
    plan = runner.make_plan(scene(**events))
    last, reached, followed = dry_run(plan)
    assert followed < 0.5 * plan.schedule.duration
    monkeypatch.setattr(amplitude_range, "shortened", whole)
    expected, most, _ = dry_run(plan)
    # ramps lag behind by a fiftieth of their height; the margin of the table is 0.15
    np.testing.assert_allclose(reached, most, rtol=2e-2)
    np.testing.assert_allclose(last, expected, rtol=2e-2)


# Near 5 Omega_A = 3 Omega_B, damping 0.01 and 0.0289: the decay time is 200 s.
MOVING = {
    "a short scene": (3000.0, {"force_A": [[0, 0.1], [1500, 0.1], [1500, 0.2]]}),
    "a wide sweep": (1e5, {"frequency_A": [[0, 0.9], [1e5, 1.1]]}),
    "a turning phase": (1e5, {"phase_A": [[0, 0.0], [1e5, 20.0]]}),
    "a slow beat": (1e5, {"frequency_A": [[0, 0.99]], "frequency_B": [[0, 1.65002]]}),
}
NAMES = [
    f"{q}{rate}_{m}"
    for m in "AB"
    for q in ("force", "frequency", "phase")
    for rate in ("", "_rate")
]


def schedule(duration, breakpoints):
    scripts = {"frequency_A": [[0, 1.0]], "frequency_B": [[0, 1.7]]} | breakpoints
    for name in ("force_A", "force_B", "phase_A", "phase_B"):
        scripts.setdefault(name, [[0, 0.0]])
    scripts = {name: Script.through(points) for name, points in scripts.items()}
    return Schedule(scripts, duration, 1.0)


@pytest.mark.parametrize("moving", MOVING.values(), ids=MOVING)
def test_what_has_not_settled_is_followed_to_the_bit(moving):
    given = schedule(*moving)
    found = shortened(given, model(), "AB", NAMES)
    np.testing.assert_array_equal(found.durations, given.stretches().durations())
    np.testing.assert_array_equal(found.inputs, given.stretches().inputs(NAMES))


def test_without_damping_nothing_is_taken_as_settled():
    of = model()
    undamped = replace(of, reduced=replace(of.reduced, modal_damping=np.zeros(2)))
    assert shortened(schedule(1e9, {}), undamped, "AB", NAMES).durations == [1e9]
    assert shortened(schedule(1e9, {}), of, "AB", NAMES).durations < 1e5


def test_a_ramp_that_is_shortened_goes_as_far():
    given = schedule(
        1e9, {"force_A": [[0, 0.1], [4e8, 0.3]], "frequency_A": [[4e8, 1], [1e9, 1.1]]}
    )
    found = shortened(given, model(), "AB", NAMES)
    durations, inputs = found.durations, found.inputs
    straight = given.stretches()
    assert np.all(durations < 0.01 * straight.durations())
    values = [name for name in NAMES if "_rate_" not in name]
    rates = inputs[:, [NAMES.index(name.replace("_", "_rate_")) for name in values]]
    starts = inputs[:, [NAMES.index(name) for name in values]]
    ends = starts + rates * durations[:, np.newaxis]
    np.testing.assert_allclose(ends, straight.at_ends(values), rtol=1e-12)
    np.testing.assert_array_equal(starts, straight.inputs(values))


LONG = {
    "held": {},
    "sweep": {"frequency_A": "[[0, 0.94], [{duration}, 1.02]]"},
    "steps": {"force": str([[100.0 * k, 0.1 + 0.05 * (k % 2)] for k in range(100)])},
}


@pytest.mark.parametrize("events", LONG.values(), ids=LONG)
def test_a_plan_costs_no_more_for_more_steps(events, monkeypatch):
    """Internal steps of the dry run, and memory of the whole plan."""
    points = []
    real = Component.trace

    def counted(*arguments):
        for outputs in real(*arguments):
            points[-1] += len(outputs)
            yield outputs

    monkeypatch.setattr(Component, "trace", counted)

    def cost(duration):
        points.append(0)
        text = {name: str(value).format(duration=duration) for name, value in events.items()}
        tracemalloc.start()
        assert runner.make_plan(scene(duration=duration, **text)).schedule.steps == duration
        used = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return points[-1], used

    cost(10**5)  # what is imported and cached once
    short, long = cost(10**5), cost(10**7)
    assert short[0] > 0
    assert long[0] <= 1.2 * short[0]
    assert long[1] <= 1.2 * short[1]
