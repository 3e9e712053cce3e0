"""Modes to choose from, and the command that lists them."""

import numpy as np
import pytest
import scipy.io
import scipy.linalg

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import Labels

pytestmark = pytest.mark.quick

SPRING = 3.0


def beam():
    """Ten masses in a row, held at one end; contacts at the middle and the tip."""
    stiffness = 2.0 * np.eye(10) - np.eye(10, k=1) - np.eye(10, k=-1)
    stiffness[-1, -1] = 1.0
    labels = Labels(np.arange(101, 111), np.ones(10, dtype=int))
    return rom.Structure(np.eye(10), stiffness, 0.02, contact=[4, 9], labels=labels)


def exact(structure, spring, held=()):
    W = np.asarray(structure.directions)
    K = structure.stiffness + spring * W @ W.T
    free = np.setdiff1d(np.arange(10), held)
    return np.sqrt(scipy.linalg.eigvalsh(K[np.ix_(free, free)]))


def test_frequencies_of_every_state_and_damping():
    structure = beam()
    table = rom.modes(structure, rom.Jenkins(1.0, SPRING), 6)
    for name, spring, held in (("free", 0.0, ()), ("stuck", SPRING, ()), ("bonded", 0.0, (4, 9))):
        omega = exact(structure, spring, held)[:6]
        np.testing.assert_allclose(table.states[name].frequency, omega, rtol=1e-10)
        if name != "stuck":
            np.testing.assert_allclose(table.states[name].damping, 0.01 * omega, rtol=1e-9)
    assert table.reference == "stuck"
    reduced = rom.reduce(structure, table.pairs[0], law=rom.Jenkins(1.0, SPRING))
    np.testing.assert_allclose(
        reduced.frequency, table.states["stuck"].frequency[list(table.pairs[0])]
    )


def test_a_body_that_floats_also_with_its_contact_bonded():
    stiffness = 2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    stiffness[0, 0] = stiffness[-1, -1] = 1.0
    W = np.array([[1.0], [-1.0], [0.0], [0.0]])
    table = rom.modes(rom.Structure(np.eye(4), stiffness, contact=W), rom.Jenkins(1.0, SPRING))
    for name in ("free", "stuck", "bonded"):
        assert np.flatnonzero(table.states[name].frequency == 0.0).tolist() == [0]
    assert np.all(np.isfinite(table.stiffness_share)) and table.stiffness_share[0] == 0.0
    assert "nan" not in str(table)


def test_motion_of_contacts_and_effective_masses():
    table = rom.modes(beam(), rom.Jenkins(1.0, SPRING), 10)
    stuck = table.states["stuck"]
    np.testing.assert_allclose(stuck.contact, stuck.shapes[[4, 9]].T)
    share = stuck.shapes.sum(axis=0) ** 2 / 10.0
    np.testing.assert_allclose(stuck.effective_mass[:, 0], share, rtol=1e-12)
    assert np.all(stuck.effective_mass[:, 1:] == 0.0)  # no DOF is in these directions
    bonded = rom.modes(beam(), None, 4)
    assert bonded.reference == "bonded"
    assert np.all(bonded.states["bonded"].contact == 0.0)
    assert np.abs(bonded.contact).min(axis=1).max() > 0.0  # of the free modes


def test_pairs_are_touched_by_friction_and_apart():
    structure = beam()
    table = rom.modes(structure, rom.Jenkins(1.0, SPRING), 6)
    omega = table.states["stuck"].frequency
    for pair in table.pairs:
        for mode in pair:
            assert table.stiffness_share[mode] > 1e-3
            assert np.abs(np.delete(omega, mode) / omega[mode] - 1.0).min() > 0.05
    untouched = rom.modes(structure, rom.Jenkins(1.0, 1e-6), 6)
    assert untouched.pairs == ()
    assert "no pair" in str(untouched)


def test_the_command_lists_modes_of_files_and_scenes(tmp_path, capsys):
    structure = beam()
    structure.save(tmp_path / "beam.npz")
    assert main(["modes", str(tmp_path / "beam.npz"), "--stiffness", "3", "-n", "3"]) == 0
    printed = capsys.readouterr().out.splitlines()
    for word in ("free Hz", "stuck Hz", "bonded Hz", "rad/s", "damping", "m_x", "stiffness share"):
        assert word in printed[0]
    assert len(printed) == 6
    free = exact(structure, 0.0)[0] / (2 * np.pi)
    assert float(printed[1].split()[1]) == pytest.approx(free, rel=1e-4)
    assert printed[-2].startswith("recommended pairs: ")
    assert main(["modes", "two-mode"]) == 0
    assert "bonded rad/s" in capsys.readouterr().out
    assert main(["modes", "two-mode", "--stiffness", "3"]) == 1
    assert "are in the scene; leave them out" in capsys.readouterr().err


def test_contacts_by_node_on_the_command_line(tmp_path, capsys):
    matrices = beam()
    for name in ("mass", "stiffness"):
        rows, columns = np.nonzero(np.tril(getattr(matrices, name)))
        lines = [
            f"{r + 1} {c + 1} {getattr(matrices, name)[r, c]}"
            for r, c in zip(rows, columns, strict=True)
        ]
        (tmp_path / f"job.{name[:1].replace('s', 'sti').replace('m', 'mas')}").write_text(
            "\n".join(lines) + "\n"
        )
    (tmp_path / "job.dof").write_text("".join(f"{node}.1\n" for node in range(101, 111)))
    command = ["modes", str(tmp_path / "job.sti"), "-n", "3", "--contact"]
    assert main([*command, "105:x", "109-110:x"]) == 0
    assert "bonded Hz" in capsys.readouterr().out
    assert main([*command, "99:x"]) == 1
    assert "node 99: is not in the structure" in capsys.readouterr().err
    assert main([*command, "up"]) == 1
    assert "--contact: must be DOFs" in capsys.readouterr().err


def test_swapped_mass_and_stiffness_are_named(tmp_path, capsys):
    """Steel bars have 1 kHz; the inverse of the squares of their frequencies are below 1 mHz."""
    stiffness, mass = 1e8 * np.asarray(beam().stiffness), np.eye(10)
    swapped = rom.Structure(stiffness, mass, 0.0, contact=[4])
    with pytest.warns(rom.ValidityWarning, match="whether mass and stiffness are swapped") as seen:
        table = rom.modes(swapped, n=5)
    assert len(seen) == 1  # of all modes
    assert table.states["bonded"].hertz[0] < 1e-3
    swapped.save(tmp_path / "swapped.npz")
    assert main(["modes", str(tmp_path / "swapped.npz")]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("slipmode: warning: mode 0 has an implausible frequency")


def test_rigid_body_modes_are_plausible(recwarn):
    chain = 1e4 * (2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1))
    chain[0, 0] = chain[-1, -1] = 1e4
    table = rom.modes(rom.Structure(np.eye(5), chain, 0.0, contact=[2]), n=3)
    assert table.states["free"].frequency[0] == 0.0
    assert not recwarn.list
