"""Large structures: one factorisation, by either solver; modes; what is refused."""

import sys

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from benchmarks.blade import blade
from slipmode import rom
from slipmode.rom import SlipmodeError
from slipmode.rom.structure import held
from slipmode.rom.structure.solvers import factorisation, mass
from slipmode.rom.structure.solvers.elimination import InteriorSolutions, eliminate
from slipmode.rom.structure.solvers.factorisation import NotPositiveDefiniteError, factorise
from slipmode.rom.structure.solvers.lowest_modes import lowest_modes, with_fixed_signs
from slipmode.rom.structure.solvers.mass import is_positive_mass, mobility
from slipmode.rom.structure.solvers.nested_dissection import nested_dissection

SOLVERS = ("pypardiso", "SuperLU")


@pytest.fixture(scope="module")
def matrices():
    return blade(500, 4)


@pytest.fixture(params=SOLVERS)
def solver(request, monkeypatch):
    """Each way to factorise a sparse matrix, where it is installed."""
    if request.param == "SuperLU":
        monkeypatch.setitem(sys.modules, "pypardiso", None)
    else:
        pytest.importorskip("pypardiso")
    return request.param


def free_chain(n):
    """n equal masses, springs between neighbours, no ground: mass, stiffness (sparse)."""
    ends = np.full(n, 2.0)
    ends[[0, -1]] = 1.0
    bands = [np.full(n - 1, -1.0), ends, np.full(n - 1, -1.0)]
    return scipy.sparse.eye_array(n), scipy.sparse.diags_array(bands, offsets=[-1, 0, 1])


def test_a_sparse_factorisation_solves(solver, matrices):
    stiffness = scipy.sparse.csc_array(matrices["stiffness"])
    factors = factorise(stiffness)
    chosen = factorisation.Pardiso if solver == "pypardiso" else factorisation.SuperLU
    assert isinstance(factors, chosen)
    exact = np.random.default_rng(1).standard_normal((stiffness.shape[0], 20))
    for x in (exact, exact[:, 0]):
        np.testing.assert_allclose(factors.solve(stiffness @ x), x, atol=1e-8)


def test_what_is_not_positive_definite_is_not_factorised(solver, matrices):
    shifted = scipy.sparse.csc_array(matrices["stiffness"] - 1e9 * matrices["mass"])
    assert (shifted.diagonal() > 0).all()
    with pytest.raises(NotPositiveDefiniteError):
        factorise(shifted)


def test_without_enough_memory_one_line_says_how_much_before_it_begins(
    solver, matrices, monkeypatch
):
    monkeypatch.setattr(factorisation, "available_memory", lambda: 1e5)
    with pytest.raises(SlipmodeError) as refusal:
        factorise(scipy.sparse.csc_array(matrices["stiffness"]))
    words = str(refusal.value)
    assert words.startswith("factorising stiffness (")
    assert "GiB are free" in words
    assert ("slipmode[fast]" in words) == (solver == "SuperLU")


def test_an_elimination_solves_with_springs_at_the_boundary(solver, matrices):
    """Errors seen: 1.2e-10 of S times its inverse, 3e-11 of the solution."""
    K = scipy.sparse.csc_array(matrices["stiffness"])
    size, rng = K.shape[0], np.random.default_rng(3)
    boundary = np.sort(rng.choice(size, 20, replace=False))
    found = eliminate(K, boundary)
    assert isinstance(found, factorisation.Pardiso if solver == "pypardiso" else InteriorSolutions)
    flexibility = np.linalg.inv(K.toarray())[np.ix_(boundary, boundary)]
    np.testing.assert_allclose(found.schur @ flexibility, np.eye(20), atol=1e-9)
    springs = K.diagonal()[boundary]
    exact = rng.standard_normal((size, 35))
    force = K @ exact
    force[boundary] += springs[:, np.newaxis] * exact[boundary]
    reduced = found.forward(force)
    reduced[boundary] = np.linalg.solve(found.schur + np.diag(springs), reduced[boundary])
    np.testing.assert_allclose(found.backward(reduced), exact, atol=1e-9)


