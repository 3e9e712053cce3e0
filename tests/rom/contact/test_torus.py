"""The contact problem on the torus: closed forms, converged values, invariances, orders."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.cases import many_contacts
from slipmode.rom import (
    ContactProblem,
    Coulomb,
    Discretisation,
    SlipmodeError,
    Tanh,
    reduce,
    two_mass,
)

pytestmark = pytest.mark.quick

LIMIT = 2.0
LAWS = [Tanh(LIMIT, 0.1), Tanh(LIMIT, 0.005), Coulomb(LIMIT)]
FORMULATIONS = ["paper", "consistent"]
SMOOTH = Tanh(LIMIT, alpha=0.1)
# both modes slip; a weak mode under a strong one; near both slip thresholds
AMPLITUDES = np.array([[1.3, 1.5], [2.5, 0.3], [1.05, 0.9], [0.9, 0.36]])


def two_mode(formulation, **parameters):
    return reduce(two_mass(**parameters), formulation=formulation)


def one_mode(mode):
    return reduce(two_mass(), modes=(mode,), formulation="paper")


def one_coulomb_contact(reduced, amplitude):
    """Q of one mode that slips at its own contact only."""
    own = reduced.modes[0]
    k, K = abs(reduced.coupling[0, own]), reduced.stiffness[own, own]
    r = np.minimum(LIMIT / (2 * k * amplitude), 1.0)
    root = np.sqrt(r * (1 - r))
    real = np.pi / 2 + np.arcsin(1 - 2 * r) + 2 * (1 - 2 * r) * root
    return k**2 / K * (real - 4j * r * (1 - r)) / np.pi


def one_mode_friction(reduced, law, amplitude, steps):
    grid = Discretisation(steps, lines=1)
    return ContactProblem.of(reduced, law).on(grid, 1e-10).solve(amplitude[:, np.newaxis]).Q[:, 0]


def largest_error(Q, exact):
    return np.abs(Q - exact).max()


def orders(errors):
    """Observed order on each halving of the step (or of alpha)."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


# One mode, the other contact stuck: up to the B that also moves contact 1
RANGES = {0: np.linspace(0.1, 4.0, 40), 1: np.linspace(0.1, 2.5, 25)}


@pytest.mark.parametrize("mode", RANGES)
def test_one_mode_under_coulomb_friction_has_the_closed_form(mode):
    reduced, amplitude = one_mode(mode), RANGES[mode]
    exact = one_coulomb_contact(reduced, amplitude)
    Q = one_mode_friction(reduced, Coulomb(LIMIT), amplitude, steps=4096)
    # measured 3.2e-7 of the largest |Q|
    np.testing.assert_allclose(Q, exact, rtol=0, atol=6e-7 * np.abs(exact).max())


@pytest.mark.parametrize(("mode", "amplitude", "Q"), [
    (0, 2.5, 0.031323 - 0.015279j),
    (1, 1.0, 0.144681 - 0.060161j),
])  # fmt: skip
def test_closed_form_has_the_printed_values(mode, amplitude, Q):
    assert one_coulomb_contact(one_mode(mode), amplitude) == pytest.approx(Q, abs=1e-6)


@pytest.mark.parametrize(("mode", "threshold"), [(0, 1.0), (1, 1 / 2.89)])
def test_a_stuck_coulomb_contact_gives_exactly_nothing(mode, threshold):
    amplitude = threshold * np.array([1e-6, 0.5, 0.999, 1.001])
    Q = one_mode_friction(one_mode(mode), Coulomb(LIMIT), amplitude, steps=64)
    assert not Q[:3].any()
    assert Q[3] != 0


def test_friction_damps_most_at_twice_the_slip_threshold():
    amplitude = np.linspace(1.5, 2.5, 101)
    Q = one_mode_friction(one_mode(0), Coulomb(LIMIT), amplitude, steps=4096)
    assert amplitude[Q.imag.argmin()] == pytest.approx(2.0, abs=0.02)
    assert Q.imag.min() == pytest.approx(-1 / (20 * np.pi), rel=1e-6)


