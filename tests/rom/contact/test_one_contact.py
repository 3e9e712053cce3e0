"""One contact under a known motion: closed forms of Q, its harmonics, and what it dissipates.

Weak contacts do not change the motion of a mode: x = 2 a cos(theta). Elastic contacts answer with
their force deficit y = k x - f, and S = W^T phi . y_1.
"""

import numpy as np
import pytest
from oracles.closed_forms import jenkins_dissipation, jenkins_first_harmonic

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation

pytestmark = pytest.mark.quick

SMALL = 1e-6  # stiffness of weak contacts relative to the structure
LIMIT = 2.0
IWAN = rom.Iwan(force=SMALL, stiffness=SMALL, chi=-0.5, beta=0.3, sliders=9)


def shaken(law, contacts=1, carrier=(1.0, 1.618)):
    """A structure whose first modes move all contacts, which hardly act on it."""
    n = max(contacts, len(carrier))
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(n, n)))[0]
    stiffness = turn * np.square([*carrier, 2.3, 2.9, 3.7][:n]) @ turn.T
    structure = rom.Structure(np.eye(n), stiffness, 0.0, contact=np.eye(n)[:, :contacts])
    reduced = rom.reduce(structure, tuple(range(len(carrier))), law=law)
    return reduced, reduced.mode_shapes[:contacts]


def play(x, limit, stiffness):
    """Force of a Jenkins element under a sampled motion from rest."""
    s, f, reach = 0.0, [], limit / stiffness
    for each in x.tolist():
        s = min(max(s, each - reach), each + reach)
        f.append(stiffness * (each - s))
    return np.array(f)


def friction(x, law):
    """Force (samples, 2) of a frictional contact under a sampled motion (tangent, normal)."""
    normal = np.maximum(law.preload + law.normal_stiffness * (x[:, 1] - law.gap), 0.0)
    k, s, f = law.tangential_stiffness, 0.0, []
    for held, each in zip(law.mu * normal, x[:, 0], strict=True):
        f.append(float(np.clip(k * (each - s), -held, held)))
        s = each - f[-1] / k
    return np.column_stack((f, normal - law.preload))


SLIDERS = {
    "Jenkins": (rom.Jenkins(SMALL, 0.7 * SMALL), [SMALL], [0.7 * SMALL]),
    "sliders": (
        rom.Sliders((SMALL, 3 * SMALL), (SMALL, 0.5 * SMALL)),
        [SMALL, 3 * SMALL],
        [SMALL, 0.5 * SMALL],
    ),
    "Iwan": (IWAN, *IWAN.distribution()),
}


@pytest.mark.oracle
@pytest.mark.parametrize("name", SLIDERS)
def test_sliders_have_the_closed_form_in_value_phase_and_dissipation(name):
    law, limits, stiffnesses = SLIDERS[name]
    reduced, _ = shaken(law, carrier=(1.0,))
    X = np.array([0.2, 1.5, 3.0, 6.0, 20.0])
    terms = (
        ContactProblem.of(reduced, law).on(Discretisation(1024, 1), 1e-10).solve(X[:, None] / 2)
    )
    pairs = list(zip(limits, stiffnesses, strict=True))
    exact = [sum(k * x - jenkins_first_harmonic(x, mu_N, k) for mu_N, k in pairs) / 2 for x in X]
    # the third harmonic changes the motion by SMALL; events within a step are of third order
    np.testing.assert_allclose(terms.S[:, 0], exact, rtol=0, atol=1e-7 * np.abs(exact).max())
    work = np.array([sum(jenkins_dissipation(x, *pair) for pair in pairs) for x in X])
    for power in (terms.power, terms.leaving):
        np.testing.assert_allclose(power, work / (2.0 * np.pi), rtol=0, atol=1e-6 * work.max())


FRICTIONAL = {
    "pressed": rom.FrictionalContact(0.5, SMALL, SMALL, 2 * SMALL),
    "with a gap": rom.FrictionalContact(0.5, 0.0, SMALL, 2 * SMALL, gap=0.2),
    "frictionless": rom.FrictionalContact(0.0, 0.4 * SMALL, SMALL, 1.5 * SMALL),
    "on a plane": rom.FrictionalContact(0.5, SMALL, SMALL, 2 * SMALL, tangents=2),
}