def test_an_elimination_needs_a_positive_definite_interior_alone(solver):
    _, chain = free_chain(700)
    found = eliminate(scipy.sparse.csc_array(chain), np.array([0, 699]))
    np.testing.assert_allclose(found.schur * 699, [[1.0, -1.0], [-1.0, 1.0]], rtol=1e-9)
    softer = scipy.sparse.csc_array(chain - 1e-3 * scipy.sparse.eye_array(700))
    with pytest.raises(NotPositiveDefiniteError):
        eliminate(softer, np.array([0]))


def test_one_line_says_what_would_be_faster(matrices, monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "pypardiso", None)
    monkeypatch.setattr(factorisation, "LARGE", 600)
    factorise(scipy.sparse.csc_array(matrices["stiffness"]))
    (record,) = caplog.records
    assert "pip install 'slipmode[fast]' (PARDISO) needs less time and memory" in record.message


def test_a_dissection_is_a_permutation_that_fills_little():
    from scipy.sparse.linalg import splu

    stiffness = scipy.sparse.csc_array(blade(3000, 1)["stiffness"])
    order, expected = nested_dissection(stiffness)
    np.testing.assert_array_equal(np.sort(order), np.arange(stiffness.shape[0]))

    def fill(matrix, order):
        options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        return splu(matrix, order, **options).nnz

    ordered = stiffness[order][:, order].tocsc()
    entries = fill(ordered, "NATURAL")
    assert entries < 1.4 * fill(stiffness, "MMD_AT_PLUS_A")  # large ones: 0.4
    assert 0.8 < 2 * expected / entries < 1.5  # what memory is told from


@pytest.mark.slow
def test_lanczos_finds_the_modes_of_a_dense_solution(matrices):
    K, M = (scipy.sparse.csc_array(matrices[name]) for name in ("stiffness", "mass"))
    squares, shapes = lowest_modes(factorise(K).solve, lambda x: M @ x, K.shape[0], 20)
    exact = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True, subset_by_index=(0, 19))
    np.testing.assert_allclose(squares, exact, rtol=1e-7)  # rounding of the dense solution
    np.testing.assert_allclose(shapes.T @ (M @ shapes), np.eye(20), atol=1e-10)
    residual = K @ shapes - (M @ shapes) * squares
    assert np.linalg.norm(residual) < 1e-6 * np.linalg.norm(K @ shapes)
    reach = exact[11] / exact[1] * 1.0001
    found = lowest_modes(
        *(factorise(K).solve, lambda x: M @ x, K.shape[0], 2), lambda squares: reach * squares[1]
    )
    assert len(found[0]) == 12


def test_lanczos_finds_equal_frequencies():
    grounded = free_chain(100)[1] + 1e-3 * scipy.sparse.eye_array(100)
    K = scipy.sparse.csc_array(scipy.sparse.kron(grounded, np.eye(6)))
    squares, _ = lowest_modes(factorise(K).solve, lambda x: x, K.shape[0], 12)
    exact = np.repeat(1e-3 + 4.0 * np.sin(np.arange(2) * np.pi / 200) ** 2, 6)
    np.testing.assert_allclose(squares, exact, rtol=1e-11)


def test_lanczos_finds_the_modes_of_hermitian_matrices():
    chain = (free_chain(300)[1] + 0.1 * scipy.sparse.eye_array(300)).toarray()
    A = chain + 0.3j * (np.triu(chain, 1) - np.tril(chain, -1))
    squares, shapes = lowest_modes(lambda y: scipy.linalg.solve(A, y), lambda y: 2.0 * y, 300, 12)
    exact = scipy.linalg.eigh(0.5 * A, eigvals_only=True)
    np.testing.assert_allclose(squares, exact[:12], rtol=1e-10)
    np.testing.assert_allclose(2.0 * shapes.conj().T @ shapes, np.eye(12), atol=1e-10)
    np.testing.assert_allclose(A @ shapes, 2.0 * shapes * squares, atol=1e-8)


def test_the_sign_of_an_antisymmetric_mode_does_not_depend_on_rounding():
    shape = np.array([[0.1], [-0.8], [-1.0], [1.0], [0.8]])
    for rounded in (shape, -shape):
        for more in (2, 3):
            each = rounded.copy()
            each[more] *= 1.0 + 1e-15
            np.testing.assert_allclose(with_fixed_signs(each), -shape, rtol=1e-14)