def test_tanh_friction_tends_to_coulomb_with_order_1_in_alpha():
    reduced, amplitude = one_mode(0), np.array([1.2, 2.0, 2.5, 4.0])
    exact = one_coulomb_contact(reduced, amplitude)
    errors = [
        largest_error(one_mode_friction(reduced, Tanh(LIMIT, alpha), amplitude, 2048), exact)
        for alpha in (0.01, 0.005, 0.0025, 0.00125)
    ]
    # the creep of a contact just below its limit is alpha log(...): order 1 is approached slowly
    np.testing.assert_allclose(orders(errors), 1.0, atol=0.12)
    assert np.all(np.diff(orders(errors)) > 0)


@pytest.mark.parametrize("alpha", [0.1, 0.005, 0.001])
def test_small_motion_sees_a_viscous_damper(alpha):
    reduced = two_mode("paper")
    damper = LIMIT / alpha * np.eye(2)
    exact = [
        coupling @ np.linalg.solve(reduced.stiffness + 1j * omega * damper, coupling)
        for omega, coupling in zip(reduced.frequency, reduced.coupling, strict=True)
    ]
    grid = Discretisation(steps=1024, lines=4)
    Q = ContactProblem.of(reduced, Tanh(LIMIT, alpha)).on(grid, 1e-8).solve([(1e-3, 1e-4)]).Q[0]
    np.testing.assert_allclose(Q, exact, rtol=1e-5)  # measured 4e-6 at alpha 0.001


@pytest.mark.parametrize("amplitude", [1e-10, 1e-20, 1e-60])
def test_however_small_the_motion_friction_is_in_proportion(amplitude):
    pairs, grid = [(1e-6, 1e-6), (amplitude, amplitude)], Discretisation(steps=64, lines=8)
    usual, tiny = ContactProblem.of(reduce(two_mass()), Tanh(LIMIT, 0.02)).on(grid).solve(pairs).Q
    np.testing.assert_allclose(tiny, usual, rtol=1e-5)


def test_creep_below_the_threshold_damps_in_proportion_to_alpha():
    reduced, alpha = two_mode("paper"), 1e-3
    k = np.diag(np.abs(reduced.coupling))
    grid = Discretisation(steps=256, lines=4)
    Q = ContactProblem.of(reduced, Tanh(LIMIT, alpha)).on(grid, 1e-8).solve([(0.01, 0.003)]).Q[0]
    creep = -(k**2) * alpha / (reduced.frequency * LIMIT)
    # what is neglected is (alpha K / omega mu N)^2 = 1e-4, 1.4e-4
    np.testing.assert_allclose(Q.imag, creep, rtol=2e-4)


def test_two_modes_have_the_converged_values():
    Q = (
        ContactProblem.of(two_mode("paper"), Tanh(LIMIT, alpha=0.005))
        .on(Discretisation(2048, 64), 1e-7)
        .solve(AMPLITUDES)
        .Q
    )
    converged = np.array(
        [
            [0.014548 - 0.015452j, 0.174224 - 0.049727j],
            [0.031789 - 0.016080j, 0.014562 - 0.035861j],
            [0.003676 - 0.008335j, 0.136516 - 0.065793j],
            [0.000239 - 0.003450j, 0.006168 - 0.029175j],
        ]
    )
    # one unit of the last digit: measured 0.96e-6, at (0.9, 0.36)
    np.testing.assert_allclose(Q.view(float), converged.view(float), rtol=0, atol=1.1e-6)


# Orders of convergence


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_second_order_in_the_steps(formulation):
    def solve(steps):
        grid = Discretisation(steps, lines=32)
        return ContactProblem.of(two_mode(formulation), SMOOTH).on(grid, 1e-11).solve(AMPLITUDES).Q

    exact = solve(2048)
    errors = [largest_error(solve(steps), exact) for steps in (32, 64, 128, 256)]
    # measured 1.85 to 2.02; the reference's own error adds 0.02
    np.testing.assert_allclose(orders(errors), 2.0, atol=0.2)


