"""Steady states: against full-order amplitudes, harmonic balance and one another."""

import numpy as np
import pytest
from slow_time import slow_trajectory, steady_balance

from slipmode.rom import (
    ContactProblem,
    Coulomb,
    Discretisation,
    SlipmodeError,
    Tanh,
    ValidityWarning,
    reduce,
    resonance,
    resonance_curve,
    steady,
    tabulate,
    two_mass,
)
from slipmode.rom.reduction.combination import harmonic_orders

pytestmark = pytest.mark.quick

LAW = Tanh(limit=2.0, alpha=0.02)
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
    reduced = model.reduced
    forced = list(reduced.modes)
    a = steady(model, frequency, [forces(F)[mode] for mode in forced])
    orders, grid = harmonic_orders(1, len(forced)), Discretisation(256, 16)
    solved = (
        ContactProblem(reduced, model.law, tuple(orders), combinations=tuple(model.combinations))
        .on(grid)
        .solve([np.abs(a)])
    )
    found = np.zeros(2)
    for j, mode in enumerate(forced):
        P = solved.P[0, j] * np.exp(1j * np.angle(a[j]))
        found[mode] = np.abs(
            reduced.mode_shapes[mode, j] * a[j] + reduced.contact_shapes[mode] @ P
        )
    return found


@pytest.mark.parametrize(("F", "detuning", "full"), FULL_ORDER)
def test_carrier_amplitudes_are_those_of_the_full_order(F, detuning, full):
    """With the contact problem at the forcing frequencies and no mode that nothing forces."""
    forced = np.flatnonzero(F)
    Omega, largest = (NATURAL + detuning)[forced], 1.2 * np.array(full)[forced]
    model = tabulate(reduce(two_mass(), forced, carrier=Omega), LAW, largest, tolerance=1e-3)
    found = carrier_amplitudes(model, Omega, F)
    np.testing.assert_allclose(found, full, rtol=5.6e-4, atol=1e-9)  # measured 4.9e-4


@pytest.mark.parametrize(("F", "detuning", "full"), FULL_ORDER)
@pytest.mark.parametrize(
    ("name", "bound"),
    # measured at the worst: 0.24 % with the contact problem at the natural frequencies; 6.6 %
    [("two_mode_model", 0.0027), ("paper_model", 0.075)],
)
def test_what_a_simpler_model_costs(name, bound, F, detuning, full, request):
    found = carrier_amplitudes(request.getfixturevalue(name), NATURAL + detuning, F)
    np.testing.assert_allclose(found, full, rtol=bound, atol=1e-9)


@pytest.mark.parametrize(
    ("alpha", "peak", "bound"),
    # measured: +0.29 %, +0.12 %; time integration itself is 0.31 %, 0.16 % above these peaks
    [(0.05, 2.50650, 0.0033), (0.005, 2.87728, 0.0014)],
)
def test_the_peak_is_that_of_harmonic_balance(alpha, peak, bound):
    """Half the peak displacement of x_e1, mode A alone, by three independent codes."""
    reduced = reduce(two_mass(beta=0.0125), modes=(0,), carrier=(0.9825,))
    model = tabulate(reduced, Tanh(2.0, alpha), (4.0,), tolerance=1e-4)
    frequency = np.linspace(0.975, 0.99, 301)[:, np.newaxis]
    found = np.abs(steady(model, frequency, ({0: 0.15},))).max()
    assert found == pytest.approx(peak, rel=bound)


def test_the_steady_state_stands_still_in_the_slow_flow(two_mode_model):
    frequency = NATURAL + np.random.default_rng(3).uniform(-0.1, 0.1, (50, 2))
    a = steady(two_mode_model, frequency, BOTH)
    rate = steady_balance(two_mode_model, a, frequency, np.array([0.15, 0.25])).rate
    assert np.abs(rate).max() < 1e-9


FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
DETUNINGS = [(-0.0175, -0.046), (0.02, 0.03)]


def driven_from_rest(model, Omega, time):
    """Amplitudes at the times, (times, 2)."""
    forced = {"force_A": 0.15, "force_B": 0.25, "frequency_A": Omega[0], "frequency_B": Omega[1]}
    return slow_trajectory(model, FORCE_PATTERNS, time, tolerance=1e-9, **forced).amplitude


