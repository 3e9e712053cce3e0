"""Reduction: identities of the modes, refusals, and the linear case against a direct solve."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from slipmode.rom import SlipmodeError, Structure, Tanh, reduce, steady, tabulate, two_mass
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.nonresonant import with_responding

pytestmark = pytest.mark.quick

N_CHAIN = 6
CHAIN_CONTACTS = {"index": (2, 5), "relative": [(1, 0), (-1, 0), (0, 0), (0, 1), (0, -1), (0, 0)]}


def chain(contact, beta=0.01, store=np.array):
    """Six masses between two walls, stiff joints at 0-1 and 3-4; contact: DOFs or W."""
    springs = np.array([1.0, 40.0, 0.9, 1.1, 50.0, 0.8, 1.0])
    stiffness = np.diag(springs[:-1] + springs[1:])
    stiffness -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    mass = np.diag([1.0, 1.3, 0.8, 1.1, 0.9, 1.2])
    return Structure(store(mass), store(stiffness), beta, contact=contact)


def selection(dofs):
    return np.eye(N_CHAIN)[:, list(dofs)]


def assert_same_reduction(first, second, rtol=1e-10):
    shapes, matrices = ("mode_shapes", "contact_shapes"), ("mass", "damping", "stiffness")
    for name in ("frequency", "modal_damping", *shapes, *matrices, "spring", "damper", "coupling"):
        expected = getattr(second, name)
        atol = rtol * np.abs(expected).max()
        np.testing.assert_allclose(getattr(first, name), expected, rtol=rtol, atol=atol)


STRUCTURES = {
    "two-mass": two_mass(),
    "chain": chain(CHAIN_CONTACTS["index"]),
    "chain, relative contacts": chain(CHAIN_CONTACTS["relative"]),
}


# Identities


@pytest.mark.parametrize("name", STRUCTURES)
def test_modes_are_those_of_the_bonded_structure(name):
    structure = STRUCTURES[name]
    reduced = reduce(structure)
    phi = reduced.mode_shapes
    np.testing.assert_allclose(structure.directions.T @ phi, 0, atol=1e-14)
    np.testing.assert_allclose(phi.T @ structure.mass @ phi, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(
        phi.T @ structure.stiffness @ phi, np.diag(reduced.frequency**2), atol=1e-12
    )
    # the lowest ones: a basis of the motion that leaves the contacts at rest has no lower
    basis = scipy.linalg.null_space(structure.directions.T)
    squares = scipy.linalg.eigvalsh(
        basis.T @ structure.stiffness @ basis, basis.T @ structure.mass @ basis
    )
    np.testing.assert_allclose(reduced.frequency**2, squares[:2], rtol=1e-12)


@pytest.mark.parametrize("formulation", ["paper", "consistent"])
@pytest.mark.parametrize("name", STRUCTURES)
def test_contact_shapes_move_their_own_contact_by_one(name, formulation):
    structure = STRUCTURES[name]
    reduced = reduce(structure, formulation=formulation)
    np.testing.assert_allclose(
        structure.directions.T @ reduced.contact_shapes, np.eye(2), atol=1e-14
    )


@pytest.mark.parametrize("name", STRUCTURES)
def test_contact_shapes_have_no_share_of_the_retained_modes(name):
    """What a mode carries is not counted twice, and no inertia couples it to the contacts."""
    structure = STRUCTURES[name]
    reduced = reduce(structure)
    phi, shapes = reduced.mode_shapes, reduced.contact_shapes
    np.testing.assert_allclose(phi.T @ structure.mass @ shapes, 0, atol=1e-13)
    np.testing.assert_allclose(phi.T @ structure.stiffness @ shapes, reduced.spring, atol=1e-12)
    np.testing.assert_allclose(phi.T @ structure.damping @ shapes, reduced.damper, atol=1e-14)


@pytest.mark.parametrize("formulation", ["paper", "consistent"])
@pytest.mark.parametrize("name", STRUCTURES)
def test_the_contact_problem_is_symmetric_and_dissipates(name, formulation):
    reduced = reduce(STRUCTURES[name], formulation=formulation)
    for name in ("mass", "damping", "stiffness"):
        matrix = getattr(reduced, name)
        np.testing.assert_array_equal(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() >= 0
    assert np.linalg.eigvalsh(reduced.stiffness).min() > 0
    assert (formulation == "paper") == (not reduced.mass.any())


def test_paper_condenses_the_elastic_coordinates():
    reduced = reduce(two_mass(), formulation="paper")
    np.testing.assert_allclose(reduced.stiffness, [[20, 5], [5, 40]], rtol=1e-14)
    np.testing.assert_allclose(reduced.coupling, [[-1, 0], [0, -2.89]], rtol=1e-14)
    assert not reduced.damping.any()


def test_retaining_every_mode_leaves_no_residual_flexibility():
    reduced = reduce(two_mass(beta=0.01))
    np.testing.assert_allclose(reduced.stiffness, [[21, 5], [5, 42.89]], rtol=1e-14)
    np.testing.assert_allclose(reduced.damping, 0.01 * reduced.stiffness, rtol=1e-14)
    np.testing.assert_allclose(reduced.mass, 0.01 * np.eye(2), rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(reduced.contact_shapes, np.eye(4)[:, 2:], atol=1e-15)


# One structure, several descriptions


@pytest.mark.parametrize("formulation", ["paper", "consistent"])
def test_contact_dofs_are_the_directions_of_the_unit_matrix(formulation):
    dofs = CHAIN_CONTACTS["index"]
    by_index, by_matrix = (
        reduce(chain(contact), formulation=formulation) for contact in (dofs, selection(dofs))
    )
    assert_same_reduction(by_matrix, by_index)


@pytest.mark.parametrize("formulation", ["paper", "consistent"])
@pytest.mark.parametrize("contact", CHAIN_CONTACTS.values(), ids=CHAIN_CONTACTS)
def test_sparse_equals_dense(contact, formulation):
    sparse, dense = (
        reduce(chain(contact, store=store), formulation=formulation)
        for store in (scipy.sparse.csr_array, np.array)
    )
    assert_same_reduction(sparse, dense)


def test_large_sparse_structures_have_the_modes_of_dense_ones():
    n = 520
    mass = scipy.sparse.eye_array(n, format="csc")
    diagonals = [-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)]
    stiffness = scipy.sparse.diags_array(diagonals, offsets=[-1, 0, 1], format="csc") * n**2
    sparse = Structure(mass, stiffness, 1e-4, contact=[n // 3])
    dense = Structure(mass.toarray(), stiffness.toarray(), 1e-4, contact=[n // 3])
    assert_same_reduction(reduce(sparse), reduce(dense), rtol=1e-7)


def test_turned_coordinates_leave_the_reduced_model_as_it_is():
    """Up to the sign of a mode, whatever DOFs the contacts are eliminated through.

    In the paper's formulation the coupling depends on that choice.
    """
    dofs = CHAIN_CONTACTS["index"]
    plain = chain(dofs)
    T = np.linalg.qr(np.random.default_rng(5).normal(size=(N_CHAIN, N_CHAIN)))[0]
    turned = Structure(
        T @ plain.mass @ T.T, T @ plain.stiffness @ T.T, 0.01, contact=T @ selection(dofs)
    )
    expected, reduced = reduce(plain), reduce(turned)
    sign = np.sign(np.sum(reduced.mode_shapes * (T @ expected.mode_shapes), axis=0))
    turned_back = replace(
        reduced,
        mode_shapes=T.T @ reduced.mode_shapes * sign,
        contact_shapes=T.T @ reduced.contact_shapes,
        spring=sign[:, np.newaxis] * reduced.spring,
        damper=sign[:, np.newaxis] * reduced.damper,
    )
    assert_same_reduction(turned_back, expected, rtol=1e-11)


# Modes that are not retained


def far_and_near(damping):
    """Ten masses between walls, joined softly to one another at two contacts."""
    springs = np.full(11, 4.0)
    springs[[3, 7]] = 30.0
    stiffness = np.diag(springs[:-1] + springs[1:])
    stiffness -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    contact = np.zeros((10, 2))
    contact[[2, 3], 0], contact[[6, 7], 1] = (-1, 1), (-1, 1)
    return Structure(np.eye(10), stiffness, damping(stiffness), contact=contact)


DAMPINGS = {
    "proportional": lambda stiffness: 0.01 * stiffness,
    "dashpots": lambda stiffness: 0.01 * stiffness + np.diag(np.linspace(0.0, 0.1, 10)),
}


def contact_stiffness(structure, nu):
    """Of the structure at the frequency nu, without friction: its inverse is W^T D^-1 W."""
    W = structure.directions
    return np.linalg.inv(W.T @ np.linalg.solve(dynamic_stiffness(structure, 0.0, nu), W))


@pytest.mark.parametrize("damping", DAMPINGS.values(), ids=DAMPINGS)
def test_the_structure_acts_on_contacts_at_every_harmonic_that_modes_respond_to(damping):
    structure = far_and_near(damping)
    reduced = reduce(structure)
    assert 1 <= reduced.nonresonant_frequency.size < 8
    without, _ = with_responding(reduced, np.inf)
    without = replace(without, carried_mass=np.zeros((2, 2)))
    errors = []
    for nu in reduced.frequency @ np.array(harmonic_orders(5, 2)).T:
        exact = contact_stiffness(structure, nu)
        scale = np.abs(exact).max()
        inert = reduced.stiffness + 1j * nu * reduced.damping - nu**2 * reduced.mass
        found = (inert - each.reaction(nu) for each in (reduced, without))
        errors.append([np.abs(each - exact).max() / scale for each in found])
    assert np.max(errors, axis=0)[0] < 1e-10  # the modes left out do not move the contacts
    assert np.max(errors, axis=0)[1] > 0.2


def test_a_structure_without_further_modes_has_no_nonresonant_ones():
    reduced = reduce(two_mass())
    assert reduced.nonresonant_frequency.size == 0
    assert not reduced.carried_mass.any() and not reduced.damping_coupling.any()


def test_dampers_between_modes_act_off_the_diagonal():
    """The response at both carriers is that of the full matrices, friction aside."""
    base = two_mass()
    dashpots = np.array(base.damping) + 0.02 * np.pad([[2.0, -1.0], [-1.0, 2.0]], (0, 2))
    structure = Structure(base.mass, base.stiffness, dashpots, contact=(2, 3))
    reduced = reduce(structure).at_carrier((0.98, 1.65))
    model = tabulate(reduced, Tanh(0.0, 0.02), (4.0, 4.0), tolerance=1e-4)
    for mode, Omega in enumerate(reduced.carrier):
        a = steady_amplitude(model, Omega, mode, mode, 0.1)
        x = direct_response(structure, 0.0, Omega, 0.1 * np.eye(4)[mode])
        assert a == pytest.approx(x[mode], rel=1e-4)  # 8e-3 without them


# Linear contacts: the reduced model against (K + i Omega C - Omega^2 M) x = f


def dynamic_stiffness(structure, dashpot, Omega):
    """K + i Omega (C + dashpot W W^T) - Omega^2 M."""
    W = structure.directions
    damping = structure.damping + dashpot * W @ W.T
    return structure.stiffness + 1j * Omega * damping - Omega**2 * structure.mass


def direct_response(structure, dashpot, Omega, force):
    """Complex amplitude of every DOF under f cos(Omega t), x = 2 Re(amplitude exp(i Omega t))."""
    dynamic = dynamic_stiffness(structure, dashpot, Omega)
    return np.linalg.solve(dynamic, 0.5 * np.asarray(force, dtype=complex))


def steady_amplitude(model, Omega, mode, dof, force):
    """a_j with mode j alone forced, at one DOF."""
    frequency, forces = model.reduced.frequency.copy(), [{dof: 0.0}, {dof: 0.0}]
    frequency[mode], forces[mode] = Omega, {dof: force}
    return steady(model, frequency, forces)[mode]


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize(
    "law", [Tanh(0.0, 0.02), Tanh(2.0, 20.0)], ids=["frictionless", "viscous"]
)
@pytest.mark.parametrize("name", ["two-mass", "chain, relative contacts"])
def test_linear_contacts_move_as_in_a_direct_solve(name, law, mode):
    """Also where the force acts on other modes and on the contacts, not along L_j."""
    structure, reduced, force = STRUCTURES[name], reduce(STRUCTURES[name]), 1e-3
    phi, dashpot = reduced.mode_shapes[:, mode], law.limit / law.alpha
    Omega, dof = 0.98 * reduced.frequency[mode], int(np.abs(phi).argmax())
    pattern = force * np.eye(structure.n_dofs)[dof]
    x = direct_response(structure, dashpot, Omega, pattern)
    exact_a = phi @ structure.mass @ x
    carrier = np.where(np.arange(2) == mode, Omega, reduced.frequency)
    model = tabulate(reduced.at_carrier(carrier), law, 2 * (1.2 * abs(exact_a),), tolerance=2e-4)
    a = steady_amplitude(model, Omega, mode, dof, force)
    # measured 1.0e-4 (two-mass: the table), 4e-6 (chain)
    assert a / exact_a == pytest.approx(1.0, abs=2e-4)


@pytest.mark.parametrize("mode", [0, 1])
def test_a_carrier_at_the_natural_frequency_costs_little(mode):
    """Two percent beside it: harmonics and contact damping at the wrong frequencies."""
    structure = two_mass()
    Omega = 0.98 * (1.0, 1.7)[mode]
    pattern = 1e-3 * np.eye(4)[mode]
    exact_a = direct_response(structure, 0.1, Omega, pattern)[mode]
    model = tabulate(reduce(structure), Tanh(2.0, 20.0), 2 * (1.2 * abs(exact_a),), 2e-4)
    a = steady_amplitude(model, Omega, mode, mode, 1e-3)
    assert a == pytest.approx(exact_a, rel=1.4e-3)  # measured 1.2e-3 (A), 0.9e-3 (B)


# Refusals


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"modes": ()}, "modes: must be one or two different modes"),
        ({"modes": (0, 1, 2)}, "modes: must be one or two different modes"),
        ({"modes": (1, 1)}, "modes: must be one or two different modes"),
        ({"modes": (0, 2)}, "modes: must be 0 to 1"),
        ({"modes": (-1,)}, "modes: must be 0 to 1"),
        ({"formulation": "exact"}, "formulation: must be 'consistent' or 'paper'"),
    ],
)
def test_refuses_in_one_line(arguments, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        reduce(two_mass(), **arguments)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("store", [np.array, scipy.sparse.csc_array])
def test_refuses_a_structure_that_floats_with_stuck_contacts(store):
    stiffness = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    floating = Structure(store(np.eye(3)), store(stiffness), contact=[2])
    with pytest.raises(SlipmodeError, match="rigid-body mode"):
        reduce(floating, modes=(0,))
