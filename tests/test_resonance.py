"""Steady states: against full-order amplitudes, harmonic balance and one another."""

import numpy as np
import pytest
from slow_time import slow_trajectory

from rom import SlipmodeError, Tanh, reduce, tabulate, two_mass
from rom.amplitude import amplitude_rate
from rom.resonance import resonance, resonance_curve, steady
from rom.torus import Discretisation, contact_harmonics

NATURAL = np.array([1.0, 1.7])
BOTH = ({0: 0.15}, {1: 0.25})
# F_A, F_B, dOmega_A, dOmega_B; carrier amplitudes of x_e1, x_e2 by converged time integration
FULL_ORDER = [
    ((0.15, 0.0), (-0.0175, 0.0), (3.1317, 0.0)),
    ((0.15, 0.0), (-0.03, 0.0), (1.4903, 0.0)),
    ((0.0, 0.25), (0.0, -0.046), (0.0, 1.2829)),
    ((0.0, 0.25), (0.0, -0.07), (0.0, 0.7819)),
    ((0.15, 0.25), (-0.0175, -0.046), (3.1000, 1.2541)),
    ((0.15, 0.25), (-0.03, -0.06), (1.5621, 1.0545)),
    ((0.15, 0.25), (-0.005, -0.02), (2.2169, 0.9395)),
]


def forces(F):
    return tuple({dof: amplitude} for dof, amplitude in enumerate(F))


def carrier_amplitudes(model, frequency, F):
    """|x_e1| at Omega_A and |x_e2| at Omega_B: the modes and what the contacts add."""
    a = steady(model, frequency, forces(F))
    orders, grid = [(1, 0), (0, 1)], Discretisation(256, 16)
    solved = contact_harmonics(model.reduced, model.law, [np.abs(a)], grid, orders)
    P = solved.P[0] * np.exp(1j * np.angle(a))[:, np.newaxis]
    reduced = model.reduced
    return np.abs([reduced.mode_shapes[j] @ np.where(np.arange(2) == j, a, 0)
                   + reduced.contact_shapes[j] @ P[j] for j in range(2)])  # fmt: skip


@pytest.mark.parametrize(("F", "detuning", "full"), FULL_ORDER)
@pytest.mark.parametrize(
    ("name", "bound"),
    # measured: consistent 0.002 to 0.24 %, paper 0.9 to 6.6 %
    [("two_mode_model", 0.004), ("paper_model", 0.08)],
)
def test_carrier_amplitudes_are_those_of_the_full_order(name, bound, F, detuning, full, request):
    found = carrier_amplitudes(request.getfixturevalue(name), NATURAL + detuning, F)
    np.testing.assert_allclose(found, full, rtol=bound, atol=1e-9)


@pytest.mark.parametrize(("alpha", "peak"), [(0.05, 2.50650), (0.005, 2.87728)])
def test_the_peak_is_that_of_harmonic_balance(alpha, peak):
    """Half the peak displacement of x_e1, mode A alone, by three independent codes."""
    model = tabulate(
        reduce(two_mass(beta=0.0125), modes=(0,)), Tanh(2.0, alpha), (4.0,), tolerance=1e-4
    )
    frequency = np.linspace(0.975, 0.99, 301)[:, np.newaxis]
    found = np.abs(steady(model, frequency, ({0: 0.15},))).max()
    # measured: +0.62 % at alpha 0.05, +0.29 % at alpha 0.005
    assert found == pytest.approx(peak, rel=0.008)


def test_the_steady_state_stands_still_in_the_slow_flow(two_mode_model):
    frequency = NATURAL + np.random.default_rng(3).uniform(-0.1, 0.1, (50, 2))
    a = steady(two_mode_model, frequency, BOTH)
    rate = amplitude_rate(two_mode_model, a, frequency, np.array([0.15, 0.25]))
    assert np.abs(rate).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "rtol"),
    # the near resonances, that steady() leaves out, make a_j beat: measured 0.22 %
    [("paper_model", 1e-6), ("two_mode_model", 4e-3)],
)
@pytest.mark.parametrize("detuning", [(-0.0175, -0.046), (0.02, 0.03)])
def test_the_slow_flow_from_rest_ends_in_the_steady_state(name, rtol, detuning, request):
    model = request.getfixturevalue(name)
    Omega = NATURAL + detuning
    run = slow_trajectory(
        model,
        ({0: 1.0}, {1: 1.0}),
        np.array([0.0, 5000.0]),
        tolerance=1e-9,
        **{"force_A": 0.15, "force_B": 0.25, "frequency_A": Omega[0], "frequency_B": Omega[1]},
    )
    np.testing.assert_allclose(run.amplitude[-1], steady(model, Omega, BOTH), rtol=rtol)


