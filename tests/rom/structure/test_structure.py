"""Structures: the two-mass model, the partition, files and refusals."""

import re

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse

from slipmode.rom import SlipmodeError, Structure, load_structure, two_mass

pytestmark = pytest.mark.quick


def chain(n=6, seed=1):
    """A chain of unequal masses with one spring to the ground: mass, stiffness."""
    random = np.random.default_rng(seed)
    springs = random.uniform(1.0, 2.0, n)
    stiffness = np.diag(springs + np.append(springs[1:], 0.0))
    stiffness -= np.diag(springs[1:], 1) + np.diag(springs[1:], -1)
    return np.diag(random.uniform(1.0, 3.0, n)), stiffness


def bonded_frequencies(structure):
    part = structure.partition()
    return np.sqrt(scipy.linalg.eigh(dense(part.K_ee), dense(part.M_ee), eigvals_only=True))


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


def blocks(part):
    names = [f"{matrix}_{block}" for matrix in "MCK" for block in ("ee", "ec", "cc")]
    return {name: dense(getattr(part, name)) for name in names}


def assert_same_structure(first, second):
    for name in ("mass", "stiffness", "damping", "directions"):
        np.testing.assert_array_equal(dense(getattr(first, name)), dense(getattr(second, name)))
    assert first.beta == second.beta


# The two-mass model


def test_two_mass_is_the_lumped_model_of_table_1():
    part = two_mass().partition()
    np.testing.assert_array_equal(part.M_ee, np.eye(2))
    np.testing.assert_array_equal(part.M_ec, np.zeros((2, 2)))
    np.testing.assert_array_equal(part.M_cc, 0.01 * np.eye(2))
    np.testing.assert_allclose(part.K_ee, [[1.0, 0.0], [0.0, 2.89]], rtol=1e-15)
    np.testing.assert_allclose(part.K_ec, [[-1.0, 0.0], [0.0, -2.89]], rtol=1e-15)
    np.testing.assert_allclose(part.K_cc, [[21.0, 5.0], [5.0, 42.89]], rtol=1e-15)
    np.testing.assert_allclose(part.C_cc, [[0.21, 0.05], [0.05, 0.4289]], rtol=1e-15)


def test_two_mass_bonded_frequencies():
    np.testing.assert_allclose(bonded_frequencies(two_mass()), [1.0, 1.7], rtol=1e-15)


def test_two_mass_parameters_reach_their_entries():
    varied = two_mass(
        beta=0.5, contact_mass=0.2, m1=2.0, m2=3.0, k1=5.0, k2=7.0, k_c1=11.0, k_c2=13.0, k_p=-1.0
    )
    np.testing.assert_array_equal(np.diag(varied.mass), [2.0, 3.0, 0.2, 0.2])
    np.testing.assert_array_equal(
        varied.stiffness, [[5, 0, -5, 0], [0, 7, 0, -7], [-5, 0, 16, -1], [0, -7, -1, 20]]
    )
    np.testing.assert_array_equal(varied.damping, 0.5 * varied.stiffness)


# The partition


def skew_directions(n=6):
    return np.random.default_rng(3).normal(size=(n, 2)) * [1.0, 1e-3]


@pytest.mark.parametrize(
    "contact",
    [
        (2, 5),
        (5, 2),
        [[0.0], [1.0], [0.0], [0.0], [-1.0], [0.0]],
        skew_directions(),
    ],
)
def test_elastic_motion_leaves_contacts_at_rest_and_contact_motion_is_unit(contact):
    structure = Structure(*chain(), contact=contact)
    part = structure.partition()
    W, n_contacts = structure.directions, structure.n_contacts
    np.testing.assert_allclose(W.T @ part.E, np.zeros((n_contacts, 6 - n_contacts)), atol=1e-15)
    np.testing.assert_allclose(W.T @ part.R, np.eye(n_contacts), atol=1e-12)
    np.testing.assert_array_equal(part.E[part.elastic_dofs], np.eye(6 - n_contacts))
    np.testing.assert_array_equal(part.R[part.elastic_dofs], 0.0)


def test_blocks_together_are_the_matrices_in_new_coordinates():
    mass, stiffness = chain()
    damping = 0.1 * mass + 0.02 * stiffness
    part = Structure(mass, stiffness, damping, contact=skew_directions()).partition()
    T = np.hstack((part.E, part.R))
    for name, matrix in {"M": mass, "C": damping, "K": stiffness}.items():
        ee, ec, cc = (getattr(part, f"{name}_{block}") for block in ("ee", "ec", "cc"))
        np.testing.assert_allclose(np.block([[ee, ec], [ec.T, cc]]), T.T @ matrix @ T, rtol=1e-9)


