"""The rate correction: friction is behind that of steady motion while amplitudes grow."""

from dataclasses import replace

import numpy as np
import pytest
from elastic import frictional_beam
from elastic.frictional_beam import SLIDER
from hard_cases import error_of
from scipy.integrate import quad

from benchmarks.blade import CYCLES, jenkins_blade
from benchmarks.cases import two_mode
from benchmarks.measure import worst_rms
from benchmarks.slow_case import SlowCase, amplitudes, constant_inputs
from slipmode.fmu import Component
from slipmode.rom import Coulomb, Discretisation, Tanh, reduce, tabulate, two_mass
from slipmode.rom.contact.rate_correction import friction_rate_correction
from slipmode.rom.table import corrections

LIMIT = 2.0
FINE = Discretisation(steps=1024, lines=1)
TWO_MODES = reduce(two_mass(beta=0.01), carrier=(0.98, 1.65))
RANGE = np.array([3.6, 1.5])


def rms(values):
    return np.sqrt(np.mean(np.abs(values) ** 2))


def play_operator_correction(k, K, Omega, a, limit=LIMIT):
    """In closed form, for a massless contact K x + g(x') = -2 k a cos(theta).

    After a reversal the contact sticks until the force has changed by twice the limit. It holds
    the x of the reversal, which is as far behind as the peak has grown since.
    """
    stick = np.arccos(1.0 - limit / (k * a))
    re, im = (
        quad(lambda angle, part=part: angle * part(angle), 0.0, stick)[0]
        for part in (np.cos, lambda angle: -np.sin(angle))
    )
    return -2.0 * k**2 / K * (re + 1j * im) / (np.pi * Omega)


@pytest.mark.parametrize("beyond_threshold", [1.1, 1.3, 2.0, 2.5])
def test_one_contact_has_the_correction_of_the_play_operator(beyond_threshold):
    """One mode; the other contact sticks."""
    reduced = reduce(two_mass(), modes=(0,), formulation="paper")
    k, K = abs(reduced.coupling[0, 0]), reduced.stiffness[0, 0]
    a = beyond_threshold * LIMIT / (2.0 * k)
    found = friction_rate_correction(
        reduced, Coulomb(LIMIT), np.array([[a]]), np.array([4.0]), FINE
    )
    exact = play_operator_correction(k, K, reduced.carrier[0], a)
    # measured at the worst, nearest to the threshold: 8e-4
    assert found[0, 0, 0] == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("beyond_threshold", [1.1, 1.5, 2.5])
def test_one_slider_has_that_of_the_play_operator_too(beyond_threshold):
    """What it lacks in force y follows (1 - k_t R) y = k_t u less the limit, where it slips."""
    k_t, limit = SLIDER.stiffness, SLIDER.limit
    reduced = reduce(frictional_beam.structure(SLIDER, 5), modes=(0,), law=SLIDER)
    k, K = k_t * abs(reduced.coupling[0, 0]), 1.0 + k_t * reduced.stiffness[0, 0]
    a = beyond_threshold * limit / (2.0 * k)
    found = friction_rate_correction(reduced, SLIDER, np.array([[a]]), np.array([2.5 * a]), FINE)
    exact = play_operator_correction(k, K, reduced.carrier[0], a, limit) / k_t
    assert found[0, 0, 0] == pytest.approx(exact, rel=2e-3)


def test_what_sticks_or_slips_all_the_time_has_none():
    reduced = reduce(two_mass(), formulation="paper")  # whose contacts have no inertia
    both, limit = np.array([[0.3, 0.4], [2.0, 1.0]]), np.array([4.0, 4.0])
    grid = Discretisation(64, 16)
    usual = np.abs(friction_rate_correction(reduced, Coulomb(LIMIT), both[1:], limit, grid)).max()
    for mu_N in (1e6, 1e-6):
        rate_correction = friction_rate_correction(reduced, Coulomb(mu_N), both, limit, grid)
        assert np.abs(rate_correction).max() < 1e-5 * usual


@pytest.mark.parametrize(
    ("law", "bound"),
    # measured: 0.19, where single reversals fall between the steps; 0.061
    [
        pytest.param(Coulomb(LIMIT), 0.25, marks=pytest.mark.slow),
        (Tanh(LIMIT, 0.02), 0.07),
    ],
    ids=["coulomb", "tanh"],
)
def test_the_table_has_that_of_the_points_between_its_nodes(law, bound):
    table = tabulate(TWO_MODES, law, RANGE, 1e-3).table
    points = np.random.default_rng(4).random((100, 2)) * RANGE
    exact = friction_rate_correction(TWO_MODES, law, points, RANGE, Discretisation(256, 32))
    assert rms(table.rate_correction_at(points) - exact) < bound * rms(exact)


def test_the_paper_has_none():
    model = tabulate(reduce(two_mass(), formulation="paper"), Tanh(LIMIT, 0.02), (2.0, 1.0), 1e-2)
    assert model.table.rate_correction is None
    assert not model.table.rate_correction_at(np.array([[1.0, 0.5]])).any()


def test_with_it_a_run_from_rest_is_closer_to_full_order():
    slow = SlowCase.tabulate(two_mode(), 1e-3)
    steady_friction = replace(slow.model, table=replace(slow.model.table, rate_correction=None))
    # measured: 0.79e-3, 3.2e-3
    assert error_of(slow) < 1e-3
    assert error_of(replace(slow, model=steady_friction)) > 3e-3


@pytest.mark.slow
def test_a_coarse_table_has_the_rate_correction_of_runs_from_rest(monkeypatch):
    case = jenkins_blade(4)
    reduced = case.reduced.at_carrier(case.frequency)

    def run(*, corrected=True):
        model = tabulate(reduced, case.law, (9.3e-6, 1.24e-5), 1e-2, detuning=False)
        if not corrected:
            model = replace(model, table=replace(model.table, rate_correction=None))
        component = Component(model, case.force)
        periods = np.full(CYCLES, 2.0 * np.pi / case.frequency[0])
        outputs = component.run(periods, constant_inputs(component, case.frequency, CYCLES))
        found = amplitudes(component, outputs)
        return np.vstack((found.real, found.imag))

    coarse, without = run(), run(corrected=False)
    monkeypatch.setattr(corrections, "_STRIDE", {2: 1})
    monkeypatch.setattr(corrections, "_LINES", {2: 200})
    exact = run()
    # measured: 0.12 %; 0.73 %
    assert worst_rms(coarse, exact) < 2e-3
    assert worst_rms(without, exact) > 6e-3
