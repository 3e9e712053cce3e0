"""The rate correction: friction is behind that of steady motion while amplitudes grow."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.closed_forms import play_delay

from benchmarks.cases import two_mode
from benchmarks.measure import worst_rms
from benchmarks.slow_case import SlowCase
from slipmode.rom import Coulomb, Discretisation, Tanh, full, reduce, tabulate, two_mass
from slipmode.rom.contact.rate_correction import friction_rate_correction

LIMIT = 2.0
RANGE = np.array([3.6, 1.5])


def error_of(slow):
    """RMS of the displacements from rest by a given model, against full order."""
    case, marcher = slow.case, slow.march(1.0)
    motion = marcher.motion(marcher(), case.times)
    exact = full.integrate(
        case.structure,
        case.law,
        case.excitation,
        case.times,
        outputs=case.observed,
        steps_per_period=512,
    )
    return worst_rms(marcher.elastic(motion), exact.displacement)


@pytest.mark.oracle
@pytest.mark.parametrize("beyond_threshold", [1.1, 1.3, 2.5])
def test_a_rigid_contact_has_the_correction_of_the_play_operator(beyond_threshold):
    """One massless contact K x + g(x') = -2 k a cos(theta); the other one sticks.

    After a reversal it sticks until the force has changed by twice the limit, at the x of the
    reversal, which is as far behind as the peak has grown since.
    """
    reduced = reduce(two_mass(), modes=(0,), formulation="paper")
    k, K = abs(reduced.coupling[0, 0]), reduced.stiffness[0, 0]
    a = beyond_threshold * LIMIT / (2.0 * k)
    found = friction_rate_correction(
        *(reduced, Coulomb(LIMIT), np.array([[a]]), np.array([4.0])), Discretisation(1024, 1)
    )
    stick = np.arccos(1.0 - LIMIT / (k * a))
    exact = -2.0 * k**2 / K * play_delay(stick) / (np.pi * reduced.carrier[0])
    assert found[0, 0, 0] == pytest.approx(exact, rel=1e-3)


@pytest.mark.oracle
def test_contacts_that_stick_or_slip_all_the_time_have_none():
    reduced = reduce(two_mass(), formulation="paper")
    points = np.array([[0.3, 0.4], [2.0, 1.0]])

    def largest(mu_N, points):
        grid, limit = Discretisation(64, 16), np.array([4.0, 4.0])
        return np.abs(friction_rate_correction(reduced, Coulomb(mu_N), points, limit, grid)).max()

    assert max(largest(1e6, points), largest(1e-6, points)) < 1e-5 * largest(LIMIT, points[1:])
    model = tabulate(reduced, Tanh(LIMIT, 0.02), (2.0, 1.0), 1e-2)
    assert not model.table.rate_correction_at(np.array([[1.0, 0.5]])).any()


@pytest.mark.oracle
def test_a_run_from_rest_is_closer_to_full_order_with_the_correction():
    slow = SlowCase.tabulate(two_mode(), 1e-3)
    steady_friction = replace(slow.model, table=replace(slow.model.table, rate_correction=None))
    with_it, without = error_of(slow), error_of(replace(slow, model=steady_friction))
    assert with_it < 1e-3
    assert with_it < 0.4 * without
