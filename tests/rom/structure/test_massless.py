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


def pair(nodes, store=np.asarray, contact=None):
    """The beam with rotations, and the beam of translations alone."""
    contact = nodes - 1 if contact is None else contact
    (K, M), (stiffness, mass) = beam(nodes), translations(nodes)
    whole = rom.Structure(store(M), store(K), 1e-5, contact=[2 * contact])
    return whole, rom.Structure(mass, stiffness, 1e-5, contact=[contact])


@pytest.mark.parametrize("law", [None, rom.Jenkins(limit=1.0, stiffness=500.0)])
@pytest.mark.parametrize("store", [np.asarray, scipy.sparse.csc_array])
def test_modes_are_those_of_the_translations(store, law):
    whole, alone = pair(12, store)
    found, expected = rom.modes(whole, law, 5), rom.modes(alone, law, 5)
    for state, modes in expected.states.items():
        np.testing.assert_allclose(found.states[state].frequency, modes.frequency, rtol=1e-8)
        np.testing.assert_allclose(found.states[state].damping, modes.damping, rtol=1e-7)
        shapes = np.abs(found.states[state].shapes[::2])
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


@pytest.mark.filterwarnings("ignore:friction does not act")
def test_rotations_are_observed_and_loaded():
    """A stuck contact is a spring: the response to a moment follows from K + k W W^T - w^2 M."""
    whole, _ = pair(12)
    law = rom.Jenkins(limit=1e6, stiffness=500.0)
    reduced = rom.reduce(whole, (0,), law=law)
    omega = 0.8 * reduced.frequency
    found = rom.steady_state(reduced, law, omega, [{23: 1.0}])
    K, M = beam(12)
    C = 1e-5 * K
    K[22, 22] += 500.0
    x = np.linalg.solve(K + 1j * omega[0] * C - omega[0] ** 2 * M, np.eye(24)[23])
    moved = [found.displacement(dof)[0] for dof in (23, 22, 21, 1)]
    np.testing.assert_allclose(moved, np.abs(x[[23, 22, 21, 1]]), rtol=1e-4)


@pytest.mark.parametrize("law", [rom.Jenkins(limit=0.02, stiffness=50.0), rom.Tanh(0.02, 0.05)])
def test_a_contact_on_a_rotation_is_the_limit_of_small_inertia(law):
    """The error of a small inertia is proportional to it: extrapolate to none."""
    K, M = beam(8)
    elastic = law if isinstance(law, rom.Jenkins) else None

    def answers(inertia):
        structure = rom.Structure(M + np.diag(np.tile([0.0, inertia], 8)), K, 1e-5, contact=[11])
        reduced = rom.reduce(structure, (0,), law=elastic)
        found = rom.steady_state(reduced, law, reduced.frequency, [{14: 0.5}])
        held = rom.modes(structure, elastic, 4).states["stuck" if elastic else "bonded"]
        return np.concatenate([np.abs(found.amplitude), found.displacement(11), held.frequency])

    limit = 2.0 * answers(5e-7) - answers(1e-6)
    np.testing.assert_allclose(answers(0.0), limit, rtol=1e-4)


@pytest.mark.parametrize("store", [np.asarray, scipy.sparse.csc_array])
@pytest.mark.parametrize("law", [None, rom.Jenkins(limit=1.0, stiffness=500.0)])
def test_axes_of_the_nodes_do_not_matter(store, law):
    """In other axes no row of the mass matrix is 0, but it stays singular."""
    K, M = beam(9)
    axes = np.kron(np.eye(9), [[0.8, 0.6], [-0.6, 0.8]])
    contact = np.eye(18)[:, [8, 13]]  # a translation and a rotation
    given = rom.modes(rom.Structure(M, K, contact=contact), law, 5)
    turned = [axes.T @ matrix @ axes for matrix in (M, K)]
    structure = rom.Structure(*(store(0.5 * (A + A.T)) for A in turned), contact=axes.T @ contact)
    found = rom.modes(structure, law, 5)
    assert structure.n_modes == 9
    for state, modes in given.states.items():
        np.testing.assert_allclose(found.states[state].frequency, modes.frequency, rtol=1e-9)
        shapes = np.abs(axes @ found.states[state].shapes)
        np.testing.assert_allclose(shapes, np.abs(modes.shapes), atol=1e-9)


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
    period = 2.0 * np.pi / Omega[0]
    whole = full.Excitation.harmonic(structure, [F], Omega)
    small = full.component_modes(structure, law, whole.patterns, 7.0 * Omega[0])
    for of, excitation, outputs in (
        (structure, whole, None),
        (small.structure, small.projection.excitation(whole), small.projection.basis),
    ):
        times = np.arange(250 * 64 + 1) * period / 64
        motion = full.integrate(of, law, excitation, times, outputs=outputs)
        x, phase = motion.displacement[-64:], np.exp(-1j * Omega[0] * motion.time[-64:])
        moved = 2.0 * phase @ x[:, [7, 9, 10]] / 64
        np.testing.assert_allclose(moved, X[[7, 9, 10]], rtol=1e-4)  # 3.3e-5
