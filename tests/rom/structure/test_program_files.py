"""Matrices as other programs write them: the same structure out of each file, or a refusal."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.linalg
from written.matrices import abaqus_substructure, harwell_boeing

from slipmode import rom

pytestmark = pytest.mark.quick

# A chain of six masses with its natural frequencies in closed form
N = 6
SPRING = 1e5 * (2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
SPRING[-1, -1] = 1e5
MASS = np.eye(N)
HERTZ = np.sqrt(1e5) / np.pi * np.sin(np.pi * (2 * np.arange(1, 4) - 1) / (4 * N + 2))
NODES, DIRECTIONS = np.repeat([4711, 12, 7], 2), np.tile([1, 3], 3)  # of labelled files


def load(path, contact=(N - 1,), **arguments):
    return rom.load_structure(path, contact=list(contact), **arguments)


def frequencies(path, contact=(N - 1,), **arguments):
    return rom.modes(load(path, contact, **arguments), n=3).states["free"].hertz


class Chain:
    """The chain in place of a structure that `test_written_files` draws."""

    K, M, size = SPRING, MASS, N

    def __init__(self, nodes=range(N), choices=()):
        self.labels = [(node, 1) for node in nodes]
        self._choices = list(choices)

    def draw(self, *choices):
        return self._choices.pop(0) if self._choices else choices[0]

    def triangle(self, matrix):
        rows, columns = np.nonzero(np.tril(matrix))
        return list(zip(rows, columns, matrix[rows, columns], strict=True))


def boeing(folder, *change, **options):
    """A Harwell-Boeing file of the chain, with a change of its text."""
    path, arguments = harwell_boeing(Chain(**options), folder)
    text = path.read_text(encoding="latin-1")
    path.write_text(text.replace(*change) if change else text, encoding="latin-1")
    return path, arguments


def matlab(folder, **variables):
    scipy.io.savemat(folder / "w.mat", variables or {"K": SPRING, "M": MASS})
    return folder / "w.mat", {}


def op4(folder, **matrices):
    pytest.importorskip("pyyeti.nastran.op4").write(str(folder / "w.op4"), matrices)
    return folder / "w.op4", {}


def labelled(folder, stiffness=SPRING):
    """As Abaqus does with FORMAT=MATRIX INPUT, in another order than the numbers."""
    for name, matrix in (("STIF2", stiffness), ("MASS2", MASS)):
        lines = ["** MATRIX", "*MATRIX"] + [
            f"{NODES[r]}, {DIRECTIONS[r]}, {NODES[c]}, {DIRECTIONS[c]}, {matrix[r, c]:.16e}"
            for r, c in zip(*np.nonzero(np.tril(matrix)), strict=True)
        ]
        (folder / f"job_{name}.mtx").write_text("\n".join(lines) + "\n")
    return folder / "job_STIF2.mtx", {}


def substructure(folder):
    path, _ = abaqus_substructure(Chain((10, 20, 35, 4711, 5000, 99999)), folder)
    return path, {"contact": [(99999, "x")]}


def solid_elements(folder):
    """KGG with six DOFs a grid; the others have neither mass nor stiffness, and keep numbers."""
    x = np.zeros((6 * N, N))
    x[6 * np.arange(N), np.arange(N)] = 1.0
    return op4(folder, KGG=x @ SPRING @ x.T, MGG=x @ MASS @ x.T)[0], {"contact": [30]}


def with_(made, **arguments):
    return made[0], arguments


OPTIONS = (True, (26, 16, "D"), 3, "1P,", 10, True)
TWO_SIZES = {"KGG": SPRING, "MGG": MASS, "KAA": np.eye(3), "MAA": np.eye(3)}
READ = {
    "right-hand sides of Ansys": lambda f: boeing(f, choices=OPTIONS * 2),
    "exponents without letter": lambda f: boeing(f, "E+0", "+00"),
    "substructure of Abaqus": substructure,
    "deep struct": lambda f: matlab(f, model={"red": {"stiffness": SPRING, "mass": MASS}}),
    "names": lambda f: with_(matlab(f, Q=SPRING, R=MASS), names={"stiffness": "Q", "mass": "R"}),
    "solid elements": solid_elements,
    "two sizes": lambda f: with_(op4(f, **TWO_SIZES), names={"stiffness": "KGG"}),
}


@pytest.mark.oracle
@pytest.mark.parametrize("kind", READ)
def test_the_chain_has_its_frequencies_out_of_every_file(kind, tmp_path):
    path, arguments = READ[kind](tmp_path)
    np.testing.assert_allclose(frequencies(path, **arguments), HERTZ, rtol=1e-9)


@pytest.mark.oracle
def test_contacts_are_named_by_nodes(tmp_path):
    path, _ = labelled(tmp_path)
    found = load(path, [(4711, "z"), (7, 12, "x")])
    places = zip(NODES, DIRECTIONS, strict=True)
    order = [found.labels.dof(node, "xyz"[k - 1]) for node, k in places]
    np.testing.assert_allclose(found.stiffness.toarray()[np.ix_(order, order)], SPRING)
    W = np.zeros((N, 2))
    W[1, 0] = W[4, 1] = 1.0
    W[2, 1] = -1.0
    np.testing.assert_array_equal(found.directions.toarray()[order], W)
    found.save(tmp_path / "again.npz")
    again = rom.load_structure(tmp_path / "again.npz")
    np.testing.assert_array_equal(again.labels.table, found.labels.table)


def full_file():
    """The clamped aluminium beam that comes with the reader: 25 x 25 x 125 mm."""
    reader = pytest.importorskip("ansys.mapdl.reader")
    return Path(reader.__file__).parent / "examples" / "file.full"


@pytest.mark.oracle
def test_a_full_file_of_ansys_is_the_beam_that_it_says():
    found = load(full_file(), [(300, "x")])
    assert (found.n_dofs, found.labels.dof(63, "z")) == (900, 2)  # 63 of 963 are held
    K, M = found.stiffness.toarray(), found.mass.toarray()
    frequency = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[:6]) / (2.0 * np.pi)
    sound, length, height = np.sqrt(7e10 / 2700.0), 0.125, 0.025
    bending = 1.8751**2 / (2.0 * np.pi) * sound * height / np.sqrt(12.0) / length**2
    assert frequency[5] == pytest.approx(sound / (4.0 * length), rel=2e-3)  # along the beam
    # a beam this short is softer than a slender one, by 3 % (Timoshenko)
    np.testing.assert_allclose(frequency[:2], 0.97 * bending, rtol=1e-2)


def test_what_is_left_out_or_changed_is_said(tmp_path, caplog):
    """DOFs held by a boundary condition, asymmetric rounding, matrices that are no damping."""
    held = SPRING.copy()
    held[5, 5] = 1e36
    assert load(labelled(tmp_path, held)[0], [(4711, "x")]).n_dofs == N - 1
    rounded = SPRING.copy()
    rounded[0, 1] *= 1.0 + 2e-9
    path, _ = matlab(tmp_path, K=rounded, M=MASS, D=3.0 * np.eye(N), C=np.eye(N, k=1))
    found = load(path)
    np.testing.assert_array_equal(found.stiffness.toarray(), found.stiffness.toarray().T)
    assert found.beta == 0.0
    damped = load(path, names={"damping": "D"})
    np.testing.assert_array_equal(damped.damping.toarray(), 3.0 * np.eye(N))
    for words in ("1 DOFs are fixed", "stiffness is symmetrised", "C is not symmetric",
                  "D is diagonal, as matrices of eigenvalues are"):  # fmt: skip
        assert words in caplog.text


def without_mass(folder):
    (folder / "job.sti").write_text("1 1 2.0\n")  # of CalculiX
    return folder / "job.sti", {}


def unknown_mass(folder):
    labelled(folder)
    with (folder / "job_MASS2.mtx").open("a") as file:
        file.write("99, 1, 99, 1, 1.0\n")
    return folder / "job_STIF2.mtx", {}


def several_elements(folder):
    path, _ = substructure(folder)
    text = path.read_text()
    path.write_text(text.replace("*USER", "** ELEMENT NUMBER 2\n*USER") + text)
    return path, {}


AMBIGUOUS = {"K1": SPRING, "K2": SPRING, "M": MASS, "Kel": np.eye(3)}
REFUSED = {
    "has the type CSA; must be RSA or RUA": lambda f: boeing(f, "RSA", "CSA"),
    "is not a number": lambda f: boeing(f, "E+05", "E+x5"),
    "has the matrices of several elements": several_elements,
    'K1 (6 DOFs), K2 (6 DOFs) may each be stiffness; choose one: names={"stiffness": "K1"}':
        lambda f: matlab(f, **AMBIGUOUS),
    "stiffness = 'Q' is not in the file, which has K1, K2, M, Kel":
        lambda f: with_(matlab(f, **AMBIGUOUS), names={"stiffness": "Q"}),
    "stiffness is missing; the file has Q, R; name it": lambda f: matlab(f, Q=SPRING, R=MASS),
    "mass is missing (there is no job.mas); give its file: mass=": without_mass,
    "mass: must hold real numbers, got complex128":
        lambda f: matlab(f, K=SPRING, M=MASS * (1 + 0.01j)),
    "mass has 5 DOFs, stiffness has 6": lambda f: matlab(f, K=SPRING, M=MASS[1:, 1:]),
    "mass: node 99 has a DOF that is not in stiffness": unknown_mass,
    "node 13: is not in the structure, whose nodes are 7 to 4711":
        lambda f: with_(labelled(f), contact=[(13, "x")]),
    "the file names no nodes": lambda f: with_(matlab(f), contact=[(7, "x")]),
    "contact: is missing; give contact=": lambda f: with_(matlab(f), contact=None),
    "no such .npz file or folder": lambda f: (f / "absent.npz", {}),
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_other_files_are_refused_in_one_line(message, tmp_path):
    path, arguments = REFUSED[message](tmp_path)
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.load_structure(path, **{"contact": [N - 1]} | arguments)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)