@pytest.mark.parametrize("name", ["two_mode_model", "paper_model"])
@pytest.mark.parametrize("mode", [0, 1])
def test_the_curve_inverted_gives_back_the_amplitude(name, mode, request):
    model = request.getfixturevalue(name)
    held = np.zeros((9, 2))
    held[:, mode] = np.linspace(0.3, 1.1, 9)
    curve = resonance_curve(model, mode, BOTH[mode], held)
    assert np.isfinite(curve.below).all()
    assert np.all(curve.below < curve.above)
    alone = [force if j == mode else {0: 0.0} for j, force in enumerate(BOTH)]
    for branch in (curve.below, curve.above):
        frequency = np.tile(NATURAL, (branch.size, 1))
        frequency[:, mode] = branch
        found = np.abs(steady(model, frequency, alone)[:, mode])
        np.testing.assert_allclose(found, curve.amplitude, rtol=1e-7)


def test_the_branches_meet_at_the_peak_and_end_there(one_mode_model):
    amplitude = np.linspace(0.1, 4, 4000)[:, np.newaxis]
    curve = resonance_curve(one_mode_model, 0, {0: 0.15}, amplitude)
    reached = np.isfinite(curve.below)
    last = np.flatnonzero(reached)[-1]
    assert not reached[last + 1 :].any()
    peak = np.abs(steady(one_mode_model, np.linspace(0.97, 1.0, 601)[:, np.newaxis], ({0: 0.15},)))
    assert peak.max() == pytest.approx(curve.amplitude[last], abs=2e-3)  # the amplitude step
    assert curve.above[last] - curve.below[last] < 0.1 * (curve.above - curve.below)[0]


def test_the_surface_is_the_steady_state_at_each_pair_of_frequencies(two_mode_model):
    axis_A, axis_B = np.array([0.96, 0.98, 1.0]), np.array([1.6, 1.65])
    surface = resonance(two_mode_model, BOTH, axis_A, axis_B)
    assert surface.amplitude.shape == (3, 2, 2)
    for i, Omega_A in enumerate(axis_A):
        for j, Omega_B in enumerate(axis_B):
            alone = steady(two_mode_model, (Omega_A, Omega_B), BOTH)
            np.testing.assert_allclose(surface.amplitude[i, j], alone, rtol=1e-9)
    squares = np.abs(surface.amplitude) ** 2
    np.testing.assert_allclose(surface.euclidean, np.sqrt(squares.sum(axis=-1)))


def test_an_unforced_mode_is_at_rest(two_mode_model):
    a = steady(two_mode_model, (0.98, 1.65), forces((0.15, 0.0)))
    assert a[1] == 0
    assert not steady(two_mode_model, (0.98, 1.65), forces((0.0, 0.0))).any()


@pytest.mark.parametrize(
    ("frequency", "force", "message"),
    [
        ((0.98,), BOTH, "frequency: must be finite and > 0"),
        ((0.98, -1.65), BOTH, "frequency: must be finite and > 0"),
        ((0.98, np.nan), BOTH, "frequency: must be finite and > 0"),
        ((0.98, 1.65), BOTH[:1], "force: needs one entry per mode"),
        ((0.98, 1.65), ({7: 0.1}, {1: 0.2}), "force: DOF 7 is out of range"),
        ((0.985, 1.65), ({0: 15.0}, {1: 0.25}), "outside the friction table"),
    ],
)
def test_refuses_in_one_line(two_mode_model, frequency, force, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        steady(two_mode_model, frequency, force)
    assert "\n" not in str(refusal.value)
