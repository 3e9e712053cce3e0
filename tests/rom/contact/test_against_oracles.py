"""Friction terms of whole structures against independent time integration.

S_j at amplitudes a demands the forces F_j = 2 (D_j a_j - S_j), D_j = omega_j^2 - Omega_j^2 +
i gamma_j Omega_j. Integrated in time, the structure must move with a under them.
"""

import numpy as np
import pytest
import scipy.linalg
from beside_oracle import steady_amplitudes
from oracles.system import Coulomb, Frictional, Sliders, System, Tanh, jenkins

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation

pytestmark = pytest.mark.oracle

FRICTION = Frictional(mu=0.4, preload=0.3, tangential=4.0, normal=5.0)
SURFACE = rom.FrictionalContact(0.4, 0.3, 4.0, 5.0)
JOINT = rom.Sliders((0.05, 0.1, 0.2), (1.0, 1.5, 1.0))
# Laws of the oracle, elastic or rigid law, detuning of the forces, amplitudes, steps and lines
CASES = {
    "Jenkins": ([jenkins(0.3, 4.0), jenkins(0.2, 3.0)], rom.Jenkins((0.3, 0.2), (4.0, 3.0))),
    "sliders": ([Sliders(JOINT.limit, JOINT.stiffness)] * 2, JOINT),
    "lift-off": ([FRICTION], SURFACE),
    "tanh": ([Tanh(0.5, 0.1), Tanh(0.3, 0.1)], rom.Tanh((0.5, 0.3), 0.1)),
    "Coulomb": ([Coulomb(0.5), Coulomb(0.3)], rom.Coulomb((0.5, 0.3))),
}


def chain(laws):
    """Five masses between two walls, a damping ratio of 1 %, contacts on two of the masses.

    Rigid contacts are on light masses, with dashpots, on springs to those.
    """
    K = 20.0 * (2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1))
    M, W, dashpot = np.diag([1.0, 1.3, 0.8, 1.1, 0.9]), np.eye(5)[:, [1, 3]], 0.0
    if isinstance(laws[0], Tanh | Coulomb):
        springs, dashpot = np.array([4.0, 3.0]), 0.05
        K = np.block([[K + W * springs @ W.T, -W * springs], [-(W * springs).T, np.diag(springs)]])
        M, W = scipy.linalg.block_diag(M, 0.02 * np.eye(2)), np.eye(7)[:, 5:]
    squares, shapes = scipy.linalg.eigh(System(M, K, K, W, laws).stuck(), M)
    C = M @ (shapes * 0.02 * np.sqrt(squares)) @ shapes.T @ M + dashpot * W @ W.T
    return System(M, C, K, W, laws)


def moved(system, law, detuning, a, grid, tolerance, steps):
    """Relative distance of the oracle's amplitudes from a, its error, and the contact terms."""
    structure = rom.Structure(system.M, system.K, system.C, contact=system.W)
    elastic = {} if isinstance(law, rom.Tanh | rom.Coulomb) else {"law": law}
    modes = tuple(range(len(a)))
    Omega = rom.reduce(structure, modes, **elastic).frequency * (1.0 + np.array(detuning))
    reduced = rom.reduce(structure, modes, **elastic, carrier=Omega)
    problem = ContactProblem.of(reduced, law, highest=15).on(Discretisation(*grid), 1e-7)
    terms = problem.solve([a])
    D = reduced.frequency**2 - Omega**2 + 1j * reduced.modal_damping * Omega
    F = 2.0 * (D * a - terms.S[0])
    force = F[:, np.newaxis] * (reduced.mode_shapes.T @ system.M)
    options = {"tolerance": tolerance, "steps": steps}
    b, own = steady_amplitudes(system, reduced, Omega, force, **options)
    return np.abs(b / a - 1.0), own / a, terms


@pytest.mark.parametrize("a", [0.12, 0.3])
@pytest.mark.parametrize("name", CASES)
def test_the_structure_moves_with_the_amplitude_of_one_mode(name, a):
    laws, law = CASES[name]
    grid = (2048, 1) if isinstance(law, rom.Tanh | rom.Coulomb) else (512, 1)
    rough = isinstance(law, rom.Coulomb)  # the oracle is
    steps = 8192 if rough else 512
    off, own, terms = moved(chain(laws), law, (-0.02,), np.array([a]), grid, 1e-5, steps)
    assert abs(terms.Q[0, 0]) > 0.05  # friction matters
    assert own < (2e-3 if rough else 1e-4)
    assert off <= own + 1e-5


@pytest.mark.parametrize("name", ["Jenkins", "lift-off", "tanh"])
def test_the_structure_moves_with_the_amplitudes_of_two_modes(name):
    laws, law = CASES[name]
    a = np.array([0.15, 0.07])
    off, own, _ = moved(chain(laws), law, (-0.03, -0.02), a, (256, 32), 1e-3, 128)
    assert np.all(own < 5e-3)
    assert np.all(off <= own + 1e-4)


@pytest.mark.parametrize("name", ["Jenkins", "sliders", "lift-off"])
def test_friction_dissipates_what_leaves_the_modes_and_what_forces_do_on_the_contacts(name):
    """Without other dampers; the force acts beside the contacts, and moves them directly."""
    laws, law = CASES[name]
    system, pattern = chain(laws), np.eye(5)[0]
    structure = rom.Structure(system.M, system.K, 0.0, contact=system.W)
    reduced = rom.reduce(structure, (0,), law=law, force_patterns=[pattern])
    problem = ContactProblem.of(reduced, law, highest=15).on(Discretisation(512, 1), 1e-8)
    terms = problem.solve([[0.1], [0.3]])
    assert np.all(np.abs(terms.by_forces) > 1e-3 * terms.power)
    np.testing.assert_allclose(terms.power, terms.leaving + terms.by_forces, rtol=1e-5)
