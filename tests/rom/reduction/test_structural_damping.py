"""Structural damping beside direct solutions of K + i K'' - Omega^2 M, and harmonic balance."""

import numpy as np
import pytest
import scipy.sparse
from oracles.harmonic_balance import balance
from oracles.system import System, jenkins

from slipmode import rom
from slipmode.rom import full

pytestmark = pytest.mark.oracle

SIZE = 6
M = 0.5 * np.eye(SIZE)
K = np.diag([2e4, 2e4, 2.3e4, 2e4, 2e4, 1.05e4]) - 1e4 * (np.eye(SIZE, k=1) + np.eye(SIZE, k=-1))
W, F = np.eye(SIZE)[:, [1, 4]], np.eye(SIZE)[5]
PART = np.zeros((SIZE, SIZE))  # of a lossy part, not proportional to K
PART[:3, :3] = 0.04 * K[:3, :3]
PART[5, 5] = 60.0
GIVEN = {"factor": (K, rom.LossFactor(0.03), 0.03 * K), "part": (K + 1j * PART, 0.0, PART)}


@pytest.mark.quick
@pytest.mark.parametrize("given", GIVEN)
@pytest.mark.parametrize("store", [np.asarray, scipy.sparse.csc_array])
@pytest.mark.filterwarnings("ignore:friction does not act", "ignore:frequency is far")
def test_stuck_contacts_leave_the_complex_solution(given, store):
    stiffness, damping, loss = GIVEN[given]
    structure = rom.Structure(store(M), store(stiffness), damping, contact=W)
    law = rom.Jenkins(limit=1e6, stiffness=3e3)
    reduced = rom.reduce(structure, (1,), law=law)
    for detuning in (0.7, 0.99, 1.0, 1.3):
        (Omega,) = detuning * reduced.frequency
        found = 2.0 * rom.steady_state(reduced, law, [Omega], [F]).displacement_harmonics()[0]
        exact = np.linalg.solve(K + 1j * loss + 3e3 * W @ W.T - Omega**2 * M, F)
        np.testing.assert_allclose(found, exact, atol=1e-12 * np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:friction hardly acts", "ignore:friction acts as a dashpot")
def test_rigid_contacts_that_slide_without_force():
    """Time integration follows from the equivalent viscous damping: exact at the carrier."""
    structure = rom.Structure(M, K + 1j * PART, contact=W)
    reduced, law = rom.reduce(structure, (0,)), rom.Tanh(1e-7, 0.1)
    x = 2.0 * rom.steady_state(reduced, law, reduced.frequency, [F]).displacement_harmonics()[0]
    exact = np.linalg.solve(K + 1j * PART - reduced.frequency**2 * M, F)
    np.testing.assert_allclose(x, exact, atol=1e-3 * np.abs(exact).max())  # 1e-4


@pytest.mark.parametrize("given", GIVEN)
@pytest.mark.filterwarnings("ignore:friction table misses its tolerance")
def test_friction_acts_beside_structural_damping(given, tmp_path):
    """Harmonic balance has i K'' at each harmonic, and K'' / Omega as time integration has."""
    stiffness, damping, loss = GIVEN[given]
    structure, law = rom.Structure(M, stiffness, damping, contact=W), rom.Jenkins(1.0, 3e3)
    (Omega,) = 0.95 * rom.reduce(structure, (0,), law=law).frequency
    reduced = rom.reduce(structure, (0,), carrier=[Omega], law=law, force_patterns=[F])
    laws = 2 * [jenkins(1.0, 3e3)]
    exact = balance(System(M, 0.0 * K, K, W, laws, loss), Omega, 3.0 * F + 0j)[1]
    found = rom.steady_state(reduced, law, [Omega], [3.0 * F])
    x = 2.0 * found.displacement_harmonics()[0]
    np.testing.assert_allclose(x, exact, atol=3e-4 * np.abs(exact).max())  # 1e-4
    viscous = balance(System(M, loss / Omega, K, W, laws), Omega, 3.0 * F + 0j)[1]
    excitation = full.Excitation.harmonic(structure, [3.0 * F], [Omega])
    motion = full.integrate(structure, law, excitation, np.arange(12801) * np.pi / 32 / Omega)
    x = 2.0 * np.exp(-1j * Omega * motion.time[-64:]) @ motion.displacement[-64:] / 64
    np.testing.assert_allclose(x, viscous, atol=5e-4 * np.abs(exact).max())  # 1e-4
    model = rom.tabulate(reduced, law, 1.5 * np.abs(found.amplitude), tolerance=1e-3)
    model.save(tmp_path / "model.rom")
    moved = rom.Model.load(tmp_path / "model.rom").reduced.at_carrier([1.1 * Omega])
    lost = structure.loss @ reduced.mode_shapes[:, 0] @ reduced.mode_shapes[:, 0] / Omega
    assert reduced.modal_damping == pytest.approx([lost])
    assert moved.modal_damping == pytest.approx([lost / 1.1])
    if given == "factor":
        assert rom.steady(model, [Omega], [3.0 * F]) == pytest.approx(found.amplitude, rel=2e-3)


@pytest.mark.quick
def test_modes_and_files_have_the_loss_factor(tmp_path):
    structure = rom.Structure(M, scipy.sparse.csc_array(K), rom.LossFactor(0.03), contact=W)
    structure.save(tmp_path / "lossy.npz")
    again = rom.load_structure(tmp_path / "lossy.npz")
    np.testing.assert_allclose(rom.modes(again, n=4).states["free"].damping, 0.015)
