"""At the edge of the friction table each force can be followed by a smaller one."""

import numpy as np
import pytest

from slipmode import fmu, rom

LARGEST = 0.01  # kg^1/2 m


def model(damping):
    return rom.model_of_rates(
        lambda r: (np.full_like(r, damping), np.full_like(r, 100.0)), amplitude=[LARGEST]
    )


def driven_to_the_edge(component, force):
    """With steps that are halved where they are refused, as importers do it."""
    component.set_inputs(force_A=force)
    step = 0.5
    while step > 1e-6:
        try:
            component.do_step(component.time, step)
        except rom.SlipmodeError:
            step /= 2.0
    return np.hypot(component.outputs()["A_re"], component.outputs()["A_im"])


@pytest.mark.parametrize("seed", range(4))
def test_a_smaller_force_is_a_way_back(seed):
    """Also no force; then the amplitude decays at the damping rate."""
    rng = np.random.default_rng(seed)
    damping, phase = 10.0 ** rng.uniform(-0.5, 1.0), rng.uniform(0.0, 2.0 * np.pi)
    component = fmu.Component(model(damping))
    component.set_inputs(phase_A=phase)
    # The steady amplitude |a| is F / (4 omega delta): three times the edge.
    size = driven_to_the_edge(component, 3.0 * LARGEST * 4.0 * 100.0 * damping)
    assert 0.99 * LARGEST < size <= LARGEST
    component.set_inputs(force_A=0.0)
    component.do_step(component.time, 0.5)
    left = np.hypot(component.outputs()["A_re"], component.outputs()["A_im"])
    # The change of force itself moves the amplitude by at most the damping ratio, times 3.
    assert left == pytest.approx(size * np.exp(-0.5 * damping), rel=6.0 * damping / 100.0)
