"""Reduced models against the matrices of the whole structure."""

from itertools import product

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
from beside_oracle import with_laws
from oracles.closed_forms import jenkins_dissipation, jenkins_first_harmonic

from slipmode import rom

pytestmark = pytest.mark.quick

SPRINGS = np.array([5.0, 7.0])
STUCK = rom.Jenkins(limit=1.0, stiffness=tuple(SPRINGS))
DAMPINGS = {
    "proportional": lambda K: 0.01 * K,
    "dashpots": lambda K: 0.01 * K + np.diag(np.linspace(0.0, 0.1, len(K))),
}
LAWS = {"bonded": None, "stuck": STUCK}


def chain(damping=DAMPINGS["dashpots"], store=np.asarray, n=10):
    """Unequal masses between two walls, with two contacts between neighbours."""
    springs = np.full(n + 1, 4.0)
    springs[[3, 7]] = 30.0
    K = np.diag(springs[:-1] + springs[1:])
    K -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    W = np.zeros((n, 2))
    W[[2, 3], 0], W[[6, 7], 1] = (-1, 1), (-1.0, 0.7)
    M = np.diag(1.0 + 0.1 * np.arange(n) % 0.5)
    return rom.Structure(store(M), store(K), damping(K), contact=W)


def matrices(structure, law):
    """M, C, K with the springs of stuck contacts, W, and a basis of the allowed motion."""
    system = with_laws(structure, ())
    M, C, K, W = system.M, system.C, system.K, system.W
    if law is None:
        return M, C, K, W, scipy.linalg.null_space(W.T)
    return M, C, K + (W * SPRINGS) @ W.T, W, np.eye(len(M))


def flexibility(structure, law, nu, without):
    """W^T D^-1 W at the frequency nu, where the modes `without` (n, k) cannot move."""
    M, C, K, W, _ = matrices(structure, law)
    basis = scipy.linalg.null_space((M @ without).T) if without.size else np.eye(len(M))
    D = basis.T @ (K + 1j * nu * C - nu**2 * M) @ basis
    return W.T @ basis @ np.linalg.solve(D, basis.T @ W)


def found_flexibility(reduced, nu, held):
    """As the contact problem has it: of the contacts, or of the force deficit of elastic ones."""
    K = reduced.stiffness + 1j * nu * reduced.damping - nu**2 * reduced.mass
    if reduced.contacts is None:
        return np.linalg.inv(K - reduced.reaction(nu, held))
    return reduced.reaction(nu, held) - reduced.stiffness


@pytest.mark.oracle
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("store", [np.asarray, scipy.sparse.csr_array])
def test_modes_are_the_lowest_of_the_structure_with_held_contacts(law, store):
    structure = chain(store=store)
    reduced = rom.reduce(structure, (0, 2), law=law)
    M, C, K, W, allowed = matrices(structure, law)
    squares, shapes = scipy.linalg.eigh(*(allowed.T @ each @ allowed for each in (K, M)))
    shapes = (allowed @ shapes)[:, [0, 2]]
    np.testing.assert_allclose(reduced.frequency**2, squares[[0, 2]], rtol=1e-12)
    phi = reduced.mode_shapes
    np.testing.assert_allclose(np.abs(phi.T @ M @ shapes), np.eye(2), atol=1e-12)
    np.testing.assert_allclose(reduced.modal_damping, np.diag(phi.T @ C @ phi), rtol=1e-12)
    np.testing.assert_allclose(np.diag(phi.T @ M @ phi), 1.0, rtol=1e-12)
    if law is None:
        # of all motions with unit contact displacement and no share of the modes, the static one
        X = reduced.contact_shapes
        np.testing.assert_allclose(W.T @ X, np.eye(2), atol=1e-13)
        np.testing.assert_allclose(phi.T @ M @ X, 0.0, atol=1e-12)
        static = np.linalg.solve(K, W) @ np.linalg.inv(W.T @ np.linalg.solve(K, W))
        np.testing.assert_allclose(X, static - phi @ phi.T @ M @ static, atol=1e-12)
    else:
        residual = np.linalg.solve(K, W) - (shapes / squares[[0, 2]]) @ shapes.T @ W
        np.testing.assert_allclose(reduced.contact_shapes, residual, atol=1e-12)


@pytest.mark.oracle
@pytest.mark.parametrize("damping", DAMPINGS.values(), ids=DAMPINGS)
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("modes", [(0, 1), (3, 1), (2,)])
def test_contacts_feel_the_dynamic_stiffness_of_the_structure_at_every_frequency(
    damping, law, modes
):
    """All modes are kept, so that nothing is neglected; also with some of them held."""
    structure = chain(damping)
    reduced = rom.reduce(structure, modes, law=law)
    assert reduced.nonresonant_frequency.size == (10 if law else 8) - len(modes)
    carrier = reduced.frequency[0]
    for nu, held in product((0.0, 0.3, carrier, 4.0), product([False, True], repeat=len(modes))):
        expected = flexibility(structure, law, nu, reduced.mode_shapes[:, np.array(held)])
        found = found_flexibility(reduced, nu, held)
        np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())


