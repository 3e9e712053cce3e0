"""Modes to choose from, and the command that lists them."""

import numpy as np
import pytest
import scipy.linalg

from slipmode import rom
from slipmode.__main__ import main

pytestmark = pytest.mark.quick

SPRING = 3.0
LAW = rom.Jenkins(1.0, SPRING)


def chain(damping=0.02):
    """Ten masses in a row, held at one end; contacts at the third and the last."""
    stiffness = 2.0 * np.eye(10) - np.eye(10, k=1) - np.eye(10, k=-1)
    stiffness[-1, -1] = 1.0
    labels = rom.Labels(np.arange(101, 111), np.ones(10, dtype=int))
    return rom.Structure(np.eye(10), stiffness, damping, contact=[2, 9], labels=labels)


def exact(structure, spring, held=()):
    """Frequencies and shapes with springs at the contacts, and without the DOFs held."""
    W = np.asarray(structure.directions)
    K = structure.stiffness + spring * W @ W.T
    free = np.setdiff1d(np.arange(10), held)
    squares, shapes = scipy.linalg.eigh(K[np.ix_(free, free)])
    return np.sqrt(squares), np.eye(10)[:, free] @ shapes


@pytest.mark.oracle
def test_modes_of_every_state_of_the_contacts():
    C = np.diag(np.linspace(0.01, 0.05, 10))
    structure = chain(C)
    table = rom.modes(structure, LAW, 6)
    states = {"free": (0.0, ()), "stuck": (SPRING, ()), "bonded": (0.0, (2, 9))}
    assert set(table.states) == set(states) and table.reference == "stuck"
    for name, (spring, held) in states.items():
        omega, shapes = (each[..., :6] for each in exact(structure, spring, held))
        found = table.states[name]
        np.testing.assert_allclose(found.frequency, omega, rtol=1e-10)
        np.testing.assert_allclose(np.abs(found.shapes.T @ shapes), np.eye(6), atol=1e-9)
        damping = np.einsum("nk,nm,mk->k", shapes, C, shapes) / (2.0 * omega)
        np.testing.assert_allclose(found.damping, damping, rtol=1e-9)
        np.testing.assert_allclose(found.contact, found.shapes[[2, 9]].T, atol=1e-15)
        share = shapes.sum(axis=0) ** 2 / 10.0  # of all mass in x; no DOF is in y or z
        np.testing.assert_allclose(found.effective_mass, np.outer(share, [1, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(exact(structure, 0.0)[0][0], 2 * np.sin(np.pi / 42), rtol=1e-12)


@pytest.mark.oracle
def test_the_share_of_stiffness_due_to_contacts_is_lost_with_free_contacts():
    """1 - omega_free^2 / omega^2, with the free mode of the most similar shape."""
    for law, spring, held in ((LAW, SPRING, ()), (None, 0.0, (2, 9))):
        table = rom.modes(chain(), law, 6)
        omega, shapes = (each[..., :6] for each in exact(chain(), spring, held))
        free, free_shapes = (each[..., :6] for each in exact(chain(), 0.0))
        similar = np.abs(shapes.T @ free_shapes).argmax(axis=1)
        np.testing.assert_array_equal(table.free_mode, similar)
        share = np.clip(1.0 - (free[similar] / omega) ** 2, 0.0, 1.0)
        np.testing.assert_allclose(table.stiffness_share, share, atol=1e-9)
        for mode in np.ravel(table.pairs):  # touched by friction, and apart from the others
            assert share[mode] > 1e-3
            assert np.abs(np.delete(omega, mode) / omega[mode] - 1.0).min() > 0.05
        moved = free_shapes[[2, 9]][:, similar].T if law is None else shapes[[2, 9]].T
        np.testing.assert_allclose(np.abs(table.contact), np.abs(moved), atol=1e-9)
    assert rom.modes(chain(), LAW, 6).pairs
    assert rom.modes(chain(), rom.Jenkins(1.0, 1e-6), 6).pairs == ()


@pytest.mark.oracle
def test_a_body_that_floats_has_one_rigid_body_mode_in_every_state(recwarn):
    stiffness = 1e4 * (2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1))
    stiffness[0, 0] = stiffness[-1, -1] = 1e4
    W = np.array([[1.0], [-1.0], [0.0], [0.0]])
    table = rom.modes(rom.Structure(np.eye(4), stiffness, contact=W), LAW)
    for state in table.states.values():
        assert np.flatnonzero(state.frequency == 0.0).tolist() == [0]
    assert np.all(np.isfinite(table.stiffness_share)) and table.stiffness_share[0] == 0.0
    assert not recwarn.list  # that frequency is plausible


@pytest.mark.oracle
def test_every_dof_may_be_a_contact_of_an_elastic_law():
    structure = rom.Structure(np.eye(2), np.diag([1e4, 3e4]), 1e-5, contact=(0, 1))
    law = rom.Jenkins(1.0, 1e3)
    found = rom.modes(structure, law)
    assert list(found.states) == ["free", "stuck"]
    np.testing.assert_allclose(found.states["stuck"].frequency ** 2, [1.1e4, 3.1e4])
    np.testing.assert_allclose(rom.reduce(structure, law=law).frequency ** 2, [1.1e4, 3.1e4])


@pytest.mark.oracle
def test_the_command_lists_modes_of_files_and_scenes(tmp_path, capsys):
    structure = chain()
    structure.save(tmp_path / "chain.npz")
    assert main(["modes", str(tmp_path / "chain.npz"), "--stiffness", "3", "-n", "3"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 6 and printed[-2].startswith("recommended pairs: ")
    for column, (spring, held) in enumerate(((0.0, ()), (SPRING, ()), (0.0, (2, 9))), start=1):
        hertz = exact(structure, spring, held)[0][0] / (2.0 * np.pi)
        assert float(printed[1].split()[column]) == pytest.approx(hertz, rel=1e-4)
    assert main(["modes", "two-mode"]) == 0
    assert "bonded rad/s" in capsys.readouterr().out
    assert main(["modes", "two-mode", "--stiffness", "3"]) == 1
    assert "are in the scene; leave them out" in capsys.readouterr().err


def test_contacts_by_node_on_the_command_line(tmp_path, capsys):
    for ending, matrix in (("sti", chain().stiffness), ("mas", chain().mass)):
        rows, columns = np.nonzero(np.tril(matrix))
        lines = [f"{r + 1} {c + 1} {matrix[r, c]}\n" for r, c in zip(rows, columns, strict=True)]
        (tmp_path / f"job.{ending}").write_text("".join(lines))
    (tmp_path / "job.dof").write_text("".join(f"{node}.1\n" for node in range(101, 111)))
    command = ["modes", str(tmp_path / "job.sti"), "-n", "3", "--contact"]
    assert main([*command, "105:x", "109-110:x"]) == 0
    assert "bonded Hz" in capsys.readouterr().out
    for wrong, message in (("99:x", "node 99: is not in the"), ("up", "--contact: must be DOFs")):
        assert main([*command, wrong]) == 1
        assert message in capsys.readouterr().err
