"""DOFs without mass follow the others statically, which is exact.

The oracle is the flexibility of a slender clamped beam, a^2 (3 b - a) / (6 E I) for the places
a <= b of force and displacement. Its inverse is the exact stiffness of the translations alone.
"""

import numpy as np
import pytest
import scipy.sparse
from oracles.harmonic_balance import balance
from oracles.system import System, jenkins
from written.matrices import LENGTH, beam, translations

from slipmode import rom
from slipmode.rom import full

pytestmark = [pytest.mark.quick, pytest.mark.oracle]


@pytest.mark.parametrize("axes", [np.eye(2), [[0.8, 0.6], [-0.6, 0.8]]], ids=["own", "turned"])
@pytest.mark.parametrize("law", [None, rom.Jenkins(limit=1.0, stiffness=500.0)])
@pytest.mark.parametrize("store", [np.asarray, scipy.sparse.csc_array])
def test_modes_are_those_of_the_translations(store, law, axes):
    """In turned axes of the nodes no row of the mass matrix is 0, but it stays singular."""
    (K, M), (stiffness, mass), T = beam(12), translations(12), np.kron(np.eye(12), axes)
    K, M = (store(0.5 * (A + A.T)) for A in (T.T @ K @ T, T.T @ M @ T))
    whole = rom.Structure(M, K, 1e-5, contact=T[[22]].T)
    alone = rom.Structure(mass, stiffness, 1e-5, contact=[11])
    found, expected = rom.modes(whole, law, 5), rom.modes(alone, law, 5)
    for state, modes in expected.states.items():
        np.testing.assert_allclose(found.states[state].frequency, modes.frequency, rtol=1e-8)
        np.testing.assert_allclose(found.states[state].damping, modes.damping, rtol=1e-7)
        shapes = np.abs(T @ found.states[state].shapes)[::2]
        np.testing.assert_allclose(shapes, np.abs(modes.shapes), atol=1e-6)
    assert (whole.n_modes, whole.n_dofs) == (12, 24)


def test_a_large_sparse_chain_has_the_frequencies_of_its_springs_in_series():
    """Masses with a massless node in the middle of each spring k: a chain with springs k / 2."""
    masses, k, m = 700, 3e4, 0.5  # above the size of dense algorithms
    size = 2 * masses
    diagonal = np.full(size, 2.0 * k)
    diagonal[-1] = k
    K = scipy.sparse.diags_array((diagonal, -k, -k), offsets=(0, 1, -1), shape=(size, size))
    M = scipy.sparse.diags_array(np.tile([0.0, m], masses))
    free = rom.modes(rom.Structure(M, K, contact=[size - 1]), n=4).states["free"]
    angle = np.pi * (2 * np.arange(1, 5) - 1) / (2 * (2 * masses + 1))
    np.testing.assert_allclose(free.frequency, 2.0 * np.sqrt(0.5 * k / m) * np.sin(angle))
    between = 0.5 * (free.shapes[1:-2:2] + free.shapes[3::2])
    np.testing.assert_allclose(free.shapes[2::2], between, atol=1e-8 * np.abs(between).max())


def test_a_free_beam_keeps_its_rigid_body_modes():
    K, M = beam(9)
    K, M = K[2:, 2:], M[2:, 2:]
    K[:2, :2] = K[-2:, -2:]
    K[0, 1] = K[1, 0] = -K[0, 1]  # the first element is gone: a free end
    free = rom.modes(rom.Structure(M, K, contact=[6]), n=4).states["free"]
    assert (free.frequency[:2] == 0.0).all()
    assert free.frequency[2] > 1.0
    angle, motion = free.shapes[1::2, :2], free.shapes[::2, :2]
    slope = np.diff(motion, axis=0) / LENGTH
    np.testing.assert_allclose(angle[:-1], slope, atol=1e-6 * np.abs(slope).max())


@pytest.mark.slow
def test_a_rigid_contact_on_a_rotation_is_the_limit_of_small_inertia():
    """The error of a small inertia is proportional to it: extrapolate to none."""
    K, M = beam(8)

    def answers(inertia):
        structure = rom.Structure(M + np.diag(np.tile([0.0, inertia], 8)), K, 1e-5, contact=[11])
        reduced, law = rom.reduce(structure, (0,)), rom.Tanh(0.02, 0.05)
        found = rom.steady_state(reduced, law, reduced.frequency, [{14: 0.5}])
        omega = rom.modes(structure, n=4).states["bonded"].frequency
        return np.concatenate([np.abs(found.amplitude), found.displacement(11), omega])

    np.testing.assert_allclose(answers(0.0), 2.0 * answers(5e-7) - answers(1e-6), rtol=1e-4)


def test_one_mass_among_many_motions_without_inertia_at_full_order():
    """Harmonic balance needs no mass. A contact and the force are on rotations."""
    K, M = beam(6)
    M[:8] = 0.0  # of the other translations
    W, F, law = np.eye(12)[:, [7, 3]], 0.3 * np.eye(12)[9], rom.Jenkins(limit=0.01, stiffness=50.0)
    structure = rom.Structure(M, K, 2e-4, contact=W)
    reduced = rom.reduce(structure, (0,), law=law)
    Omega = reduced.frequency
    X = balance(System(M, 2e-4 * K, K, W, 2 * [jenkins(0.01, 50.0)]), Omega[0], F + 0j)[1]
    found = rom.steady_state(reduced, law, Omega, [F])
    moved = [found.displacement(dof)[0] for dof in (7, 9, 10)]
    np.testing.assert_allclose(moved, np.abs(X[[7, 9, 10]]), rtol=5e-4)  # 2.1e-4: dampers
    whole = full.Excitation.harmonic(structure, [F], Omega)
    small = full.component_modes(structure, law, whole.patterns, 7.0 * Omega[0])
    excitation, outputs = small.projection.excitation(whole), small.projection.basis
    times = np.arange(250 * 64 + 1) * np.pi / 32 / Omega[0]
    motion = full.integrate(small.structure, law, excitation, times, outputs=outputs)
    moved = 2.0 * np.exp(-1j * Omega[0] * motion.time[-64:]) @ motion.displacement[-64:] / 64
    np.testing.assert_allclose(moved[[7, 9, 10]], X[[7, 9, 10]], rtol=1e-4)  # 3.3e-5
