"""Peers of full order: Newmark's loop against rom.full, the compiled right-hand side."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.cases import general_damping, six_dofs_three_contacts
from benchmarks.full_order import Timed, at_equal_error, by_newmark, one_mode_blade
from benchmarks.peers.first_order import FirstOrder
from benchmarks.peers.newmark import newmark
from slipmode import rom
from slipmode.rom.full.convergence import relative_rms
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.laws.friction import limits

CYCLES = 30


@pytest.fixture(scope="module")
def jenkins():
    return one_mode_blade(1500, 30)


@pytest.fixture(scope="module")
def exact(jenkins):
    return jenkins.integrated(512, CYCLES)().contact_displacement


def test_some_contacts_slip_and_some_stick(jenkins, exact):
    beyond = np.ptp(exact[-64:], axis=0) * jenkins.law.stiffness / (2 * jenkins.law.limit)
    assert 3 <= np.sum(beyond > 1.2) <= 9


def test_newmark_converges_to_full_order_with_the_square_of_the_step(jenkins, exact):
    steps = np.array([128, 256, 512, 1024])
    errors = [relative_rms(by_newmark(jenkins, n, CYCLES)(), exact).max() for n in steps]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 1.8 < order < 2.2
    assert errors[-1] < 3e-4


def test_full_order_is_as_exact_at_far_fewer_steps(jenkins, exact):
    """32 steps of four parts each; it is at resonance that Newmark's frequencies are wrong."""
    ours = relative_rms(jenkins.integrated(32, CYCLES)().contact_displacement, exact).max()
    assert ours < relative_rms(by_newmark(jenkins, 512, CYCLES)(), exact).max()


def test_newmark_refuses_damping_between_modes():
    modes = ModalCoordinates.of(general_damping().structure)
    with pytest.raises(rom.SlipmodeError, match="damping couples modes"):
        newmark(modes, rom.Jenkins(1.0, 1.0), np.ones(4), 1.0, 0.1, 1, 1)


def test_equal_error_is_the_cheapest_that_is_as_exact():
    runs = [Timed(1.0, 1e-1, "4"), Timed(2.0, 1e-3, "8"), Timed(4.0, 1e-4, "16")]
    assert at_equal_error(runs, 2e-3).setting == "8"
    assert at_equal_error(runs, 1e-9).setting == "16"


@pytest.mark.parametrize("make", [six_dofs_three_contacts, general_damping])
def test_the_compiled_right_hand_side_is_the_equation_of_motion(make):
    case = replace(make(), force=({0: 0.2, 1: -0.1}, {1: 0.3}))
    problem, s, rng = FirstOrder(case), case.structure, np.random.default_rng(5)
    n, W = s.n_dofs, np.asarray(s.directions)
    for t in (0.0, 7.3):
        y = rng.normal(size=2 * n) * 0.05
        x, v = np.split(y, 2)
        g = limits(case.law, W.shape[1]) * np.tanh(W.T @ v / case.law.alpha)
        f = np.cos(np.array(case.frequency) * t) @ case.excitation.patterns
        expected = np.linalg.solve(s.mass, f - s.stiffness @ x - s.damping @ v - W @ g)
        found = problem.rate(t, y)
        np.testing.assert_allclose(found[:n], v)
        np.testing.assert_allclose(found[n:], expected, rtol=1e-10, atol=1e-11)
        step = 1e-7
        columns = [
            (problem.rate(t, y + step * each) - problem.rate(t, y - step * each)) / (2 * step)
            for each in np.eye(2 * n)
        ]
        J = problem.jacobian(t, y)
        np.testing.assert_allclose(J, np.transpose(columns), atol=1e-6 * np.abs(J).max())
