"""Hard cases: amplitudes of 0, decays, communication steps of any length, 1e7 cycles."""

import inspect
import math
import tracemalloc
from decimal import Decimal, getcontext

import numpy as np
import pytest

from benchmarks.cases import two_mode
from slipmode import rom
from slipmode.fmu import Component

FLOW = 1e-6  # tolerance of the slow flow
RANGE = (4.0, 4.0)
OMEGA = 0.98
PERIOD = 2 * math.pi / OMEGA
CYCLES, CYCLES_PER_STEP, STEPS_PER_BATCH = 10_000_000, 10, 10_000
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")


# Amplitudes of 0


@pytest.fixture(scope="module")
def model():
    return rom.tabulate(rom.reduce(rom.two_mass()), two_mode().law, RANGE, 1e-2)


def test_modes_at_rest_feel_no_friction(model):
    axis = np.linspace(0.0, 4.0, 101)
    rest = np.zeros_like(axis)
    assert np.all(model.table(np.column_stack((axis, rest)))[:, 1] == 0.0)
    assert np.all(model.table(np.column_stack((rest, axis)))[:, 0] == 0.0)


def test_there_is_no_motion_without_force(model):
    component = Component(model)
    component.do_step(0.0, 1000.0)
    outputs = component.outputs()
    assert [outputs[f"{mode}_{part}"] for mode in "AB" for part in ("re", "im")] == 4 * [0.0]


def test_a_decay_below_the_smallest_double_ends_at_the_absolute_tolerance(model):
    """A step may err by its tolerance times |a| + 1e-3 of the range (dopri5.c, error_of)."""
    component = Component(model, tolerance=FLOW)
    component.reset(amplitude=(2.0, 1.0))
    component.do_step(0.0, 1e6)
    outputs = component.outputs()
    assert np.hypot(outputs["A_re"], outputs["A_im"]) <= FLOW * 1e-3 * RANGE[0]


# Communication steps


def forced():
    """One mode, far from its steady amplitude."""
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    model = rom.tabulate(reduced, two_mode().law, (5.0,), 1e-2)
    component = Component(model, ({0: 1.0},), tolerance=FLOW)
    component.set_inputs(force_A=0.15, frequency_A=OMEGA)
    component.reset(amplitude=1.5 - 0.7j)
    return component


def run(component, durations):
    given = {"force_A": 0.15, "frequency_A": OMEGA}
    row = [given.get(name, 0.0) for name in component.input_names]
    component.run(durations, np.tile(row, (durations.size, 1)))


@pytest.mark.parametrize(
    ("periods", "step", "other"),
    [(1e-2, 1e-6, 1e-2), (1.0, 1e-3, 1.0), (100.0, 1.0, 100.0), (1e4, 1e4, 1.0)],
)
def test_the_communication_step_does_not_change_the_amplitude(periods, step, other):
    """All in periods."""
    found = []
    for each in (step, other):
        component = forced()
        run(component, np.full(round(periods / each), each * PERIOD))
        outputs = component.outputs()
        found.append(complex(outputs["A_re"], outputs["A_im"]))
    assert abs(found[0] - found[1]) <= FLOW * abs(found[1])


def memory_of_component():
    """Return the bytes that the component holds: other tests may have left threads."""
    own = tracemalloc.Filter(True, inspect.getfile(Component))
    traces = tracemalloc.take_snapshot().filter_traces([own]).traces
    return sum(each.size for each in traces)


@pytest.fixture(scope="module")
def ten_million_cycles():
    """Phase error [rad] and growth of memory after the first batch [bytes]."""
    getcontext().prec = 50
    component = forced()
    step = CYCLES_PER_STEP * PERIOD
    durations = np.full(STEPS_PER_BATCH, step)
    batches = CYCLES // (CYCLES_PER_STEP * STEPS_PER_BATCH)
    tracemalloc.start()
    run(component, durations)
    first = memory_of_component()
    for _ in range(batches - 1):
        run(component, durations)
    later = memory_of_component()
    tracemalloc.stop()
    # from the very doubles of the component's inputs, so that only its own rounding counts
    turned = Decimal(OMEGA) * Decimal(step) * (STEPS_PER_BATCH * batches)
    difference = component.outputs()["theta_A"] - float(turned % (2 * PI))
    return abs(math.remainder(difference, 2 * math.pi)), later - first


@pytest.mark.slow
def test_the_phase_does_not_drift(ten_million_cycles):
    assert ten_million_cycles[0] <= 1e-6


@pytest.mark.slow
def test_memory_does_not_grow(ten_million_cycles):
    """A leak is at least 8 bytes a step; the interpreter allocates some 1e4 bytes once."""
    assert ten_million_cycles[1] <= 0.1 * CYCLES / CYCLES_PER_STEP
