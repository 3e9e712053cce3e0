"""What contacts do: stuck, slipping, open, along motions whose states are known."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom.laws.states import (
    OPEN,
    SLIPPING,
    STUCK,
    contact_states,
    harmonic_states,
    stored_energy,
)

pytestmark = pytest.mark.quick

LAW = rom.FrictionalContact(0.5, 2.0, 10.0, 4.0)


def test_a_frictional_contact_sticks_slips_and_opens():
    x = np.array([[0.05, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, -0.6]])
    f = np.array([[0.5, 0.0], [1.0, 0.0], [3.0, 4.0], [0.0, -2.0]])
    found = contact_states(LAW.elements(2), x, f)
    np.testing.assert_array_equal(found.state[:, 0], [STUCK, SLIPPING, SLIPPING, OPEN])
    np.testing.assert_allclose(found.normal_force[:, 0], [2.0, 2.0, 6.0, 0.0])
    np.testing.assert_allclose(found.gap[:, 0], [0.0, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(found.shares(), [[0.25, 0.5, 0.25]])


def test_preloads_are_scaled():
    x, f = np.array([[0.0, -0.6]] * 2), np.array([[0.0, -2.4], [0.8, -2.4]])
    found = contact_states(LAW.elements(2), x, f, np.array([2.0, 2.0]))
    np.testing.assert_array_equal(found.state[:, 0], [STUCK, SLIPPING])
    np.testing.assert_allclose(found.normal_force[:, 0], [1.6, 1.6])


def test_in_two_directions_the_force_slips_on_a_disk():
    law = rom.FrictionalContact(0.5, 2.0, 10.0, 4.0, tangents=2)
    x = np.zeros((2, 3))
    f = np.array([[0.8, 0.6, 0.0], [0.8, 0.5, 0.0]])
    states = contact_states(law.elements(3), x, f).state
    np.testing.assert_array_equal(states[:, 0], [SLIPPING, STUCK])


def test_sliders_slip_where_all_do():
    elements = rom.Sliders((1.0, 2.0), (5.0, 5.0)).elements(1)
    states = contact_states(elements, np.zeros((3, 1)), np.array([[2.9], [3.0], [-3.0]]))
    np.testing.assert_array_equal(states.state[:, 0], [STUCK, SLIPPING, SLIPPING])
    assert np.isnan(states.normal_force).all()


def test_springs_hold_what_a_motion_to_there_put_in():
    """Without friction the work on the contacts is all in their springs."""
    way = np.linspace(0.0, 1.0, 20001)[:, np.newaxis]
    x = way * [[0.01, -0.9]]
    N = np.maximum(2.0 + 4.0 * x[:, 1], 0.0)
    f = np.stack((np.zeros(len(x)), N - 2.0), axis=1)
    work = np.trapezoid(f[:, 1], x[:, 1])
    stored = stored_energy(LAW.elements(2), x, f)
    assert stored[0] == 0.0
    assert stored[-1] == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("size", [0.5, 1.5, 4.0])
def test_states_of_harmonic_motion_are_those_of_sliders_that_march(size):
    """Two sliders that slip at displacements of 0.5 and 2: the contact slips if both do."""
    limit, stiffness = np.array([1.0, 3.0]), np.array([2.0, 1.5])
    elements = rom.Sliders(limit, stiffness).elements(1)
    c, angle = 0.5 * size * np.exp(0.7j), np.linspace(0.0, 6.0 * np.pi, 6001)
    x = 2.0 * (c * np.exp(1j * angle)).real
    f, force = np.zeros(2), []
    for moved in np.diff(x, prepend=0.0):
        f = np.clip(f + stiffness * moved, -limit, limit)
        force.append(f.sum())
    last = slice(4000, None)  # a period
    marched = contact_states(elements, x[last, np.newaxis], np.array(force)[last, np.newaxis])
    found = [harmonic_states(elements, np.array([c]), each)[0] for each in angle[last]]
    # two changes of state in each half period, each at most a step apart
    assert np.count_nonzero(np.array(found) != marched.state[:, 0]) <= 4
    assert np.any(found) == (size > 2.0)