def test_contact_indices_are_plain_selections():
    mass, stiffness = chain()
    part = Structure(mass, stiffness, contact=(4, 1)).partition()
    np.testing.assert_array_equal(part.elastic_dofs, [0, 2, 3, 5])
    np.testing.assert_array_equal(part.K_ee, stiffness[np.ix_([0, 2, 3, 5], [0, 2, 3, 5])])
    np.testing.assert_array_equal(part.K_ec, stiffness[np.ix_([0, 2, 3, 5], [4, 1])])
    np.testing.assert_array_equal(part.K_cc, stiffness[np.ix_([4, 1], [4, 1])])


def test_bonded_frequencies_do_not_depend_on_the_coordinates():
    mass, stiffness = chain()
    by_index = Structure(mass, stiffness, contact=(2, 5))
    Q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(6, 6)))
    rotated = Structure(Q @ mass @ Q.T, Q @ stiffness @ Q.T, contact=Q[:, [2, 5]])
    np.testing.assert_allclose(
        bonded_frequencies(rotated), bonded_frequencies(by_index), rtol=1e-12
    )


def test_free_bodies_held_by_their_contact_have_bonded_frequencies():
    mass, stiffness = np.eye(2), np.array([[1.0, -1.0], [-1.0, 1.0]])
    structure = Structure(mass, stiffness, contact=[1])
    np.testing.assert_allclose(bonded_frequencies(structure), [1.0])


@pytest.mark.parametrize("contact", [(2, 5), skew_directions()])
def test_sparse_equals_dense(contact):
    mass, stiffness = chain()
    full = Structure(mass, stiffness, 0.02, contact=contact)
    sparse = Structure(
        scipy.sparse.coo_array(mass), scipy.sparse.csr_matrix(stiffness), 0.02, contact=contact
    )
    assert_same_structure(sparse, full)
    part, expected = sparse.partition(), full.partition()
    for name in ("E", "R", "M_ee", "C_ee", "K_ee"):
        assert isinstance(getattr(part, name), scipy.sparse.csc_array)
    np.testing.assert_array_equal(part.elastic_dofs, expected.elastic_dofs)
    for name, block in blocks(expected).items():
        np.testing.assert_allclose(blocks(part)[name], block, rtol=1e-9, atol=1e-12)


def test_large_sparse_structures_stay_sparse():
    n = 50_000
    mass = scipy.sparse.diags_array([1.0, 4.0, 1.0], offsets=[-1, 0, 1], shape=(n, n))
    stiffness = scipy.sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n))
    W = scipy.sparse.csr_array(([1.0, -1.0], ([10, 11], [0, 0])), shape=(n, 1))
    part = Structure(mass, stiffness, contact=W).partition()
    assert part.K_ee.nnz <= 3 * n
    assert part.K_ec.shape == (n - 1, 1)


def test_matrices_are_copies_that_cannot_be_written():
    mass, stiffness = chain()
    structure = Structure(mass, stiffness, contact=[5])
    mass[0, 0] = 99.0
    assert structure.mass[0, 0] != 99.0
    with pytest.raises(ValueError, match="read-only"):
        structure.mass[0, 0] = 1.0
    with pytest.raises(AttributeError):
        structure.mass = mass


def test_says_what_it_is():
    assert repr(two_mass()) == "Structure(4 DOFs, 2 contacts, dense)"


# Refusals

MASS, STIFFNESS = chain()
ARGUMENTS = {"mass": MASS, "stiffness": STIFFNESS, "contact": (2, 5)}


def with_entry(matrix, i, j, value):
    changed = matrix.copy()
    changed[i, j] = value
    return changed


