"""Steady states of many loads: each as by itself, refused or not."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom.slow.branches.resonance_peaks import resonance_peaks
from slipmode.rom.slow.steady_points import steady_points

PATTERNS = ({0: 1.0}, {1: 1.0})


def modal(model, forces):
    each = [model.reduced.modal_force(j, pattern) for j, pattern in enumerate(PATTERNS)]
    return np.array(forces, dtype=complex) * each


def test_every_load_has_the_state_of_its_own(two_mode_model):
    forces = [(0.15, 0.25), (0.05, 0.25), (0.15, 0.0), (0.0, 0.0)]
    frequency = np.array([(0.98, 1.65), (1.0, 1.7), (0.98, 1.65), (0.98, 1.65)])
    found = steady_points(two_mode_model, frequency, PATTERNS, modal(two_mode_model, forces))
    assert found.reason == [""] * 4 and not found.outside.any()
    for k, (A, B) in enumerate(forces[:3]):
        alone = rom.steady(two_mode_model, frequency[k], ({0: A}, {1: B}))
        np.testing.assert_allclose(found.amplitude[k], alone, rtol=1e-9)
    assert np.all(found.amplitude[3] == 0.0)


def test_a_load_that_is_refused_leaves_the_others_alone(two_mode_model):
    forces = [(0.15, 0.25), (0.15, 0.25), (3.0, 0.25), (0.15, 0.25), (0.15, 0.25)]
    frequency = np.array([(0.98, 1.65), (0.1, 1.65), (1.0, 1.65), (1.7, 1.7), (0.98, 1.65)])
    found = steady_points(two_mode_model, frequency, PATTERNS, modal(two_mode_model, forces))
    assert found.outside.tolist() == [False, False, True, False, False]
    first, slow, far, met, last = found.reason
    assert (first, last) == ("", "")
    assert slow.startswith("frequency: must be 0.62")
    assert far.startswith("amplitude: ") and "outside the friction table" in far
    assert met == "frequency: the frequencies of modes A and B must differ at each point"
    assert np.isnan(found.amplitude[1:4]).all()
    np.testing.assert_array_equal(found.amplitude[0], found.amplitude[4])


def test_the_highest_peak_of_a_force_is_that_of_its_resonance_curve(one_mode_model):
    force = np.array([0.05, 0.1, 0.15])
    own = one_mode_model.reduced.modal_force(0, {0: 1.0})
    peak, frequency = resonance_peaks(one_mode_model, 0, force * abs(own))
    axis = np.linspace(0.95, 1.02, 701)[:, np.newaxis]
    for k, F in enumerate(force):
        curve = np.abs(rom.steady(one_mode_model, axis, ({0: F},)))[:, 0]
        assert peak[k] == pytest.approx(curve.max(), rel=1e-3)
        assert frequency[k] == pytest.approx(axis[curve.argmax(), 0], abs=5e-4)
    (beyond,), _ = resonance_peaks(one_mode_model, 0, np.array([5.0 * abs(own)]))
    assert np.isnan(beyond)


def test_paths_end_at_the_edge_of_the_table():
    """One of these had steps so short that they changed no amplitude, and did not end."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,))
    model = rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (3.3,), detuning=True)
    draw = np.random.default_rng(3).uniform
    frequency, force = draw(0.975, 0.99, (300, 1)), draw(0.1, 0.2, (300, 1))
    own = reduced.modal_force(0, PATTERNS[0])
    found = steady_points(model, frequency, PATTERNS[:1], force.astype(complex) * own)
    assert found.outside.sum() == 105
    reached = np.abs(found.amplitude[~found.outside])
    assert np.all(reached <= 3.3)
    assert set(np.array(found.reason)[~found.outside]) == {""}


def test_a_state_close_to_the_edge_of_the_table_is_found():
    """Newton's method stayed 0.2 % away from the edge, and found none there."""
    reduced, law = rom.reduce(rom.two_mass(beta=0.01), (0,)), rom.Tanh(2.0, 0.02)
    load = np.array([[0.98]]), PATTERNS[:1], np.array([[0.15 * reduced.modal_force(0, {0: 1.0})]])
    (wide,) = np.abs(steady_points(rom.tabulate(reduced, law, (6.0,)), *load).amplitude)
    found = steady_points(rom.tabulate(reduced, law, wide / 0.999), *load)
    np.testing.assert_allclose(np.abs(found.amplitude[0]), wide, rtol=2e-3)
