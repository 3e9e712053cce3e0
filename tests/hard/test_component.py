"""Hard cases of the component: rest, decays, communication steps of any length, 1e7 cycles."""

import math
from decimal import Decimal, getcontext

import numpy as np
import pytest

from slipmode.fmu import Component

FLOW = 1e-6  # tolerance of the slow flow
OMEGA = 0.98
PERIOD = 2 * math.pi / OMEGA
CYCLES, CYCLES_PER_STEP, STEPS_PER_BATCH = 10_000_000, 10, 10_000
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")


def test_a_decay_below_the_smallest_double_ends_at_the_absolute_tolerance(two_mode_model):
    """A step may err by its tolerance times |a| + 1e-3 of the range (dopri5.c, error_of)."""
    component = Component(two_mode_model, tolerance=FLOW)
    component.reset(amplitude=(2.0, 1.0))
    component.do_step(0.0, 1e6)
    outputs = component.outputs()
    assert np.hypot(outputs["A_re"], outputs["A_im"]) <= FLOW * 1e-3 * 4.0


def forced(model):
    """One mode, far from its steady amplitude."""
    component = Component(model, ({0: 1.0},), tolerance=FLOW)
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
def test_the_communication_step_does_not_change_the_amplitude(
    one_mode_model, periods, step, other
):
    """All in periods."""
    found = []
    for each in (step, other):
        component = forced(one_mode_model)
        run(component, np.full(round(periods / each), each * PERIOD))
        outputs = component.outputs()
        found.append(complex(outputs["A_re"], outputs["A_im"]))
    assert abs(found[0] - found[1]) <= FLOW * abs(found[1])


@pytest.mark.slow
@pytest.mark.oracle
def test_the_phase_does_not_drift_over_ten_million_cycles(one_mode_model):
    """In closed form, from the very doubles of the inputs."""
    getcontext().prec = 50
    component, step = forced(one_mode_model), CYCLES_PER_STEP * PERIOD
    durations = np.full(STEPS_PER_BATCH, step)
    batches = CYCLES // (CYCLES_PER_STEP * STEPS_PER_BATCH)
    for _ in range(batches):
        run(component, durations)
    turned = Decimal(OMEGA) * Decimal(step) * (STEPS_PER_BATCH * batches)
    difference = component.outputs()["theta_A"] - float(turned % (2 * PI))
    assert abs(math.remainder(difference, 2 * math.pi)) <= 1e-6
