"""Files as users have them: a chain of six masses, written as each program does; and refusals."""

import numpy as np
import pytest
import scipy.io
from written.matrices import abaqus_substructure, beam, harwell_boeing, translations

from slipmode import rom

pytestmark = pytest.mark.quick

N = 6
SPRING = 1e5 * (2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
SPRING[-1, -1] = 1e5
MASS = np.eye(N)
HERTZ = np.sqrt(1e5) / np.pi * np.sin(np.pi * (2 * np.arange(1, 4) - 1) / (4 * N + 2))


def frequencies(path, contact=(N - 1,), **arguments):
    structure = rom.load_structure(path, contact=list(contact), **arguments)
    return rom.modes(structure, n=3).states["free"].hertz


def refusal(path, contact=(N - 1,), **arguments):
    with pytest.raises(rom.SlipmodeError) as refused:
        rom.load_structure(path, contact=list(contact), **arguments)
    assert "\n" not in str(refused.value)
    return str(refused.value)


class Chain:
    """The chain in place of a structure that `test_written_files` draws."""

    K, M, size = SPRING, MASS, N

    def __init__(self, nodes, *choices):
        self.labels = [(node, 1) for node in nodes]
        self._choices = list(choices)

    def draw(self, *choices):
        return self._choices.pop(0) if self._choices else choices[0]

    def triangle(self, matrix):
        rows, columns = np.nonzero(np.tril(matrix))
        return list(zip(rows, columns, matrix[rows, columns], strict=True))


def test_stiffness_of_ansys_with_right_hand_sides(tmp_path):
    for letter in "ED":
        one = (True, (26, 16, letter), 3, "1P,", 10, True)
        path, arguments = harwell_boeing(Chain(range(N), *one, *one), tmp_path)
        assert path.read_text(encoding="latin-1").splitlines()[4].startswith("F")
        np.testing.assert_allclose(frequencies(path, **arguments), HERTZ, rtol=1e-9)


def test_numbers_without_the_letter_of_their_exponent(tmp_path):
    chain = Chain(range(N))
    path, arguments = harwell_boeing(chain, tmp_path)
    text = path.read_text(encoding="latin-1")
    path.write_text(text.replace("E+0", "+00"), encoding="latin-1")  # as wide as before
    np.testing.assert_allclose(frequencies(path, **arguments), HERTZ, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("RSA", "CSA"), "has the type CSA; must be RSA or RUA"),
        (("RSA", "PSA"), "has the type PSA; must be RSA or RUA"),
        (("(5I5)", "(5A5)"), "(5A5) must be a format with a width"),
        (("E+05", "E+x5"), "is not a number"),
    ],
)
def test_other_harwell_boeing_files_are_refused(change, message, tmp_path):
    path, arguments = harwell_boeing(Chain(range(N)), tmp_path)
    path.write_text(path.read_text(encoding="latin-1").replace(*change), encoding="latin-1")
    assert message in refusal(path, **arguments)


def test_a_substructure_of_abaqus_has_its_nodes(tmp_path):
    nodes = (10, 20, 35, 4711, 5000, 99999)
    path, _ = abaqus_substructure(Chain(nodes), tmp_path)
    np.testing.assert_allclose(frequencies(path, [(99999, "x")]), HERTZ, rtol=1e-9)
    text = path.read_text()
    path.write_text(text.replace("*USER", "** ELEMENT NUMBER 2\n*USER") + text)
    assert "has the matrices of several elements" in refusal(path)


def test_a_substructure_with_directions_of_single_nodes(tmp_path):
    """As CalculiX writes it: a node for each DOF, and a position with its direction."""
    path, _ = abaqus_substructure(Chain((7, 8, 9, 11, 12, 13)), tmp_path)
    text = path.read_text().replace("7,8,9,11", "7,7,8,8").replace("\n1\n", "\n1\n2,3\n3,1\n4,2\n")
    path.write_text(text)
    found = rom.load_structure(path, contact=[(13, "y")])
    pairs = [(7, 1), (7, 3), (8, 1), (8, 2), (12, 2), (13, 2)]
    assert [tuple(pair) for pair in found.labels.table.tolist()] == pairs


WORKSPACES = {
    "others": {"Kglobal": SPRING, "Mglobal": MASS, "Material": "steel", "damp": 0.01, "dt": 0.1,
               "nodes": np.arange(6.0), "Mesh": np.eye(4)},
    "struct": {"sys": {"K": SPRING, "M": MASS}},
    "deep": {"model": {"red": {"stiffness": SPRING, "mass": MASS}, "name": "blade"}},
    "array": {"s": np.array([(SPRING, MASS)], dtype=[("K", object), ("M", object)])},
    "modes": {"K": SPRING, "M": MASS, "Modes": np.triu(np.ones((N, N))), "mu": 0.3},
}  # fmt: skip


