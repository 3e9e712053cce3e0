"""The estimate of the transient error, by closed forms."""

import numpy as np
import pytest
from elastic.frictional_beam import LIFT_OFF, SLIDER, structure

from slipmode.rom import Jenkins, Tanh, reduce, two_mass
from slipmode.rom.slow.transient import TransientError, friction_threshold


def of_slider(law=SLIDER):
    """The reduced beam with one contact, its estimate, and the amplitude at which it slips."""
    reduced = reduce(structure(SLIDER, 5), (0,), law=law)
    return reduced, TransientError.of(reduced, law), friction_threshold(reduced, law)[0]


@pytest.mark.oracle
def test_a_slipping_contact_keeps_the_change_of_its_force_in_a_cycle():
    """On the displacement of the mode, twice half of the static force; at most the limit."""
    reduced, estimate, threshold = of_slider()
    Omega, coupling = 2.0, abs(reduced.coupling[0, 0])
    growth = 0.1 * threshold
    rate = np.array([[Omega / (2 * np.pi) * growth]])
    error = estimate.at(rate, np.array([Omega]), np.array([[threshold]]))
    force = 2 * coupling * growth * SLIDER.stiffness
    assert error[0, 0] == pytest.approx(0.5 * coupling * force / reduced.frequency[0] ** 2)
    most = estimate.at(1e3 * rate, np.array([Omega]), np.array([[threshold]]))
    assert most[0, 0] == pytest.approx(coupling * SLIDER.limit / reduced.frequency[0] ** 2)


@pytest.mark.oracle
def test_contacts_that_stick_and_steady_motion_have_no_error():
    _, estimate, threshold = of_slider()
    amplitude = threshold * np.array([[0.0], [0.5], [0.85], [0.95], [2.0]])
    rate = np.array([[0.1 * threshold / np.pi]])
    grown = estimate.at(np.repeat(rate, 5, axis=0), np.array([2.0]), amplitude)
    np.testing.assert_array_equal(grown > 0.0, [[False], [False], [False], [True], [True]])
    np.testing.assert_array_equal(estimate.at(0.0 * amplitude, np.array([2.0]), amplitude), 0.0)


@pytest.mark.oracle
def test_a_contact_whose_normal_load_varies_slips_before_its_limit():
    """Friction is lost where the normal displacement unloads the contact."""
    reduced = reduce(structure(LIFT_OFF, 8), (0,), law=LIFT_OFF)
    estimate = TransientError.of(reduced, LIFT_OFF)
    (threshold,) = friction_threshold(reduced, LIFT_OFF)
    tangential, normal = 2 * np.abs(reduced.coupling[0])
    stiffness = LIFT_OFF.tangential_stiffness, LIFT_OFF.normal_stiffness
    load = stiffness[0] * tangential + LIFT_OFF.mu * stiffness[1] * normal
    slips = LIFT_OFF.mu * LIFT_OFF.preload / load
    assert slips < 0.9 * threshold
    rate = np.array([[1e-6 * threshold]])
    for part in (0.99, 1.01):
        error = estimate.at(rate, np.array([2.0]), np.array([[part * slips]]))
        assert (error[0, 0] > 0.0) == (part > 1.0)


@pytest.mark.oracle
def test_a_mode_has_the_error_that_another_mode_makes():
    law = Jenkins(0.4, 40.0)
    reduced = reduce(structure(law, 5), (0, 1), law=law)
    estimate = TransientError.of(reduced, law)
    threshold = friction_threshold(reduced, law)
    error = estimate.at(np.array([[0.1 * threshold[0], 0.0]]), reduced.frequency, threshold)
    assert np.all(error > 0.0)
    ratio = np.abs(reduced.coupling[:, 0]) / reduced.frequency**2
    np.testing.assert_allclose(error[0] / error[0, 0], ratio / ratio[0])


@pytest.mark.oracle
def test_rigid_contacts_move_on_the_flexibility_of_the_structure():
    law = Tanh(limit=2.0, alpha=0.02)
    reduced = reduce(two_mass(), (0,))
    estimate = TransientError.of(reduced, law)
    growth, Omega = 0.01, 1.0
    rate = np.array([[growth * Omega / (2 * np.pi)]])
    error = estimate.at(rate, np.array([Omega]), friction_threshold(reduced, law)[np.newaxis] * 10)
    coupling = reduced.coupling[0]
    moved = np.abs(coupling @ np.linalg.inv(reduced.stiffness))
    expected = 0.5 * growth * moved @ np.abs(coupling) / reduced.frequency[0] ** 2
    assert error[0, 0] == pytest.approx(expected)
