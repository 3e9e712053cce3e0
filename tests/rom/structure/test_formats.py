"""Files of other programs: the same structure out of each; what is refused, and how."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse

from slipmode.rom import Labels, SlipmodeError, Structure, load_structure

pytestmark = pytest.mark.quick

N = 6
NODE = np.repeat([4711, 12, 7], 2)  # the order of the DOFs is not that of the numbers
DIRECTION = np.tile([1, 3], 3)
CONTACT = [1, 4]


def matrices():
    random = np.random.default_rng(3)
    stiffness = random.standard_normal((N, N))
    stiffness = 1e5 * (stiffness @ stiffness.T + 3.0 * np.eye(N))
    mass = np.diag(random.uniform(1.0, 2.0, N))
    mass[0, 1] = mass[1, 0] = 0.25
    return stiffness, mass


STIFFNESS, MASS = matrices()


def entries(matrix):
    """Rows, columns and values of the lower triangle."""
    rows, columns = np.nonzero(np.tril(matrix))
    return zip(rows, columns, matrix[rows, columns], strict=True)


def write_labelled(path, matrix, between=", "):
    """As Abaqus does with FORMAT=MATRIX INPUT, or with blanks FORMAT=LABELS."""
    lines = ["** MATRIX", "*MATRIX"] + [
        between.join(
            [f"{NODE[r]}", f"{DIRECTION[r]}", f"{NODE[c]}", f"{DIRECTION[c]}", f"{v:.16e}"]
        )
        for r, c, v in entries(matrix)
    ]
    path.write_text("\n".join(lines) + "\n")


def write_triplets(path, matrix):
    """As Abaqus does with FORMAT=COORDINATE, and CalculiX."""
    path.write_text("".join(f"{r + 1} {c + 1} {v:.16e}\n" for r, c, v in entries(matrix)))


def abaqus(folder, between=", "):
    write_labelled(folder / "job_STIF2.mtx", STIFFNESS, between)
    write_labelled(folder / "job_MASS2.mtx", MASS, between)
    return folder / "job_STIF2.mtx", {}


def abaqus_blanks(folder):
    return abaqus(folder, " ")


def abaqus_coordinates(folder):
    write_triplets(folder / "k.mtx", STIFFNESS)
    write_triplets(folder / "m.mtx", MASS)
    return folder / "k.mtx", {"mass": folder / "m.mtx"}


def calculix(folder):
    write_triplets(folder / "job.sti", STIFFNESS)
    write_triplets(folder / "job.mas", MASS)
    names = "".join(f"{n}.{k}\n" for n, k in zip(NODE, DIRECTION, strict=True))
    (folder / "job.dof").write_text(names)
    return folder / "job.sti", {}


def matrix_market(folder):
    for name, matrix in (("k", STIFFNESS), ("m", MASS)):
        scipy.io.mmwrite(
            folder / f"{name}.mtx", scipy.sparse.coo_array(matrix), symmetry="symmetric"
        )
    assert "symmetric" in (folder / "k.mtx").read_text().splitlines()[0]
    return folder / "k.mtx", {"mass": folder / "m.mtx"}


def harwell_boeing(folder):
    for name, matrix in (("k", STIFFNESS), ("m", MASS)):
        scipy.io.hb_write(folder / f"{name}.hb", scipy.sparse.csc_array(matrix))
    return folder / "k.hb", {"mass": folder / "m.hb"}


def matlab(folder):
    scipy.io.savemat(folder / "blade.mat", {"K": STIFFNESS, "M": scipy.sparse.csc_array(MASS)})
    return folder / "blade.mat", {}


def op4(folder):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    op4.OP4().write(str(folder / "blade.op4"), {"KGG": STIFFNESS, "MGG": MASS})
    return folder / "blade.op4", {}


def punch(folder):
    bulk = pytest.importorskip("pyyeti.nastran.bulk")
    import pandas

    index = pandas.MultiIndex.from_arrays([NODE, DIRECTION], names=["id", "dof"])
    frames = {
        name: pandas.DataFrame(matrix, index=index, columns=index)
        for name, matrix in (("KAAX", STIFFNESS), ("MAAX", MASS))
    }
    bulk.wtdmig(str(folder / "blade.pch"), frames)
    return folder / "blade.pch", {}


LABELLED = (abaqus, abaqus_blanks, calculix, punch)
PLAIN = (abaqus_coordinates, matrix_market, harwell_boeing, matlab, op4)


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


@pytest.mark.parametrize("write", PLAIN)
def test_files_without_labels_keep_their_order(write, tmp_path):
    path, arguments = write(tmp_path)
    found = load_structure(path, contact=CONTACT, **arguments)
    np.testing.assert_allclose(dense(found.stiffness), STIFFNESS, rtol=1e-8, atol=1e-3)
    np.testing.assert_allclose(dense(found.mass), MASS, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("write", LABELLED)
def test_files_with_labels_keep_them(write, tmp_path):
    path, arguments = write(tmp_path)
    contact = [(4711, "z"), (7, 12, "x")]
    found = load_structure(path, contact=contact, **arguments)
    order = [found.labels.dof(n, "xyz"[k - 1]) for n, k in zip(NODE, DIRECTION, strict=True)]
    np.testing.assert_allclose(dense(found.stiffness)[np.ix_(order, order)], STIFFNESS, rtol=1e-8)
    np.testing.assert_allclose(dense(found.mass)[np.ix_(order, order)], MASS, rtol=1e-8)
    expected = np.zeros((N, 2))
    expected[1, 0] = expected[4, 1] = 1.0
    expected[2, 1] = -1.0
    np.testing.assert_array_equal(dense(found.directions)[order], expected)
    found.save(tmp_path / "again.npz")
    again = load_structure(tmp_path / "again.npz")
    np.testing.assert_array_equal(again.labels.table, found.labels.table)


def full_file():
    """The clamped aluminium beam that comes with the reader: 25 x 25 x 125 mm."""
    reader = pytest.importorskip("ansys.mapdl.reader")
    return Path(reader.__file__).parent / "examples" / "file.full"


def test_a_full_file_of_ansys_is_the_beam_that_it_says():
    found = load_structure(full_file(), contact=[(300, "x")])
    assert (found.n_dofs, found.labels.dof(63, "z")) == (900, 2)  # 63 of 963 are held
    with pytest.raises(SlipmodeError, match="node 1: is not in the structure"):
        found.labels.dof(1, "x")
    K, M = dense(found.stiffness), dense(found.mass)
    np.testing.assert_array_equal(K, K.T)
    frequency = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[:6]) / (2.0 * np.pi)
    sound, length, height = np.sqrt(7e10 / 2700.0), 0.125, 0.025
    bending = 1.8751**2 / (2.0 * np.pi) * sound * height / np.sqrt(12.0) / length**2
    assert frequency[5] == pytest.approx(sound / (4.0 * length), rel=2e-3)  # along the beam
    # a beam this short is softer than a slender one, by 3 % (Timoshenko)
    np.testing.assert_allclose(frequency[:2], 0.97 * bending, rtol=1e-2)


@pytest.mark.parametrize("size", [100, 40_000, 400_000, 800_000])
def test_a_truncated_full_file_is_named(size, tmp_path):
    path = tmp_path / "beam.full"
    path.write_bytes(full_file().read_bytes()[:size])
    assert "beam.full: is incomplete, or not a .full file of Ansys" in refusal(path)


def test_rounding_of_exports_is_symmetrised_and_said(tmp_path, caplog):
    rounded = np.array([[float(f"{v:.8e}") for v in row] for row in STIFFNESS])
    rounded[0, 1] *= 1.0 + 2e-9
    scipy.io.savemat(tmp_path / "blade.mat", {"K": rounded, "M": MASS, "W": [[0, 3]]})
    found = load_structure(tmp_path / "blade.mat")
    K = dense(found.stiffness)
    np.testing.assert_array_equal(K, K.T)
    np.testing.assert_allclose(K, STIFFNESS, rtol=1e-8)
    (record,) = caplog.records
    assert "stiffness is symmetrised" in record.getMessage()


def test_dofs_held_by_boundary_conditions_are_left_out(tmp_path, caplog):
    held = STIFFNESS.copy()
    held[5, 5] = 1e36
    path, _ = abaqus(tmp_path)
    write_labelled(path, held)
    found = load_structure(path, contact=[(4711, "x")])
    assert found.n_dofs == N - 1
    assert "1 DOFs are fixed" in caplog.text
    with pytest.raises(SlipmodeError, match="node 7: has no free direction z, allowed: x"):
        found.labels.dof(7, "z")


def refusal(path, contact=CONTACT, **arguments):
    with pytest.raises(SlipmodeError) as refused:
        load_structure(path, contact=contact, **arguments)
    message = str(refused.value)
    assert "\n" not in message
    assert str(path.parent) in message
    return message


@pytest.mark.parametrize("write", [*LABELLED, *PLAIN])
def test_a_truncated_file_is_named(write, tmp_path):
    path, arguments = write(tmp_path)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content)) - 3])
    assert path.name in refusal(path, **arguments)


def test_missing_mass_is_one_line(tmp_path):
    write_triplets(tmp_path / "job.sti", STIFFNESS)
    assert "mass is missing (there is no job.mas); give its file: mass=" in refusal(
        tmp_path / "job.sti"
    )
    scipy.io.savemat(tmp_path / "blade.mat", {"K": STIFFNESS})
    assert "mass is missing" in refusal(tmp_path / "blade.mat")
    assert "no such file" in refusal(tmp_path / "blade.mat", mass=tmp_path / "absent.mat")


def test_complex_and_mismatched_and_doubled_matrices_are_named(tmp_path):
    path = tmp_path / "blade.mat"
    scipy.io.savemat(path, {"K": STIFFNESS * (1 + 0.01j), "M": MASS})
    assert "stiffness: must hold real numbers, got complex128" in refusal(path)
    scipy.io.savemat(path, {"K": STIFFNESS, "M": MASS[1:, 1:]})
    assert "mass has 5 DOFs, stiffness has 6" in refusal(path)
    scipy.io.savemat(path, {"K": STIFFNESS, "K2": STIFFNESS, "M": MASS})
    assert (
        'K (6 DOFs), K2 (6 DOFs) may each be stiffness; choose one: names={"stiffness": "K"}'
        in refusal(path)
    )


def test_nodes_that_are_unknown_or_doubled_are_named(tmp_path):
    path, _ = abaqus(tmp_path)
    assert "node 13: is not in the structure, whose nodes are 7 to 4711" in refusal(
        path, [(13, "x")]
    )
    assert "direction: must be x, y, z, rx, ry, rz, got 'up'" in refusal(path, [(7, "up")])
    assert "the file names no nodes" in refusal(matlab(tmp_path)[0], [(7, "x")])
    with pytest.raises(SlipmodeError, match="labels: node 7 has direction x twice"):
        Labels(np.array([7, 7]), np.array([1, 1]))
    with pytest.raises(SlipmodeError, match="labels: must be 6, got 5"):
        Structure(MASS, STIFFNESS, contact=[0], labels=Labels(NODE[1:], DIRECTION[1:]))
    with (tmp_path / "job_MASS2.mtx").open("a") as file:
        file.write("99, 1, 99, 1, 1.0\n")
    assert "mass: node 99 has a DOF that is not in stiffness" in refusal(path)


def test_contacts_have_to_be_named_somewhere(tmp_path):
    path, _ = matlab(tmp_path)
    assert (
        'contact: is missing; give contact=, as DOF indices, W or [(node, "x"), ...]'
        in refusal(path, None)
    )
