"""The theory page: it has every equation that the code cites, in the code's own matrices."""

import re
from pathlib import Path

import numpy as np
import pytest

from slipmode import rom

ROOT = Path(__file__).parents[2]
THEORY = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
NUMBERS = re.compile(r"\b[Ee]qs?\. *((?:\(\d+\)(?:, |-| and | to |)?)+)")


def numbers(text):
    """Numbers in "(13), (14)" or "(22)-(25)"."""
    found = set()
    for first, last in re.findall(r"\((\d+)\)(?:-\((\d+)\))?", text):
        found |= set(range(int(first), int(last or first) + 1))
    return found


def test_every_equation_that_the_code_cites_is_in_the_table():
    cited = set()
    for folder in ("rom", "fmu", "runner", "benchmarks"):
        for path in (ROOT / folder).rglob("*.[pch]*"):
            if path.suffix in (".py", ".c", ".h"):
                for cites in NUMBERS.findall(path.read_text(encoding="utf-8")):
                    cited |= numbers(cites)
    assert {1, 13, 18, 20, 25, 31} <= cited
    rows = re.findall(r"^\| (\([^|]*\)) \|", THEORY, re.MULTILINE)
    assert cited - {n for row in rows for n in numbers(row)} == set()


def test_the_table_has_every_equation_and_files_that_are_there():
    table = THEORY.split("## Which file has what")[1]
    labels = set(re.findall(r"^\$\$ \(([\w-]+)\)$", THEORY, re.MULTILINE))
    assert len(labels) > 20
    assert set(re.findall(r"{eq}`([\w-]+)`", THEORY)) <= labels
    untold = {"effective", "root", "second", "power", "steady"}  # parts of those beside them
    assert labels - set(re.findall(r"{eq}`([\w-]+)`", table)) == untold
    named = re.findall(r"`([\w/]+\.(?:py|c|h))`", table)
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).is_file()] == []


@pytest.fixture(scope="module")
def structure():
    """Five DOFs in a chain, held at one end, two of them contacts, with masses in full."""
    K = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    K[4, 4] = 1.0
    M = np.eye(5) + 0.1 * (np.eye(5, k=1) + np.eye(5, k=-1))
    return rom.Structure(mass=M, stiffness=100.0 * K, damping=0.001, contact=(1, 3))


@pytest.mark.oracle
def test_the_contact_problem_has_the_matrices_of_the_page(structure):
    M, C, K = structure.mass, structure.damping, structure.stiffness
    E, V = np.eye(5)[:, [0, 2, 4]], np.eye(5)[:, [1, 3]]
    reduced = rom.reduce(structure, modes=(0, 1))
    phi = reduced.mode_shapes
    psi = V - E @ np.linalg.solve(E.T @ K @ E, E.T @ K @ V)
    X = psi - phi @ (phi.T @ M @ psi)
    impact = np.linalg.inv(V.T @ np.linalg.solve(M, V))
    expected = {
        "contact_shapes": X,
        "stiffness": X.T @ K @ X,
        "damping": X.T @ C @ X,
        "mass": impact,
        "carried_mass": X.T @ M @ X - impact,
        "spring": phi.T @ K @ X,
        "damper": phi.T @ C @ X,
        "modal_damping": np.diag(phi.T @ C @ phi),
    }
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(reduced, name), value, atol=1e-9, err_msg=name)
    nu = 3.0
    D, B = reduced.modal_stiffness(nu), reduced.modal_coupling(nu)
    H = B.T @ np.linalg.solve(D, B) + nu**2 * reduced.carried_mass
    np.testing.assert_allclose(reduced.reaction(nu), H, rtol=1e-9)


@pytest.mark.oracle
def test_the_dual_problem_has_the_matrices_of_the_page(structure):
    law = rom.Jenkins(limit=1.0, stiffness=50.0)
    reduced = rom.reduce(structure, modes=(0,), law=law)
    W, phi = structure.directions, reduced.mode_shapes
    W = np.asarray(W if isinstance(W, np.ndarray) else W.todense())
    stuck = structure.stiffness + 50.0 * W @ W.T
    X = np.linalg.solve(stuck, W) - phi @ (phi.T @ W) / reduced.frequency[0] ** 2
    np.testing.assert_allclose(reduced.contact_shapes, X, atol=1e-12)
    np.testing.assert_allclose(reduced.stiffness, -W.T @ X, atol=1e-12)
    np.testing.assert_allclose(reduced.spring, -(phi.T @ W), atol=1e-12)
