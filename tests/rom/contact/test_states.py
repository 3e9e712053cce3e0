"""What contacts do: stuck, slipping, open, along motions whose states are known."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom.laws.states import (
    OPEN,
    SLIPPING,
    STUCK,
    contact_states,
    stored_energy,
)

pytestmark = pytest.mark.quick

LAW = rom.FrictionalContact(0.5, 2.0, 10.0, 4.0)
PLANE = rom.FrictionalContact(0.5, 2.0, 10.0, 4.0, tangents=2)
SLIDERS = rom.Sliders((1.0, 2.0), (5.0, 5.0))
# Law, displacements, forces, factor on preloads; states, normal forces, gaps
CASES = {
    "frictional": (
        *(LAW, [[0.05, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, -0.6]]),
        *([[0.5, 0.0], [1.0, 0.0], [3.0, 4.0], [0.0, -2.0]], 1.0),
        *([STUCK, SLIPPING, SLIPPING, OPEN], [2.0, 2.0, 6.0, 0.0], [0.0, 0.0, 0.0, 0.1]),
    ),
    "scaled": (
        *(LAW, [[0.0, -0.6]] * 2, [[0.0, -2.4], [0.8, -2.4]], np.array([2.0, 2.0])),
        *([STUCK, SLIPPING], [1.6, 1.6], [0.0, 0.0]),
    ),
    "on a plane": (
        *(PLANE, np.zeros((2, 3)), [[0.8, 0.6, 0.0], [0.8, 0.5, 0.0]], 1.0),
        *([SLIPPING, STUCK], [2.0, 2.0], [0.0, 0.0]),
    ),
    "loaded and scaled": (
        *(rom.FrictionalContact(0.5, 2.0, 10.0, 4.0, 0.0, 2, (0.6, 0.0)), np.zeros((3, 3))),
        *([[0.8, 0.0, 0.0], [0.7, 0.0, 0.0], [-2.5, 0.0, 0.0]], np.full(3, 2.0)),
        *([SLIPPING, STUCK, STUCK], [4.0] * 3, [0.0] * 3),
    ),
    "sliders": (
        *(SLIDERS, np.zeros((3, 1)), [[2.9], [3.0], [-3.0]], 1.0),
        *([STUCK, SLIPPING, SLIPPING], 3 * [np.nan], 3 * [np.nan]),
    ),
}


@pytest.mark.oracle
@pytest.mark.parametrize("name", CASES)
def test_states_normal_forces_and_gaps_follow_from_the_law(name):
    law, x, f, scale, state, normal, gap = CASES[name]
    found = contact_states(law.elements(np.shape(x)[1]), np.array(x), np.array(f), scale)
    np.testing.assert_array_equal(found.state[:, 0], state)
    np.testing.assert_allclose(found.normal_force[:, 0], normal)
    np.testing.assert_allclose(found.gap[:, 0], gap)
    np.testing.assert_allclose(found.shares().sum(axis=1), 1.0)


@pytest.mark.oracle
def test_springs_hold_the_work_of_a_motion_without_friction():
    x = np.linspace(0.0, 1.0, 20001)[:, np.newaxis] * [[0.01, -0.9]]
    f = np.column_stack((np.zeros(len(x)), np.maximum(2.0 + 4.0 * x[:, 1], 0.0) - 2.0))
    stored = stored_energy(LAW.elements(2), x, f)
    assert stored[0] == 0.0
    assert stored[-1] == pytest.approx(np.trapezoid(f[:, 1], x[:, 1]), rel=1e-6)


@pytest.mark.oracle
@pytest.mark.parametrize("size", [0.5, 1.5, 4.0])
def test_states_of_harmonic_motion_are_those_of_sliders_that_march(size):
    """Two sliders that slip at displacements of 0.5 and 2: the contact slips if both do."""
    limit, stiffness = np.array([1.0, 3.0]), np.array([2.0, 1.5])
    elements = rom.Sliders(limit, stiffness).elements(1)
    c, angle = 0.5 * size * np.exp(0.7j), np.linspace(0.0, 6.0 * np.pi, 6001)
    x = 2.0 * (c * np.exp(1j * angle)).real
    f, slips, held = np.zeros(2), [], []
    for moved in np.diff(x, prepend=0.0):
        f = np.clip(f + stiffness * moved, -limit, limit)
        slips.append(np.all(np.abs(f) == limit))
        held.append(f.sum())
    last = slice(4000, None)  # a period
    force, _ = elements.march(x[:, np.newaxis])
    np.testing.assert_allclose(force[:, 0], held, atol=1e-12)
    found = contact_states(elements, x[last, np.newaxis], force[last]).state[:, 0]
    # two changes of state in each half period, each at most a step apart
    assert np.count_nonzero(found != np.array(slips)[last]) <= 4
    assert np.any(found) == (size > 2.0)