@pytest.mark.parametrize("law", [None, rom.Jenkins(1.0, 1e7)], ids=["rigid", "elastic"])
def test_a_large_sparse_structure_is_reduced_as_its_dense_copy(law, solver, matrices):
    damping = 1e-7
    sparse = rom.Structure(**matrices, damping=damping)
    full = {name: matrices[name].toarray() for name in ("mass", "stiffness")}
    dense = rom.Structure(**full, contact=matrices["contact"], damping=damping)
    found, expected = (rom.reduce(each, law=law) for each in (sparse, dense))
    np.testing.assert_allclose(found.frequency, expected.frequency, rtol=1e-9)
    for name in ("stiffness", "carried_mass", "damping", "mass"):
        a, b = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(b).max(initial=0.0))
    turn = np.sign(np.sum(found.mode_shapes * expected.mode_shapes, axis=0))
    np.testing.assert_allclose(
        found.spring * turn[:, np.newaxis],
        expected.spring,
        atol=1e-6 * np.abs(expected.spring).max(),
    )


@pytest.mark.parametrize("law", [None, rom.Jenkins(1.0, 1e7)], ids=["rigid", "elastic"])
def test_the_stiffness_is_factorised_once(law, matrices, monkeypatch):
    calls = []

    def counted(matrix, name="stiffness"):
        calls.append(name)
        return factorise(matrix, name)

    monkeypatch.setattr(held, "factorise", counted)
    structure = rom.Structure(**matrices)
    reduced = rom.reduce(structure, law=law)
    from slipmode.rom.reduction.force_response import AppliedForces
    from slipmode.rom.validity import separation_findings

    monkeypatch.setattr(held, "lowest_modes", None)  # once too
    assert AppliedForces.of(reduced, ({5: 1.0}, {8: 1.0}), structure).static.any()
    separation_findings(structure, reduced)
    assert calls == ["stiffness"]


def test_a_large_mass_matrix_is_not_factorised(matrices, monkeypatch):
    monkeypatch.setattr(mass, "factorise", None)
    M = scipy.sparse.csc_array(matrices["mass"])
    assert M.shape[0] > 500
    assert is_positive_mass(M)
    assert not is_positive_mass(M - 0.2 * scipy.sparse.diags_array(M.diagonal()))
    W = scipy.sparse.csc_array(np.eye(M.shape[0])[:, matrices["contact"]])
    exact = np.linalg.inv(M.toarray())[np.ix_(matrices["contact"], matrices["contact"])]
    np.testing.assert_allclose(mobility(M, W), exact, atol=1e-7 * exact.max())


@pytest.mark.parametrize("n", [40, 600])
def test_a_structure_that_floats_has_its_static_motion_without_rigid_bodies(n):
    mass, stiffness = free_chain(n)
    structure = rom.Structure(mass, stiffness, contact=[0, n - 1])
    open_contacts = held.stuck(structure, np.zeros(2))
    frequency, shapes = open_contacts.modes(4)
    exact = 2.0 * np.sin(np.arange(4) * np.pi / (2 * n))
    np.testing.assert_allclose(frequency, exact, rtol=1e-8)
    assert frequency[0] == 0.0
    load = np.zeros((n, 1))
    load[0] = 1.0
    moved = open_contacts.solve(load)
    inverse = np.linalg.pinv(stiffness.toarray(), hermitian=True, rtol=1e-12)
    np.testing.assert_allclose(moved, inverse @ load, atol=1e-9 * np.abs(moved).max())
    assert shapes.shape == (n, 4)


def test_low_modes_of_a_slender_body_are_no_rigid_bodies():
    """omega_1^2 is 1e-10 of the stiffest DOF's: as of a blade of a million DOFs."""
    n = 40_000
    mass, stiffness = free_chain(n)
    ground = scipy.sparse.csc_array(([1.0], ([0], [0])), shape=(n, n))
    structure = rom.Structure(mass, stiffness + ground, contact=[n - 1])
    frequency, _ = held.stuck(structure, np.zeros(1)).modes(2)
    np.testing.assert_allclose(frequency, [np.pi / (2 * n), 3 * np.pi / (2 * n)], rtol=1e-4)
    assert frequency[0] ** 2 / 2.0 < 1e-9