@pytest.mark.oracle
@pytest.mark.parametrize("X", [1.0, 4.0])
@pytest.mark.parametrize("name", FRICTIONAL)
def test_friction_under_a_varying_load_has_the_harmonics_of_its_loop(name, X):
    """In tangent and normal direction, also the mean; beside a contact that sticks.

    y = k x - f, without k of a contact that is open at rest.
    """
    law = FRICTIONAL[name]
    n = law.tangents
    both = rom.Contacts([(law, tuple(range(n + 1))), (rom.Jenkins(1.0, SMALL), (n + 1,))])
    reduced, shapes = shaken(both, n + 2, (1.0,))
    shape, samples = shapes[: n + 1, 0], 8192
    along = np.linalg.norm(shape[:n])  # straight: the force on a plane is along the motion
    x = X * np.cos(2.0 * np.pi * np.arange(3 * samples) / samples)
    tangential, normal = friction(np.outer(x, [along, shape[n]]), law)[-samples:].T
    f = np.column_stack((np.outer(tangential, shape[:n] / along), normal))
    stiffness = np.append(np.full(n, law.tangential_stiffness), law.normal_stiffness)
    x = np.outer(x[-samples:], shape)
    y = np.fft.fft((law.preload > 0.0) * stiffness * x - f, axis=0) / samples
    y[0] *= 0.5  # 2 Re P_00 is the mean
    problem = ContactProblem.of(reduced, both, highest=4).on(Discretisation(1024, 1), 1e-10)
    terms, size = problem.solve([[X / 2]]), np.abs(y).max()
    for k, (n, _) in enumerate(terms.orders[:5]):
        np.testing.assert_allclose(terms.P[0, k], [*y[n], 0.0], rtol=0, atol=1e-4 * size)
    assert terms.S[0, 0] == pytest.approx(shape @ y[1], abs=1e-4 * size)
    work = np.sum(f * np.gradient(x, axis=0))
    assert terms.power[0] == pytest.approx(work / (2.0 * np.pi), abs=1e-3 * size * X)


@pytest.mark.oracle
@pytest.mark.parametrize("limit", [0.3, 1.0])
def test_two_tones_move_a_slider_along_the_torus(limit):
    """The means over 233 periods of A, in which B has 377, against the march from rest."""
    law = rom.Jenkins(limit * SMALL, SMALL)
    reduced, shapes = shaken(law, 1, (1.0, 377 / 233))
    theta = 2.0 * np.pi * np.arange(233 * 256) / 256
    waves = np.exp(1j * np.outer(theta, [1.0, 377 / 233, 2.0 - 377 / 233]))
    a = np.array([0.6, 0.4])
    x = 2.0 * waves[:, :2].real @ (a * shapes[0])
    y = SMALL * x - play(np.append(x, x), law.limit, SMALL)[x.size :]
    exact = waves.conj().T @ y / x.size
    problem = ContactProblem.of(reduced, law, highest=3).on(Discretisation(256, 64), 1e-8)
    terms, size = problem.solve([a]), np.abs(exact).max()
    np.testing.assert_allclose(terms.S[0], shapes[0] * exact[:2], rtol=0, atol=1e-3 * size)
    mixed = terms.P[0, terms.orders.index((2, -1)), 0]
    assert mixed == pytest.approx(exact[2], abs=1e-3 * size)
    loss = -2.0 * (a * terms.S[0].imag) @ reduced.carrier
    assert terms.power[0] == pytest.approx(loss, rel=1e-5)


# Rigid friction


def one_mode(mode, **parameters):
    return rom.reduce(rom.two_mass(**parameters), modes=(mode,), formulation="paper")


def one_coulomb_contact(reduced, amplitude):
    """Q of one mode that slips at its own contact only: the loop of a play operator."""
    own = reduced.modes[0]
    k, K = abs(reduced.coupling[0, own]), reduced.stiffness[own, own]
    r = np.minimum(LIMIT / (2 * k * amplitude), 1.0)
    root = np.sqrt(r * (1 - r))
    real = np.pi / 2 + np.arcsin(1 - 2 * r) + 2 * (1 - 2 * r) * root
    return k**2 / K * (real - 4j * r * (1 - r)) / np.pi


def friction_function(reduced, law, amplitude, steps):
    problem = ContactProblem.of(reduced, law).on(Discretisation(steps, 1), 1e-10)
    return problem.solve(amplitude[:, np.newaxis])


# One mode, the other contact stuck: up to the B that also moves contact 1
RANGES = {0: np.linspace(0.1, 4.0, 40), 1: np.linspace(0.1, 2.5, 25)}


