"""How much amplitudes change within a cycle, by closed forms."""

import numpy as np
import pytest

from slipmode.rom import Tanh, reduce, two_mass
from slipmode.rom.slow.transient import change_per_cycle, friction_threshold


def test_exponential_growth_changes_by_the_same_part_at_every_amplitude():
    Omega, sigma = np.array([2.0, 5.0]), 0.01
    amplitude = np.array([[1.0, 2.0j], [30.0, -4.0]])
    change = change_per_cycle(sigma * amplitude, Omega, amplitude, np.array([0.5, 0.5]))
    np.testing.assert_allclose(change, np.broadcast_to(2 * np.pi * sigma / Omega, (2, 2)))


def test_turning_is_a_change():
    """A free vibration 1 % beside the forcing."""
    change = change_per_cycle(np.array([0.01j]), np.array([1.0]), np.array([1.0]), np.zeros(1))
    assert change[0] == pytest.approx(0.02 * np.pi)


@pytest.mark.parametrize(
    ("threshold", "expected"), [(0.5, 0.02 * np.pi), (np.inf, 0.0), (0.0, 1.0)]
)
def test_from_rest_friction_is_the_scale(threshold, expected):
    """Where it acts at once an amplitude comes from nothing; where never, nothing is lost."""
    change = change_per_cycle(
        np.array([0.005 + 0j]), np.array([1.0]), np.zeros(1), np.array([threshold])
    )
    assert change[0] == pytest.approx(expected)


def test_at_rest_nothing_changes():
    zero = np.zeros(1, dtype=complex)
    assert change_per_cycle(zero, np.ones(1), zero, np.zeros(1))[0] == 0.0


def test_friction_begins_where_the_first_contact_slips():
    """In the paper's formulation |A| = 1 and |B| = 0.346."""
    reduced = reduce(two_mass(), (0, 1), "paper")
    threshold = friction_threshold(reduced, Tanh(limit=2.0, alpha=0.02))
    np.testing.assert_allclose(threshold, [1.0, 0.346], rtol=2e-3)