@pytest.mark.oracle
@pytest.mark.parametrize("law", [None, rom.Jenkins(1.0, 1.0)], ids=["bonded", "stuck"])
def test_modes_that_follow_statically_have_an_error_of_order_four(law):
    """Their flexibility and inertia are exact: nu^4 / omega^4 is neglected."""
    n = 40
    K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    structure = rom.Structure(np.eye(n), K, 0.0, contact=[9, 20])
    reduced = rom.reduce(structure, (0,), law=law, smallest_response=1.0)
    assert reduced.nonresonant_frequency.size < 25
    W = np.eye(n)[:, [9, 20]]
    stuck = K + (0.0 if law is None else 1.0) * W @ W.T
    errors = []
    for nu in (0.02, 0.01, 0.005):  # the lowest mode is at 0.077
        exact = W.T @ np.linalg.solve(stuck - nu**2 * np.eye(n), W)
        errors.append(np.abs(found_flexibility(reduced, nu, [False]) - exact).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4.0, atol=0.2)


@pytest.mark.oracle
def test_the_papers_formulation_condenses_the_structure_statically():
    structure = chain()
    _, _, K, W, _ = matrices(structure, None)
    reduced = rom.reduce(structure, formulation="paper")
    np.testing.assert_allclose(
        np.linalg.inv(reduced.stiffness), W.T @ np.linalg.solve(K, W), rtol=1e-11
    )
    static = np.linalg.solve(K, W) @ reduced.stiffness
    np.testing.assert_allclose(reduced.contact_shapes, static, atol=1e-12)
    R = np.asarray(structure.partition().R)  # moves one DOF of each contact
    np.testing.assert_allclose(reduced.coupling, reduced.mode_shapes.T @ K @ R, atol=1e-12)
    assert not reduced.damping.any() and not reduced.mass.any()


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:friction is zero")
def test_dampers_between_modes_act_on_the_steady_state():
    """The response at both carriers is that of the full matrices, friction aside."""
    base = rom.two_mass()
    C = np.array(base.damping) + 0.02 * np.pad([[2.0, -1.0], [-1.0, 2.0]], (0, 2))
    structure = rom.Structure(base.mass, base.stiffness, C, contact=(2, 3))
    frequency = (0.98, 1.65)
    reduced = rom.reduce(structure, carrier=frequency)
    model = rom.tabulate(reduced, rom.Tanh(0.0, 0.02), (4.0, 4.0), tolerance=1e-4, warned=False)
    for mode, Omega in enumerate(frequency):
        D = structure.stiffness + 1j * Omega * C - Omega**2 * structure.mass
        x = np.linalg.solve(D, 0.05 * np.eye(4)[mode])
        forces = [{mode: 0.1}, {1: 0.0}] if mode == 0 else [{0: 0.0}, {mode: 0.1}]
        a = rom.steady(model, frequency, forces)[mode]
        assert a == pytest.approx(x[mode], rel=1e-4)  # 8e-3 without them


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("frequencies", "until"),
    [((1.0, 3.05), None), ((1.0, 1.95), None), ((1.0, 1.4), (1.0, 1.75)), ((1.0, 1.22), None)],
)
@pytest.mark.parametrize("even", [False, True])
def test_combination_resonances_are_the_harmonics_near_a_carrier(frequencies, until, even):
    """By counting: |n Omega_A + m Omega_B - Omega_j| < 0.1 Omega_j up to order 7, 0.01 to 9."""
    ends = np.array([frequencies, frequencies if until is None else until])
    expected = set()
    for n, m, j in product(range(-9, 10), range(-9, 10), (0, 1)):
        order = abs(n) + abs(m)
        if order < 2 or order > 9 or not (even or order % 2):
            continue
        off = ends @ [n, m] - ends[:, j]
        near = np.any(np.abs(off) < (0.1 if order <= 7 else 0.01) * ends[:, j])
        if near or off[0] * off[1] < 0.0:
            expected.add((j, n, m))
    named = rom.combination_resonances([frequencies], until and [until], even)
    found = [(each.mode, each.n, each.m) for each in named]
    if len(expected) <= 8:
        assert set(found) == expected
    else:
        assert len(found) == 8 and set(found) < expected
    orders = [abs(n) + abs(m) for _, n, m in found]
    assert orders == sorted(orders) and len(set(found)) == len(found)
    lowest = sorted(abs(n) + abs(m) for _, n, m in expected)
    assert orders == lowest[:8]


LIMIT, STIFFNESS, SPRING, DAMPER = 1.0, 1e3, 1e4, 0.1
JENKINS = rom.Jenkins(LIMIT, STIFFNESS)


@pytest.mark.oracle
def test_one_dof_with_a_contact_follows_the_describing_function():
    structure = rom.Structure([[1.0]], [[SPRING]], [[DAMPER]], contact=(0,))
    reduced = rom.reduce(structure, (0,), law=JENKINS)
    model = rom.tabulate(reduced, JENKINS, (5e-3,), 1e-3, warned=False)
    assert reduced.stiffness[0, 0] == 0.0  # no residual flexibility
    curve = rom.backbone(model, amplitude=np.geomspace(2e-4, 4.9e-3, 20))
    for a, frequency, damping in zip(curve.amplitude, curve.frequency, curve.damping, strict=True):
        X = 2.0 * a
        k = jenkins_first_harmonic(X, LIMIT, STIFFNESS).real / X
        lost = jenkins_dissipation(X, LIMIT, STIFFNESS) / (np.pi * X**2)
        # the tolerance of the table, of STIFFNESS
        assert frequency == pytest.approx(np.sqrt(SPRING + k), rel=5e-4 * STIFFNESS / SPRING)
        # and the third harmonic of the force, at most 0.3 of the stuck force, on 8 SPRING
        expected = (DAMPER * frequency + lost) / (2.0 * frequency**2)
        assert damping == pytest.approx(expected, rel=1e-3 + 0.3 * STIFFNESS / (8 * SPRING))