@pytest.mark.parametrize("name", WORKSPACES)
def test_matrices_in_a_workspace(name, tmp_path):
    scipy.io.savemat(tmp_path / "w.mat", WORKSPACES[name])
    np.testing.assert_allclose(frequencies(tmp_path / "w.mat"), HERTZ, rtol=1e-9)


def test_ambiguous_matrices_are_listed_and_chosen_by_name(tmp_path):
    path = tmp_path / "w.mat"
    two = {"K1": SPRING, "K2": 4 * SPRING, "M": MASS, "Kel": np.eye(3)}
    scipy.io.savemat(path, two)
    assert (
        'K1 (6 DOFs), K2 (6 DOFs) may each be stiffness; choose one: names={"stiffness": "K1"}'
        in refusal(path)
    )
    np.testing.assert_allclose(frequencies(path, names={"stiffness": "K2"}), 2 * HERTZ, rtol=1e-9)
    assert "stiffness = 'Q' is not in the file, which has K1, K2, M, Kel" in refusal(
        path, names={"stiffness": "Q"}
    )
    assert "names: must be of stiffness, mass, damping, contact, got 'k'" in refusal(
        path, names={"k": "K1"}
    )
    assert "names: must be such as" in refusal(path, names="K1")
    scipy.io.savemat(path, {"Q": SPRING, "R": MASS})
    assert "stiffness is missing; the file has Q, R; name it" in refusal(path)
    names = {"stiffness": "Q", "mass": "R"}
    np.testing.assert_allclose(frequencies(path, names=names), HERTZ, rtol=1e-9)


def test_a_matrix_of_eigenvalues_is_no_damping(tmp_path, caplog):
    path = tmp_path / "w.mat"
    scipy.io.savemat(path, {"K": SPRING, "M": MASS, "D": 3.0 * np.eye(N), "C": np.eye(N, k=1)})
    assert rom.load_structure(path, contact=[0]).beta == 0.0
    assert "D is diagonal, as matrices of eigenvalues are" in caplog.text
    assert "C is not symmetric" in caplog.text
    named = rom.load_structure(path, contact=[0], names={"damping": "D"})
    np.testing.assert_array_equal(named.damping.toarray(), 3.0 * np.eye(N))


def test_arrays_of_numpy_need_no_contact_in_the_file(tmp_path):
    np.savez(tmp_path / "w.npz", mass=MASS, stiffness=SPRING)
    np.testing.assert_allclose(frequencies(tmp_path / "w.npz"), HERTZ, rtol=1e-9)
    scipy.io.mmwrite(tmp_path / "mass.mtx", MASS)
    scipy.io.mmwrite(tmp_path / "stiffness.mtx", SPRING)
    np.testing.assert_allclose(frequencies(tmp_path), HERTZ, rtol=1e-9)
    assert "have fixed names; leave names out" in refusal(tmp_path, names={"mass": "M"})


def test_rotations_of_solid_elements_do_not_move(tmp_path, caplog):
    """KGG has six DOFs a grid; those with neither mass nor stiffness keep their numbers."""
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    x = np.zeros((6 * N, N))
    x[6 * np.arange(N), np.arange(N)] = 1.0
    op4.write(str(tmp_path / "KGG.OP4"), {"KGG": x @ SPRING @ x.T, "MGG": x @ MASS @ x.T})
    found = frequencies(tmp_path / "KGG.OP4", [30])
    np.testing.assert_allclose(found, HERTZ, rtol=1e-9)
    assert "30 of 36 DOFs have neither mass nor stiffness" in caplog.text
    message = refusal(tmp_path / "KGG.OP4", [31])
    assert "contact: DOF 31 has neither mass nor stiffness; give another DOF" in message


def test_lumped_masses_of_a_beam(tmp_path, caplog):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    K, M = beam(6)
    op4.write(str(tmp_path / "beam.op4"), {"KAA": K, "MAA": M, "K4AA": K, "PA": np.ones((12, 1))})
    stiffness, mass = translations(6)
    expected = rom.modes(rom.Structure(mass, stiffness, contact=[5]), n=3).states["free"].hertz
    np.testing.assert_allclose(frequencies(tmp_path / "beam.op4", [10]), expected, rtol=1e-8)
    assert "6 of 12 DOFs have no mass" in caplog.text
    assert "K4AA is structural damping" in caplog.text


def test_two_sizes_in_one_file_are_ambiguous(tmp_path):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    path = tmp_path / "both.op4"
    op4.write(str(path), {"KGG": SPRING, "MGG": MASS, "KAA": np.eye(3), "MAA": np.eye(3)})
    assert "KAA (3 DOFs), KGG (6 DOFs) may each be stiffness" in refusal(path)
    np.testing.assert_allclose(frequencies(path, names={"stiffness": "KGG"}), HERTZ, rtol=1e-9)