@pytest.mark.parametrize("detuning", DETUNINGS)
def test_the_slow_flow_from_rest_ends_in_the_steady_state(paper_model, detuning):
    """Without combination resonances."""
    Omega = NATURAL + detuning
    end = driven_from_rest(paper_model, Omega, np.array([0.0, 5000.0]))[-1]
    np.testing.assert_allclose(end, steady(paper_model, Omega, BOTH), rtol=1e-6)


@pytest.mark.parametrize("detuning", DETUNINGS)
def test_combination_resonances_make_the_amplitudes_beat_about_the_steady_state(
    two_mode_model, detuning
):
    Omega = NATURAL + detuning
    beat = 2 * np.pi / abs(5 * Omega[0] - 3 * Omega[1])
    assert {(term.n, term.m) for term in two_mode_model.combinations} == {(-4, 3), (5, -2)}
    time = np.append(0.0, 4000.0 + beat * np.linspace(0, 1, 65))
    amplitude = driven_from_rest(two_mode_model, Omega, time)[1:]
    np.testing.assert_allclose(amplitude[-1], amplitude[0], rtol=1e-7)
    expected = steady(two_mode_model, Omega, BOTH)
    swing = np.abs(amplitude - expected).max(axis=0) / np.abs(expected)
    assert np.all((swing > 5e-4) & (swing < 3e-3))  # measured 0.6e-3 to 2.7e-3
    # the mean moves by some squares of the swing: measured 2.1e-5 at most
    np.testing.assert_allclose(amplitude[1:].mean(axis=0), expected, rtol=3e-5)


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
    amplitude = np.linspace(0.2, 4, 4000)[:, np.newaxis]
    curve = resonance_curve(one_mode_model, 0, {0: 0.15}, amplitude)
    reached = np.isfinite(curve.below)
    last = np.flatnonzero(reached)[-1]
    assert not reached[last + 1 :].any()
    peak = np.abs(steady(one_mode_model, np.linspace(0.97, 1.0, 601)[:, np.newaxis], ({0: 0.15},)))
    assert peak.max() == pytest.approx(curve.amplitude[last], abs=2e-3)  # the amplitude step
    assert curve.above[last] - curve.below[last] < 0.1 * (curve.above - curve.below)[0]


def test_a_frequency_that_is_not_found_is_left_out():
    """With stuck contacts (omega^2 - Omega^2)^2 + (gamma Omega)^2 = (F / 2 |a|)^2 is exact."""
    reduced = reduce(two_mass(beta=0.3), modes=(0,))
    with pytest.warns(ValidityWarning, match="no contact slips"):
        model = tabulate(reduced, Coulomb(50.0), (1.0,), 1e-2)
    (omega,), (gamma,) = reduced.frequency, reduced.modal_damping
    half_force = 0.5 * abs(reduced.modal_force(0, {0: 0.15}))
    peak = half_force / (gamma * np.sqrt(omega**2 - 0.25 * gamma**2))
    amplitude = peak * (1.0 - np.geomspace(1e-6, 0.5, 60))
    with pytest.warns(ValidityWarning, match=r"does not converge at \|a\| = \[0\.24"):
        curve = resonance_curve(model, 0, {0: 0.15}, amplitude)
    for frequency in (curve.below, curve.above):
        found = np.isfinite(frequency)
        assert found.sum() > 10
        dynamic = omega**2 - frequency**2 + 1j * gamma * frequency
        # Measured 2e-9, 2e-4 after twelve passes.
        expected = half_force / np.abs(dynamic)[found]
        np.testing.assert_allclose(amplitude[found], expected, rtol=1e-8)


def test_a_curve_keeps_what_a_table_reaches_where_other_points_are_out_of_reach():
    """The coupling turns with the frequency: the last amplitudes of a table are beyond it."""
    reduced = reduce(two_mass(), modes=(0,))
    small, large = (tabulate(reduced, Tanh(2.0, 0.02), (end,), 1e-3) for end in (0.3, 0.4))
    amplitudes = np.array([[0.2], [0.25], [0.3], [0.35]])
    cut, whole = (resonance_curve(model, 0, {0: 0.15}, amplitudes) for model in (small, large))
    for found, expected in ((cut.below, whole.below), (cut.above, whole.above)):
        assert np.isfinite(expected).all()
        np.testing.assert_allclose(found[:2], expected[:2], rtol=1e-4)
        assert np.isnan(found[3])
    assert np.isnan([cut.below[2], cut.above[2]]).any()  # where the coupling is larger


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
