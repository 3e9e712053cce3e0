"""Large sparse structures: modes, static solutions and reductions, by each solver."""

import sys

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from benchmarks.blade import blade
from slipmode import rom

pytestmark = pytest.mark.filterwarnings("ignore:mode . has an implausible frequency")


@pytest.fixture(scope="module")
def matrices():
    found = blade(500, 4)
    assert found["mass"].shape[0] > 500  # above the size of dense algorithms
    return found


@pytest.fixture(params=["pypardiso", "SuperLU"])
def solver(request, monkeypatch):
    """Each way to factorise a sparse matrix, where it is installed."""
    if request.param == "SuperLU":
        monkeypatch.setitem(sys.modules, "pypardiso", None)
    else:
        pytest.importorskip("pypardiso")


def free_chain(n):
    """n equal masses, springs between neighbours, no ground: mass, stiffness (sparse)."""
    ends = np.full(n, 2.0)
    ends[[0, -1]] = 1.0
    bands = [np.full(n - 1, -1.0), ends, np.full(n - 1, -1.0)]
    return scipy.sparse.eye_array(n), scipy.sparse.diags_array(bands, offsets=[-1, 0, 1])


@pytest.mark.oracle
@pytest.mark.parametrize("law", [None, rom.Jenkins(1.0, 1e7)], ids=["rigid", "elastic"])
def test_reductions_are_those_of_dense_algebra(law, solver, matrices):
    """Modes by scipy.linalg.eigh, the dynamic stiffness of the contacts by a direct solve."""
    structure = rom.Structure(**matrices, damping=1e-7)
    M, K = matrices["mass"].toarray(), matrices["stiffness"].toarray()
    contact, n = matrices["contact"], len(M)
    W = np.eye(n)[:, contact]
    stuck = K if law is None else K + 1e7 * W @ W.T
    free = np.setdiff1d(np.arange(n), contact) if law is None else np.arange(n)
    at = np.ix_(free, free)
    squares = scipy.linalg.eigh(stuck[at], M[at], eigvals_only=True, subset_by_index=(0, 11))
    reduced = rom.reduce(structure, law=law)
    np.testing.assert_allclose(reduced.frequency**2, squares[:2], rtol=1e-7)
    table = rom.modes(structure, law, 12).states["bonded" if law is None else "stuck"]
    np.testing.assert_allclose(table.frequency**2, squares, rtol=1e-7)
    np.testing.assert_allclose(table.shapes.T @ M @ table.shapes, np.eye(12), atol=1e-10)
    largest = np.abs(table.shapes).max(axis=0)
    assert np.all((table.shapes > 0.7 * largest).any(axis=0))  # signs do not depend on rounding
    nu = 0.7 * reduced.frequency[0]
    flexibility = W.T @ np.linalg.solve(stuck + 1j * nu * 1e-7 * K - nu**2 * M, W)
    if law is None:
        C, inertia = reduced.damping, reduced.mass
        dynamic = reduced.stiffness + 1j * nu * C - nu**2 * inertia - reduced.reaction(nu)
        found = np.linalg.inv(dynamic)
        mobility = np.linalg.inv(M)[np.ix_(contact, contact)]
        np.testing.assert_allclose(np.linalg.inv(inertia), mobility, atol=1e-7 * mobility.max())
    else:
        found = reduced.reaction(nu) - reduced.stiffness
    np.testing.assert_allclose(found, flexibility, atol=1e-6 * np.abs(flexibility).max())


@pytest.mark.oracle
@pytest.mark.parametrize("n", [40, 600])
def test_a_structure_that_floats_has_its_rigid_body_mode(n, solver):
    """Free chain: 2 sin(k pi / 2 n), with frequency 0 exactly; static flexibility beside it."""
    mass, stiffness = free_chain(n)
    law = rom.Jenkins(1.0, 1.0)
    grounded = rom.Structure(mass, stiffness, contact=[0, n - 1])
    frequency = rom.modes(grounded, law, 4).states["free"].frequency
    np.testing.assert_allclose(frequency, 2.0 * np.sin(np.arange(4) * np.pi / (2 * n)), rtol=1e-8)
    assert frequency[0] == 0.0
    W = np.eye(n)[:, :1] - np.eye(n)[:, 1:2]  # floats with its contact stuck or bonded
    floating = rom.Structure(mass, stiffness, contact=W)
    bonded = rom.modes(floating, n=4).states["bonded"].frequency
    assert np.flatnonzero(bonded == 0.0).tolist() == [0]
    reduced = rom.reduce(floating, (1,), law=law)
    pseudo = np.linalg.pinv(stiffness.toarray() + W @ W.T, hermitian=True, rtol=1e-12)
    static = reduced.reaction(0.0) - reduced.stiffness
    np.testing.assert_allclose(static.real, W.T @ pseudo @ W, rtol=1e-7)


@pytest.mark.oracle
def test_equal_frequencies_are_all_found():
    """Six equal grounded chains: 0.001 + 4 sin^2, each six times."""
    grounded = free_chain(100)[1] + 1e-3 * scipy.sparse.eye_array(100)
    K = scipy.sparse.csc_array(scipy.sparse.kron(grounded, np.eye(6)))
    structure = rom.Structure(scipy.sparse.eye_array(600), K, contact=[0])
    found = rom.modes(structure, rom.Jenkins(1.0, 1.0), 12).states["free"].frequency
    exact = np.repeat(1e-3 + 4.0 * np.sin(np.arange(2) * np.pi / 200) ** 2, 6)
    np.testing.assert_allclose(found**2, exact, rtol=1e-11)


@pytest.mark.oracle
def test_low_modes_of_a_slender_body_are_no_rigid_bodies():
    """omega_1^2 is 1e-10 of the stiffest DOF's: as of a blade of a million DOFs."""
    n = 40_000
    mass, stiffness = free_chain(n)
    ground = scipy.sparse.csc_array(([1.0], ([0], [0])), shape=(n, n))
    structure = rom.Structure(mass, stiffness + ground, contact=[n - 1])
    law = rom.Jenkins(1.0, 1e-30)  # as without a contact
    frequency = rom.reduce(structure, law=law, smallest_response=1.0).frequency
    np.testing.assert_allclose(frequency, [np.pi / (2 * n), 3 * np.pi / (2 * n)], rtol=1e-4)


def test_matrices_that_are_not_positive_definite_are_refused(solver, matrices):
    M, K = matrices["mass"], matrices["stiffness"]
    light = M - 0.2 * scipy.sparse.diags_array(M.diagonal())
    with pytest.raises(rom.SlipmodeError, match="mass: must be positive definite"):
        rom.Structure(light, K, contact=matrices["contact"])
    soft = rom.Structure(M, K - 1e9 * M, contact=matrices["contact"])
    assert (soft.stiffness.diagonal() > 0).all()
    with pytest.raises(rom.SlipmodeError, match="stiffness: must be positive"):
        rom.reduce(soft)