@pytest.mark.oracle
@pytest.mark.parametrize("mode", RANGES)
def test_coulomb_friction_has_the_closed_form_to_second_order_in_the_steps(mode):
    """Where slip ends falls anywhere within a step, so that single halvings scatter."""
    reduced, amplitude = one_mode(mode), RANGES[mode]
    exact, errors = one_coulomb_contact(reduced, amplitude), []
    for steps in (128, 512, 2048):
        terms = friction_function(reduced, rom.Coulomb(LIMIT), amplitude, steps)
        errors.append(np.abs(terms.Q[:, 0] - exact).max())
    assert errors[-1] < 3e-6 * np.abs(exact).max()
    np.testing.assert_allclose(0.5 * np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.2)
    loss = -2.0 * reduced.carrier[0] * amplitude**2 * exact.imag
    np.testing.assert_allclose(terms.power, loss, rtol=0, atol=1e-4 * loss.max())
    stuck = 2.0 * amplitude * np.abs(reduced.coupling).max() < LIMIT
    assert stuck.any() and not terms.Q[stuck].any()


@pytest.mark.oracle
def test_tanh_friction_tends_to_coulomb_with_order_1_in_alpha():
    reduced, amplitude = one_mode(0), np.array([1.2, 2.0, 2.5, 4.0])
    exact = one_coulomb_contact(reduced, amplitude)
    errors = [
        np.abs(friction_function(reduced, law, amplitude, 2048).Q[:, 0] - exact).max()
        for law in (rom.Tanh(LIMIT, alpha) for alpha in (0.01, 0.005, 0.0025, 0.00125))
    ]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    # creep just below the limit is alpha log(...): order 1 is approached slowly
    np.testing.assert_allclose(orders, 1.0, atol=0.12)
    assert np.all(np.diff(orders) > 0)


@pytest.mark.oracle
@pytest.mark.parametrize("alpha", [0.1, 0.005, 0.001])
@pytest.mark.parametrize("size", [1.0, 1e-17])
def test_small_motion_sees_a_viscous_damper(alpha, size):
    """Two modes; friction and its power are in proportion however small the motion is."""
    reduced = rom.reduce(rom.two_mass(), formulation="paper")
    damper, a = LIMIT / alpha * np.eye(2), size * np.array([1e-3, 1e-4])
    problem = ContactProblem.of(reduced, rom.Tanh(LIMIT, alpha)).on(Discretisation(1024, 4), 1e-8)
    terms = problem.solve([a])
    for j, (omega, coupling) in enumerate(zip(reduced.frequency, reduced.coupling, strict=True)):
        x = -np.linalg.solve(reduced.stiffness + 1j * omega * damper, coupling)
        np.testing.assert_allclose(
            terms.P[0, j], a[j] * x, rtol=0, atol=1e-5 * np.abs(x * a[j]).max()
        )
        assert terms.Q[0, j] == pytest.approx(-coupling @ x, rel=1e-5)
    loss = -2.0 * reduced.carrier * a**2 * terms.Q[0].imag
    assert terms.power[0] == pytest.approx(loss.sum(), rel=1e-6)


@pytest.mark.oracle
@pytest.mark.parametrize("chi", [-0.2, -0.5, -0.8])
def test_sliders_of_an_iwan_joint_lose_the_energy_of_its_distribution(chi):
    """The integral of 4 R phi^(chi + 1) (X - phi) over 0 to X < macro-slip (Segalman 2005)."""
    law = rom.Iwan(force=2.0, stiffness=20.0, chi=chi, beta=0.3)
    share = law.beta + (chi + 1.0) / (chi + 2.0)
    largest = law.force * (1.0 + law.beta) / (law.stiffness * share)
    R = law.force * (chi + 1.0) / (largest ** (chi + 2.0) * share)
    limits, stiffnesses = law.distribution()
    assert stiffnesses.sum() == pytest.approx(law.stiffness)
    assert limits.sum() == pytest.approx(law.force)
    for X in np.geomspace(3e-3, 0.99, 100) * largest:
        exact = 4.0 * R * X ** (chi + 3.0) * (1.0 / (chi + 2.0) - 1.0 / (chi + 3.0))
        lost = sum(jenkins_dissipation(X, *pair) for pair in zip(limits, stiffnesses, strict=True))
        assert lost == pytest.approx(exact, rel=0.01)
