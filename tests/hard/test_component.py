"""Hard cases of the component: rest, decays, communication steps of any length."""

import math

import numpy as np
import pytest

from slipmode.fmu import Component

FLOW = 1e-6  # tolerance of the slow flow
OMEGA = 0.98
PERIOD = 2 * math.pi / OMEGA


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
