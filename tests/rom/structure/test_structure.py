"""Structures: the two-mass model, damping, the partition, and their own files."""

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from slipmode import rom
from slipmode.rom import Structure, load_structure, two_mass

pytestmark = pytest.mark.quick

STORES = [np.array, scipy.sparse.csc_array]
SKEW = np.random.default_rng(3).normal(size=(6, 2)) * [1.0, 1e-3]


def chain(n=6, seed=1):
    """A chain of unequal masses with one spring to the ground: mass, stiffness."""
    random = np.random.default_rng(seed)
    springs = random.uniform(1.0, 2.0, n)
    stiffness = np.diag(springs + np.append(springs[1:], 0.0))
    stiffness -= np.diag(springs[1:], 1) + np.diag(springs[1:], -1)
    return np.diag(random.uniform(1.0, 3.0, n)), stiffness


MASS, STIFFNESS = chain()


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


def assert_same_structure(first, second):
    for name in ("mass", "stiffness", "damping", "directions"):
        np.testing.assert_array_equal(dense(getattr(first, name)), dense(getattr(second, name)))
    assert first.beta == second.beta
    assert scipy.sparse.issparse(first.mass) == scipy.sparse.issparse(second.mass)


def test_two_mass_has_the_matrices_of_the_paper():
    """Source Eq. (26) and Table 1; its bonded frequencies are 1 and 1.7 rad/s."""
    varied = two_mass(
        beta=0.5, contact_mass=0.2, m1=2.0, m2=3.0, k1=5.0, k2=7.0, k_c1=11.0, k_c2=13.0, k_p=-1.0
    )
    np.testing.assert_array_equal(np.diag(varied.mass), [2.0, 3.0, 0.2, 0.2])
    np.testing.assert_array_equal(
        varied.stiffness, [[5, 0, -5, 0], [0, 7, 0, -7], [-5, 0, 16, -1], [0, -7, -1, 20]]
    )
    np.testing.assert_array_equal(varied.damping, 0.5 * varied.stiffness)
    part = two_mass().partition()
    np.testing.assert_allclose(part.K_cc, [[21.0, 5.0], [5.0, 42.89]], rtol=1e-15)
    np.testing.assert_allclose(rom.modes(two_mass(), n=2).states["bonded"].frequency, [1.0, 1.7])


@pytest.mark.oracle
@pytest.mark.parametrize("store", STORES)
@pytest.mark.parametrize("contact", [(5, 2), [[0], [1], [0], [0], [-1], [0]], SKEW])
def test_the_partition_is_a_change_of_coordinates(contact, store):
    """x = E x_e + R x_c with W^T E = 0 and W^T R = I; its blocks are T^T A T."""
    damping = 0.1 * MASS + 0.02 * STIFFNESS
    structure = Structure(store(MASS), store(STIFFNESS), damping, contact=contact)
    part, W = structure.partition(), dense(structure.directions)
    E, R = dense(part.E), dense(part.R)
    count = W.shape[1]
    np.testing.assert_allclose(W.T @ E, 0.0, atol=1e-15)
    np.testing.assert_allclose(W.T @ R, np.eye(count), atol=1e-12)
    np.testing.assert_array_equal(E[part.elastic_dofs], np.eye(6 - count))
    T = np.hstack((E, R))
    for name, matrix in {"M": MASS, "C": damping, "K": STIFFNESS}.items():
        ee, ec, cc = (dense(getattr(part, f"{name}_{block}")) for block in ("ee", "ec", "cc"))
        np.testing.assert_allclose(
            np.block([[ee, ec], [ec.T, cc]]), T.T @ matrix @ T, rtol=1e-9, atol=1e-12
        )


def test_large_sparse_structures_stay_sparse():
    n = 50_000
    mass = scipy.sparse.diags_array([1.0, 4.0, 1.0], offsets=[-1, 0, 1], shape=(n, n))
    W = scipy.sparse.csr_array(([1.0, -1.0], ([10, 11], [0, 0])), shape=(n, 1))
    part = Structure(mass, mass, contact=W).partition()
    assert part.K_ee.nnz <= 3 * n and part.K_ec.shape == (n - 1, 1)