REFUSED = [
    ({"mass": MASS[:4]}, "mass: must be square, got 4 x 6"),
    ({"mass": MASS[0]}, "mass: must be a matrix"),
    ({"mass": [[1.0], [1.0, 2.0]]}, "mass: rows must all have the same length"),
    ({"mass": with_entry(MASS, 0, 1, 0.1)}, "mass: must be symmetric"),
    ({"mass": with_entry(MASS, 0, 0, np.nan)}, "mass: must be finite"),
    ({"mass": with_entry(MASS, 0, 0, -1.0)}, "mass: must be positive definite"),
    ({"mass": np.ones((6, 6))}, "mass: must be positive definite"),
    ({"mass": 1j * MASS}, "mass: must hold real numbers"),
    ({"mass": MASS.astype(str)}, "mass: must hold real numbers"),
    ({"stiffness": STIFFNESS[:4, :4]}, "stiffness: must be 6 x 6 like mass"),
    ({"stiffness": with_entry(STIFFNESS, 0, 1, 7.0)}, "stiffness: must be symmetric"),
    ({"stiffness": with_entry(STIFFNESS, 2, 2, np.inf)}, "stiffness: must be finite"),
    ({"damping": -0.01}, "damping: beta must be a finite number >= 0"),
    ({"damping": float("nan")}, "damping: beta must be a finite number >= 0"),
    ({"damping": np.eye(5)}, "damping: must be 6 x 6 like mass"),
    ({"damping": with_entry(np.eye(6), 3, 3, -1e-6)}, "damping: must be positive semidefinite"),
    ({"contact": []}, "contact: must name at least one DOF"),
    ({"contact": 2}, "contact: must be a matrix"),
    ({"contact": [6]}, "contact: DOF 6 is out of range, allowed: 0 to 5"),
    ({"contact": [-1]}, "contact: DOF -1 is out of range"),
    ({"contact": [1, 1]}, "contact: DOF indices must be distinct"),
    ({"contact": [1.0]}, "contact: DOF indices must be integers"),
    ({"contact": np.eye(6, 7)}, "contact: must have 1 to 6 contacts, at most one per DOF, got 7"),
    ({"contact": np.ones((5, 1))}, "contact: W must have 6 rows"),
    ({"contact": np.ones((6, 2))}, "contact: directions .* must be linearly independent"),
    ({"contact": np.eye(6)[:, :1] * 0}, "contact: every direction .* nonzero entry"),
    ({"contact": np.full((6, 1), np.nan)}, "contact: must be finite"),
]


@pytest.mark.parametrize(("changed", "message"), REFUSED)
def test_refuses_in_one_line_that_names_the_argument(changed, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        Structure(**(ARGUMENTS | changed))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "mass",
    [
        with_entry(MASS, 0, 0, -1.0),
        np.ones((6, 6)),
        np.kron(np.eye(3), [[1.0, 2.0], [2.0, 1.0]]),
    ],
)
def test_refuses_sparse_mass_that_is_not_positive_definite(mass):
    with pytest.raises(SlipmodeError, match="mass: must be positive definite"):
        Structure(scipy.sparse.csr_array(mass), STIFFNESS, contact=[0])


@pytest.mark.parametrize("store", [np.array, scipy.sparse.csc_array])
def test_accepts_semidefinite_damping_and_refuses_indefinite(store):
    dashpot = np.zeros((6, 6))
    dashpot[np.ix_([1, 3], [1, 3])] = [[1.0, -1.0], [-1.0, 1.0]]
    mass, stiffness = store(MASS), store(STIFFNESS)
    accepted = Structure(mass, stiffness, store(dashpot), contact=[0])
    assert accepted.beta is None
    np.testing.assert_array_equal(dense(accepted.damping), dashpot)
    with pytest.raises(SlipmodeError, match="damping: must be positive semidefinite"):
        Structure(mass, stiffness, store(-dashpot), contact=[0])


def test_accepts_a_damping_matrix_of_zeros():
    assert not Structure(MASS, STIFFNESS, np.zeros((6, 6)), contact=[0]).damping.any()


# Files


@pytest.mark.parametrize(
    "structure",
    [
        two_mass(),
        Structure(MASS, STIFFNESS, 0.3 * MASS, contact=skew_directions()),
        Structure(*map(scipy.sparse.csc_array, chain()), 0.02, contact=[5]),
    ],
    ids=["beta", "damping matrix and W", "sparse"],
)
def test_what_is_saved_loads_to_the_last_bit(structure, tmp_path):
    structure.save(tmp_path / "saved.npz")
    loaded = load_structure(tmp_path / "saved.npz")
    assert_same_structure(loaded, structure)
    assert scipy.sparse.issparse(loaded.mass) == scipy.sparse.issparse(structure.mass)


def write_folder(folder, damping=None):
    scipy.io.mmwrite(folder / "mass.mtx", scipy.sparse.coo_array(MASS))
    scipy.io.mmwrite(folder / "stiffness.mtx", scipy.sparse.coo_array(STIFFNESS))
    if damping is not None:
        scipy.io.mmwrite(folder / "damping.mtx", scipy.sparse.coo_array(damping))


def test_loads_a_matrix_market_folder_with_contact_indices(tmp_path):
    write_folder(tmp_path)
    (tmp_path / "contact.txt").write_text("# tip and root\n2\n5\n")
    expected = Structure(MASS, STIFFNESS, contact=(2, 5))
    assert_same_structure(load_structure(tmp_path), expected)