def test_second_order_in_the_steps_even_where_contacts_stick():
    reduced, amplitude = one_mode(0), RANGES[0]
    exact = one_coulomb_contact(reduced, amplitude)
    errors = [
        largest_error(one_mode_friction(reduced, Coulomb(LIMIT), amplitude, steps), exact)
        for steps in (128, 512, 2048)
    ]
    # where slip ends falls anywhere within a step, so single halvings scatter
    np.testing.assert_allclose(orders(errors) / 2, 2.0, atol=0.2)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_spectral_in_the_lines(formulation):
    """Doubling the lines gains ever more than any fixed low power."""
    law, weak_over_strong = Tanh(LIMIT, alpha=0.2), [(2.5, 0.3)]

    def solve(lines):
        grid = Discretisation(128, lines)
        return (
            ContactProblem.of(two_mode(formulation), law).on(grid, 1e-14).solve(weak_over_strong).Q
        )

    errors = [largest_error(solve(lines), solve(64)) for lines in (2, 4, 8, 16)]
    # measured at most 6e-3, 3e-5, 4e-10, 2e-15; where lines are too few the harmonics keep moving
    # and the mean over the last periods hides part of the error, so the first gain says little
    assert np.all(np.array(errors) < (1.2e-2, 6e-5, 1.2e-9, 1e-13))
    gained = orders(errors)[1:]
    assert np.all(gained > 10)  # measured 12.8, 15.6: no power law
    assert np.all(np.diff(gained) > 2)


# Contacts that are joined to each other


def bar_friction(contacts, joint, points):
    """Q of the one mode of a mass on a bar, (points,); each contact slips at its own limit."""
    case = many_contacts(contacts, joint)
    reduced = reduce(case.structure, (0,), carrier=case.frequency)
    amplitudes = np.linspace(4.0, 0.3, points)[:, np.newaxis]
    return (
        ContactProblem.of(reduced, case.law)
        .on(Discretisation(64, 1), 1e-7)
        .solve(amplitudes)
        .Q[:, 0]
    )


@pytest.mark.parametrize("points", [1, 16], ids=["one point", "a group of lanes"])
@pytest.mark.parametrize("contacts", [2, 10, 30, 60, pytest.param(100, marks=pytest.mark.slow)])
def test_a_bar_is_the_more_one_contact_the_stiffer_it_is(contacts, points):
    """With order 1 in its flexibility, whether or not contacts slip one after the other."""
    single = bar_friction(1, 0.0, points)
    joints = (1.0, 10.0, 25.0, 100.0, 1e3, 1e4, 1e5)
    errors = [largest_error(bar_friction(contacts, j, points), single) for j in joints]
    assert np.all(np.diff(errors) < 0)
    # measured 0.89 to 1.03
    assert np.log10(errors[-2] / errors[-1]) == pytest.approx(1.0, abs=0.15)


# Invariances


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_sign_of_the_contact_coupling_does_not_matter(formulation, law):
    grid = Discretisation(64, 16)
    plus, minus = (
        ContactProblem.of(two_mode(formulation, k_p=k_p), law).on(grid).solve(AMPLITUDES).Q
        for k_p in (5.0, -5.0)
    )
    np.testing.assert_allclose(minus, plus, rtol=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 0.3, 1e6])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_coulomb_friction_is_homogeneous(formulation, scale):
    """To the periodicity that was asked for: where a march ends is a comparison that rounds."""
    reduced, grid, tolerance = two_mode(formulation), Discretisation(1024, 64), 1e-5
    plain, scaled = (
        ContactProblem(reduced, Coulomb(s * LIMIT), ((1, 0), (0, 1)))
        .on(grid, tolerance)
        .solve(s * AMPLITUDES)
        for s in (1.0, scale)
    )
    for solved in (plain, scaled):
        assert solved.residual.max() < tolerance
    frictionless = np.abs(np.linalg.solve(reduced.stiffness, reduced.coupling.T).T)
    largest = frictionless.max(axis=1) * AMPLITUDES  # (points, modes)
    difference = np.abs(scaled.P / scale - plain.P).max(axis=2)
    assert np.all(difference < 2 * tolerance * largest)


def test_tanh_friction_is_homogeneous_with_its_alpha():
    reduced, grid, scale = two_mode("consistent"), Discretisation(64, 16), 1e-6
    Q = ContactProblem.of(reduced, Tanh(LIMIT, 0.02)).on(grid).solve(AMPLITUDES).Q
    law = Tanh(scale * LIMIT, scale * 0.02)
    scaled = ContactProblem.of(reduced, law).on(grid).solve(scale * AMPLITUDES).Q
    np.testing.assert_allclose(scaled, Q, rtol=1e-10)


