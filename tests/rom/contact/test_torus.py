"""The contact problem on the torus: orders of convergence, scaling, periodicity, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from elastic.cantilever import LAWS, cantilever
from elastic.frictional_beam import LIFT_OFF, SLIDER, structure

from benchmarks.cases import many_contacts
from slipmode import rom
from slipmode.rom import ContactProblem, Coulomb, Discretisation, Tanh

pytestmark = pytest.mark.quick

LIMIT = 2.0
RIGID = [Tanh(LIMIT, 0.1), Tanh(LIMIT, 0.005), Coulomb(LIMIT)]
FORMULATIONS = ["paper", "consistent"]
# both modes slip; a weak mode under a strong one; near both slip thresholds
AMPLITUDES = np.array([[1.3, 1.5], [2.5, 0.3], [1.05, 0.9], [0.9, 0.36]])
ON_BEAM = np.array([[0.02, 0.012], [0.01, 0.009], [0.016, 0.003]])


def two_mode(formulation="consistent", **parameters):
    return rom.reduce(rom.two_mass(**parameters), formulation=formulation)


def on_beam(law, modes=(0, 1)):
    return rom.reduce(structure(law, 8 if law is LIFT_OFF else 5), modes, law=law)


def solved(reduced, law, grid, points, tolerance, **options):
    return (
        ContactProblem.of(reduced, law, **options)
        .on(Discretisation(*grid), tolerance)
        .solve(points)
    )


def observed(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


# Orders of convergence


@pytest.mark.oracle
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_rigid_friction_is_of_second_order_in_the_steps_and_spectral_in_the_lines(formulation):
    reduced = two_mode(formulation)

    def errors(law, points, grids, tolerance):
        *rough, exact = [solved(reduced, law, grid, points, tolerance).Q for grid in grids]
        return [np.abs(Q - exact).max() for Q in rough]

    steps = [(n, 32) for n in (32, 64, 128, 256, 2048)]
    orders = observed(errors(Tanh(LIMIT, 0.1), AMPLITUDES, steps, 1e-11))
    np.testing.assert_allclose(orders, 2.0, atol=0.2)  # of the reference's own error: 0.02
    lines = [(128, n) for n in (2, 4, 8, 16, 64)]
    gained = observed(errors(Tanh(LIMIT, 0.2), AMPLITUDES[1:2], lines, 1e-14))[1:]
    assert np.all(gained > 10) and gained[1] > gained[0] + 2  # no power law


@pytest.mark.oracle
@pytest.mark.parametrize("law", [SLIDER, LIFT_OFF], ids=["slider", "lift-off"])
def test_elastic_contacts_converge_with_the_steps(law):
    """Sliders with order 3: turning points are found within steps."""
    reduced = on_beam(law)
    steps = np.array([64, 128, 256])
    exact, *rough = [
        solved(reduced, law, (n, 16), ON_BEAM[:1], 1e-8).S for n in (1024, *steps.tolist())
    ]
    errors = [np.abs(S - exact).max() for S in rough]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > (2.6 if law is SLIDER else 1.7)


@pytest.mark.oracle
@pytest.mark.parametrize("contacts", [2, 10, pytest.param(60, marks=pytest.mark.slow)])
def test_contacts_of_a_bar_are_one_contact_in_the_limit_of_a_stiff_bar(contacts):
    """With order 1 in its flexibility, whether or not they slip one after the other."""

    def friction(contacts, joint):
        case = many_contacts(contacts, joint)
        reduced = rom.reduce(case.structure, (0,), carrier=case.frequency)
        points = np.linspace(4.0, 0.3, 16)[:, np.newaxis]
        return solved(reduced, case.law, (64, 1), points, 1e-7).Q

    single = friction(1, 0.0)
    errors = [np.abs(friction(contacts, j) - single).max() for j in (1.0, 25.0, 1e3, 1e4, 1e5)]
    assert np.all(np.diff(errors) < 0)
    assert np.log10(errors[-2] / errors[-1]) == pytest.approx(1.0, abs=0.15)


# Scaling and symmetry


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize("scale", [1e-6, 3.0])
@pytest.mark.parametrize("law", [*RIGID[1:], SLIDER, LIFT_OFF, LAWS["mixed"]], ids=str)
def test_friction_scales_with_limits_and_amplitudes_together(law, scale):
    """S(a; s) = s S(a / s): friction limits, preloads and the velocity of tanh times s."""
    tolerance = 1e-7
    if law is LAWS["mixed"]:
        reduced, points = rom.reduce(cantilever(law), (0, 1), law=law), ON_BEAM
        scaled = rom.Contacts([(larger(part, scale), columns) for part, columns in law.groups])
    else:
        rigid = isinstance(law, Tanh | Coulomb)
        reduced, points = (two_mode(), AMPLITUDES) if rigid else (on_beam(law), ON_BEAM)
        scaled = larger(law, scale)
    grid = (1024, 64) if isinstance(law, Coulomb) else (64, 16)
    S = solved(reduced, law, grid, points, tolerance).S
    assert np.abs(S).max(axis=0).min() > 0.0
    found = solved(reduced, scaled, grid, scale * points, tolerance).S
    # a march ends where it repeats to the tolerance, relative to the frictionless displacement
    np.testing.assert_allclose(found / scale, S, rtol=0, atol=1e-5 * np.abs(S).max())


def larger(law, scale):
    if isinstance(law, Tanh):
        return Tanh(scale * law.limit, scale * law.alpha)
    names = [name for name in ("limit", "preload", "force") if hasattr(law, name)]
    return replace(law, **{name: scale * np.array(getattr(law, name)) for name in names})


@pytest.mark.oracle
@pytest.mark.parametrize("law", RIGID, ids=str)
def test_only_odd_sums_of_orders_appear(law):
    """The contact problem changes sign with half a turn of both phases."""
    orders = ((1, 0), (0, 1), (0, 0), (1, 1), (2, 0), (0, 2), (-1, 1))
    grid = Discretisation(128, 32)
    P = ContactProblem(two_mode("paper"), law, orders).on(grid, 1e-8).solve([(1.3, 1.5)]).P[0]
    assert np.abs(P[2:]).max() < 1e-3 * np.abs(P[0]).max()


# Periodicity and initial guesses


@pytest.mark.parametrize("law", [SLIDER, LIFT_OFF], ids=["slider", "lift-off"])
def test_motion_is_the_same_alone_after_others_and_from_any_guess(law):
    reduced, grid = on_beam(law), Discretisation(64, 16)
    problem = ContactProblem.of(reduced, law).on(grid, 1e-7)
    together = problem.solve(ON_BEAM)
    assert together.residual.max() <= 1e-7
    size = np.abs(together.S).max()
    alone = np.vstack([problem.solve(point[np.newaxis]).S for point in ON_BEAM])
    guesses = [problem.solve(0.99 * ON_BEAM).P, 10.0 * together.P.conj()]
    for S in (alone, *(problem.solve(ON_BEAM, guess).S for guess in guesses)):
        np.testing.assert_allclose(S, together.S, atol=1e-5 * size)


def test_motion_that_drifts_on_few_phase_lines_is_solved_on_more():
    """A contact that slips where both modes are at their peaks only."""
    reduced = two_mode(beta=0.0135, k_c1=23.5, k_c2=12.0, k_p=1.1)
    points = np.stack(np.meshgrid(np.linspace(0.65, 0.95, 8), np.linspace(1.1, 1.9, 8)), -1)
    problem = ContactProblem.of(reduced, Coulomb((2.0, 3.7)))
    coarse = problem.on(Discretisation(256, 16), 1e-4, (0.4, 0.2))
    plain = coarse.solve(points.reshape(-1, 2))
    finer, moving = coarse.on_more_lines(plain), plain.residual > 1e-4
    assert moving.any()
    assert finer.residual.max() <= 1e-4
    np.testing.assert_array_equal(finer.S[~moving], plain.S[~moving])


def test_harmonics_that_lines_cannot_distinguish_have_no_response():
    orders, reduced = ((1, 0), (0, 1), (1, 6)), on_beam(SLIDER)

    def harmonics(orders, lines):
        problem = ContactProblem(reduced, SLIDER, orders)
        return problem.on(Discretisation(64, lines), 1e-7).solve(ON_BEAM).P

    beside = harmonics((*orders, (1, -64)), 16)
    assert not beside[:, 3].any()
    assert harmonics((*orders, (1, -12)), 64)[:, 3].any()
    alone = harmonics(orders, 16)
    np.testing.assert_allclose(beside[:, :3], alone, rtol=0, atol=1e-5 * np.abs(alone).max())