def test_loads_a_matrix_market_folder_with_directions_and_damping(tmp_path):
    write_folder(tmp_path, damping=0.3 * MASS)
    scipy.io.mmwrite(tmp_path / "contact.mtx", skew_directions())
    expected = Structure(MASS, STIFFNESS, 0.3 * MASS, contact=skew_directions())
    loaded = load_structure(tmp_path)
    np.testing.assert_allclose(dense(loaded.directions), expected.directions, rtol=1e-14)
    np.testing.assert_allclose(dense(loaded.damping), expected.damping, rtol=1e-14)


def test_given_damping_overrides_the_stored_one(tmp_path):
    two_mass(beta=0.01).save(tmp_path / "saved.npz")
    assert_same_structure(load_structure(tmp_path / "saved.npz", 0.05), two_mass(beta=0.05))


def refusal_of(path):
    with pytest.raises(SlipmodeError) as refusal:
        load_structure(path)
    message = str(refusal.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def test_refuses_a_file_that_is_not_there(tmp_path):
    assert "no such .npz file or folder" in refusal_of(tmp_path / "absent.npz")


@pytest.mark.parametrize("content", [b"", b"text\nof two lines", b"PK\x03\x04 torn"])
def test_refuses_a_file_that_is_no_npz(content, tmp_path):
    path = tmp_path / "torn.npz"
    path.write_bytes(content)
    assert "is not a readable .npz file" in refusal_of(path)


def test_refuses_a_single_array(tmp_path):
    np.save(tmp_path / "mass.npy", MASS)
    (tmp_path / "mass.npy").rename(tmp_path / "mass.npz")
    assert "single array" in refusal_of(tmp_path / "mass.npz")


@pytest.mark.parametrize("missing", ["mass", "stiffness", "contact"])
def test_names_the_missing_key(missing, tmp_path):
    arrays = {name: value for name, value in ARGUMENTS.items() if name != missing}
    np.savez(tmp_path / "part.npz", **arrays)
    assert re.search(f"{missing}:? is missing", refusal_of(tmp_path / "part.npz"))


def test_refuses_pickled_objects(tmp_path):
    np.savez(tmp_path / "objects.npz", **(ARGUMENTS | {"mass": np.array([{}], dtype=object)}))
    assert "mass is damaged or not a plain array" in refusal_of(tmp_path / "objects.npz")


def test_refuses_sparse_indices_out_of_range(tmp_path):
    rows = scipy.sparse.csr_array(MASS)
    parts = {"data": rows.data, "indices": rows.indices + 10**6, "indptr": rows.indptr}
    arrays = {f"mass_{part}": array for part, array in parts.items()}
    np.savez(tmp_path / "wild.npz", **arrays, mass_shape=(6, 6), stiffness=STIFFNESS, contact=[2])
    assert "mass is damaged" in refusal_of(tmp_path / "wild.npz")


def test_names_the_file_of_a_refused_matrix(tmp_path):
    np.savez(tmp_path / "skew.npz", **(ARGUMENTS | {"mass": -MASS}))
    assert "mass: must be positive definite" in refusal_of(tmp_path / "skew.npz")


def test_names_the_missing_matrix_market_file(tmp_path):
    write_folder(tmp_path)
    assert "contact.mtx or contact.txt is missing" in refusal_of(tmp_path)


def test_refuses_two_contact_files(tmp_path):
    write_folder(tmp_path)
    (tmp_path / "contact.txt").write_text("2\n")
    scipy.io.mmwrite(tmp_path / "contact.mtx", skew_directions())
    assert "not both" in refusal_of(tmp_path)


@pytest.mark.parametrize(("name", "content"), [("mass.mtx", "no\nmatrix"), ("contact.txt", "x")])
def test_names_the_unreadable_file_of_a_folder(name, content, tmp_path):
    write_folder(tmp_path)
    (tmp_path / "contact.txt").write_text("2\n")
    (tmp_path / name).write_text(content)
    assert f"{name}: cannot be read" in refusal_of(tmp_path)


def test_refuses_to_save_under_another_ending(tmp_path):
    with pytest.raises(SlipmodeError, match=r"must end in \.npz"):
        two_mass().save(tmp_path / "structure.mat")


def test_refuses_to_save_where_nothing_can_be_written(tmp_path):
    with pytest.raises(SlipmodeError, match="cannot be written"):
        two_mass().save(tmp_path / "absent" / "structure.npz")