def test_half_periods_find_periodic_motion_in_few_periods():
    """Whole periods with Anderson's acceleration take 2.2 times as many steps."""
    reduced = two_mode("consistent", beta=0.01)
    points = np.linspace(0.4, 4.0, 5)[:, np.newaxis] * np.ones(2)
    grid = Discretisation(64, lines=32)
    found = ContactProblem.of(reduced, Tanh(LIMIT, 0.02)).on(grid, 1e-4).solve(points)
    assert found.residual.max() <= 1e-4
    assert found.marched.mean() <= 3.5 * grid.steps  # measured 2.8


def test_points_do_not_depend_on_their_neighbours():
    reduced, law, grid = two_mode("consistent"), Tanh(LIMIT, 0.02), Discretisation(64, 4)
    together = ContactProblem.of(reduced, law).on(grid).solve(AMPLITUDES).Q
    alone = [ContactProblem.of(reduced, law).on(grid).solve([point]).Q[0] for point in AMPLITUDES]
    # the implicit step ends when the last lane has converged
    np.testing.assert_allclose(alone, together, rtol=1e-8)


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_only_odd_sums_of_orders_appear(law):
    """The contact problem changes sign with half a turn of both phases."""
    even = [(0, 0), (1, 1), (2, 0), (0, 2), (-1, 1)]
    solved = (
        ContactProblem(two_mode("paper"), law, ((1, 0), *even))
        .on(Discretisation(128, 32), 1e-8)
        .solve([(1.3, 1.5)])
    )
    P_10, P_even = abs(solved.P[0, 0]).max(), abs(solved.P[0, 1:]).max()
    assert P_even < 1e-3 * P_10


# Energy


@given(
    amplitude=st.tuples(st.floats(1e-6, 8), st.floats(1e-6, 8)),
    law=st.sampled_from(LAWS),
    formulation=st.sampled_from(FORMULATIONS),
)
def test_structure_and_friction_never_feed_the_modes(amplitude, law, formulation):
    """Where dampers lie between both, the contacts may give back what the structure lost."""
    reduced = two_mode(formulation)
    Q = ContactProblem.of(reduced, law).on(Discretisation(64, 8)).solve([amplitude]).Q[0]
    own = reduced.modal_damping * reduced.frequency * (formulation == "consistent")
    power = 2 * reduced.frequency * np.square(amplitude) * (own - Q.imag)
    assert power.sum() >= -1e-12 * np.abs(power).max()


# Refusals


@pytest.mark.parametrize(
    ("amplitudes", "grid"),
    [
        ([(1.0, 1.0, 1.0)], Discretisation(64, 8)),
        ([(-1.0, 1.0)], Discretisation(64, 8)),
        ([(np.nan, 1.0)], Discretisation(64, 8)),
        ([(1.0, 1.0)], Discretisation(64, 6)),
        ([(1.0, 1.0)], Discretisation(0, 8)),
    ],
    ids=["three amplitudes", "negative", "not finite", "lines no power of two", "no steps"],
)
def test_refuses(amplitudes, grid):
    with pytest.raises(SlipmodeError):
        ContactProblem.of(two_mode("paper"), SMOOTH).on(grid).solve(amplitudes)


def test_mean_square_of_drifting_harmonics_is_a_mean_like_theirs(monkeypatch):
    """On a coarse grid they move on by its error; what they leave out needs both over one time."""
    reduced = two_mode("consistent", beta=0.01)

    def after(periods):
        monkeypatch.setattr("slipmode.rom.contact.problem.MOST_PERIODS", periods)
        grid = Discretisation(16, 2)
        return ContactProblem(reduced, Tanh(LIMIT, 0.02)).on(grid, 0.0).solve([[2.0, 1.0]])

    mean = after(1000)
    ends = []
    for periods in range(1, 1000):
        end = after(periods)
        if end.marched == mean.marched:
            break
        ends.append(end.mean_square)
    over_ends = np.mean(ends[-39:], axis=0)
    assert np.abs(ends[-1] / over_ends - 1.0).max() > 0.05
    np.testing.assert_allclose(mean.mean_square, over_ends, rtol=3e-3)