def test_matrices_are_copies_that_cannot_be_written():
    mass = MASS.copy()
    structure = Structure(mass, STIFFNESS, contact=[5])
    mass[0, 0] = 99.0
    assert structure.mass[0, 0] != 99.0
    with pytest.raises(ValueError, match="read-only"):
        structure.mass[0, 0] = 1.0
    with pytest.raises(AttributeError):
        structure.mass = mass


# Damping


@pytest.mark.oracle
@pytest.mark.parametrize("store", STORES)
def test_rayleigh_damping_is_its_matrix(store):
    given = Structure(store(MASS), store(STIFFNESS), rom.Rayleigh(0.3, 0.02), contact=[3])
    np.testing.assert_allclose(dense(given.damping), 0.3 * MASS + 0.02 * STIFFNESS, rtol=1e-15)
    assert given.beta is None
    assert Structure(MASS, STIFFNESS, rom.Rayleigh(0.0, 0.02), contact=[3]).beta == 0.02


@pytest.mark.oracle
def test_rayleigh_damping_has_its_ratios_and_its_loss_factor():
    """zeta = (alpha / omega + beta omega) / 2; viscous c omega is hysteretic eta k."""
    omega = rom.reduce(Structure(MASS, STIFFNESS, contact=[3])).frequency
    for damping, zeta in (
        (rom.Rayleigh.from_ratios((0.01, 0.012), omega), (0.01, 0.012)),
        (rom.Rayleigh.from_loss_factor(0.02, omega), (0.01, 0.01)),
        (rom.Rayleigh.from_ratios(0.01, omega[0]), (0.01, 0.01 * omega[1] / omega[0])),
    ):
        ratios = 0.5 * (damping.alpha / omega + damping.beta * omega)
        np.testing.assert_allclose(ratios, zeta, rtol=1e-12)
        found = rom.reduce(Structure(MASS, STIFFNESS, damping, contact=[3]))
        np.testing.assert_allclose(found.modal_damping / (2.0 * omega), zeta, rtol=1e-12)


# Files


@pytest.mark.parametrize(
    "structure",
    [
        two_mass(),
        Structure(MASS, STIFFNESS, 0.3 * MASS, contact=SKEW),
        Structure(*map(scipy.sparse.csc_array, chain()), 0.02, contact=[5]),
    ],
    ids=["beta", "damping matrix and W", "sparse"],
)
def test_what_is_saved_loads_to_the_last_bit(structure, tmp_path):
    structure.save(tmp_path / "saved.npz")
    assert_same_structure(load_structure(tmp_path / "saved.npz"), structure)
    assert load_structure(tmp_path / "saved.npz", 0.05).beta == 0.05


@pytest.mark.oracle
def test_a_folder_of_matrix_market_files_is_read(tmp_path):
    """Written by scipy: contacts by index, or as W beside a damping matrix."""
    for name, matrix in (("mass", MASS), ("stiffness", STIFFNESS)):
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", scipy.sparse.coo_array(matrix))
    (tmp_path / "contact.txt").write_text("# tip and root\n2\n5\n")
    found = load_structure(tmp_path)
    np.testing.assert_array_equal(dense(found.directions), np.eye(6)[:, [2, 5]])
    np.testing.assert_allclose(dense(found.stiffness), STIFFNESS, rtol=1e-14)
    (tmp_path / "contact.txt").unlink()
    scipy.io.mmwrite(tmp_path / "contact.mtx", SKEW)
    scipy.io.mmwrite(tmp_path / "damping.mtx", scipy.sparse.coo_array(0.3 * MASS))
    found = load_structure(tmp_path)
    np.testing.assert_allclose(dense(found.directions), SKEW, rtol=1e-14)
    np.testing.assert_allclose(dense(found.damping), 0.3 * MASS, rtol=1e-14)
