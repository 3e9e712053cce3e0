"""DOFs without mass: a clamped beam with lumped masses, whose rotations follow statically.

The oracle is the flexibility of a slender clamped beam, a^2 (3 b - a) / (6 E I) for the places
a <= b of force and displacement. Its inverse is the exact stiffness of the translations alone.
"""

import numpy as np
import pytest
import scipy.sparse
from written.matrices import LENGTH, beam, translations

from slipmode import rom
from slipmode.rom import ValidityWarning, full

pytestmark = pytest.mark.quick

CONTACT = 3  # the node with the contact


def pair(nodes, store=np.asarray, contact=None):
    """The beam with rotations, and the beam of translations alone."""
    contact = nodes - 1 if contact is None else contact
    (K, M), (stiffness, mass) = beam(nodes), translations(nodes)
    whole = rom.Structure(store(M), store(K), 1e-5, contact=[2 * contact])
    return whole, rom.Structure(mass, stiffness, 1e-5, contact=[contact])


@pytest.mark.parametrize("law", [None, rom.Jenkins(limit=1.0, stiffness=500.0)])
@pytest.mark.parametrize(("nodes", "store"), [(12, np.asarray), (12, scipy.sparse.csc_array)])
def test_modes_are_those_of_the_translations(nodes, store, law):
    whole, alone = pair(nodes, store)
    found, expected = rom.modes(whole, law, 5), rom.modes(alone, law, 5)
    for state, modes in expected.states.items():
        np.testing.assert_allclose(found.states[state].frequency, modes.frequency, rtol=1e-8)
        np.testing.assert_allclose(found.states[state].damping, modes.damping, rtol=1e-7)
        np.testing.assert_allclose(
            np.abs(found.states[state].shapes[::2]), np.abs(modes.shapes), atol=1e-6
        )
    assert (whole.n_modes, whole.n_dofs) == (nodes, 2 * nodes)
    with pytest.raises(rom.SlipmodeError, match="modes: must be 0 to"):
        rom.reduce(whole, (nodes,), law=law)


def test_a_large_sparse_chain_has_the_frequencies_of_its_springs_in_series():
    """Masses with a massless node in the middle of each spring k: a chain with springs k / 2."""
    masses, k, m = 700, 3e4, 0.5  # above the size of dense algorithms
    size = 2 * masses
    diagonal = np.full(size, 2.0 * k)
    diagonal[-1] = k
    K = scipy.sparse.diags_array((diagonal, -k, -k), offsets=(0, 1, -1), shape=(size, size))
    M = scipy.sparse.diags_array(np.tile([0.0, m], masses))
    found = rom.modes(rom.Structure(M, K, contact=[size - 1]), n=4)
    angle = np.pi * (2 * np.arange(1, 5) - 1) / (2 * (2 * masses + 1))
    expected = 2.0 * np.sqrt(0.5 * k / m) * np.sin(angle)
    np.testing.assert_allclose(found.states["free"].frequency, expected, rtol=1e-8)
    moved = found.states["free"].shapes
    between = 0.5 * (moved[1:-2:2] + moved[3::2])
    np.testing.assert_allclose(moved[2::2], between, atol=1e-8 * np.abs(moved).max())


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


def test_friction_is_that_of_the_translations():
    law = rom.Jenkins(limit=0.5, stiffness=2e3)
    answers = []
    for structure, scale in zip(pair(6, contact=CONTACT), (2, 1), strict=True):
        reduced = rom.reduce(structure, (0,), law=law)
        force = {5 * scale: 0.8}
        found = rom.steady_state(reduced, law, reduced.frequency, [force])
        answers.append(found.amplitude)
        excitation = full.Excitation.harmonic(structure, [force], reduced.frequency)
        motion = full.integrate(structure, law, excitation, [0.0, 0.1], outputs=[CONTACT * scale])
        answers.append(motion.displacement[-1])
    np.testing.assert_allclose(answers[0], answers[2], rtol=1e-6)
    np.testing.assert_allclose(answers[1], answers[3], rtol=1e-6)


def test_rotations_are_observed_and_loaded():
    """A stuck contact is a spring: the response to a moment follows from K + k W W^T - w^2 M."""
    whole, _ = pair(12)
    law = rom.Jenkins(limit=1e6, stiffness=500.0)
    reduced = rom.reduce(whole, (0,), law=law)
    omega = 0.8 * reduced.frequency
    with pytest.warns(ValidityWarning, match="no contact slips"):
        found = rom.steady_state(reduced, law, omega, [{23: 1.0}])
    K, M = beam(12)
    K[22, 22] += 500.0
    x = np.linalg.solve(K * (1 + 1e-5j * omega[0]) - omega[0] ** 2 * M, np.eye(24)[23])
    for dof in (23, 22, 21, 1):
        assert found.displacement(dof)[0] == pytest.approx(abs(x[dof]), rel=1e-4)


def refusal(**changed):
    K, M = beam(3)
    arguments = {"mass": M, "stiffness": K, "damping": 0.0, "contact": [0]} | changed
    with pytest.raises(rom.SlipmodeError) as refused:
        rom.Structure(**arguments)
    return str(refused.value)


def test_what_does_not_follow_statically_is_refused():
    K, M = beam(3)
    damper = np.zeros((6, 6))
    damper[3, 3] = 1.0
    assert "damping: DOF 3 has no mass" in refusal(damping=damper)
    rom.Structure(M, K, 0.3 * M + 1e-5 * K, contact=[0])
    empty = K.copy()
    empty[5, :] = empty[:, 5] = 0.0
    assert "mass, stiffness: DOF 5 has neither mass nor stiffness" in refusal(stiffness=empty)
    loose = K.copy()
    loose[1::2, :] = loose[:, 1::2] = 0.0
    loose[1::2, 1::2] = 1.0
    assert "positive definite on the 3 DOFs without mass" in refusal(stiffness=loose)
    coupled = M.copy()
    coupled[0, 1] = coupled[1, 0] = 0.01
    assert "mass: must be positive definite, except for DOFs without mass" in refusal(mass=coupled)
    structure = rom.Structure(M, K, contact=[0])
    excitation = full.Excitation.harmonic(structure, [{1: 1.0}], [1.0])
    with pytest.raises(rom.SlipmodeError, match="excitation: DOF 1 has no mass"):
        full.integrate(structure, rom.Jenkins(1.0, 10.0), excitation, 1.0)
    rotated = rom.Structure(M, K, contact=[3])
    excitation = full.Excitation.harmonic(rotated, [{0: 1.0}], [1.0])
    with pytest.raises(rom.SlipmodeError, match="contact: DOF 3 has no mass; at full order"):
        full.integrate(rotated, rom.Jenkins(1.0, 10.0), excitation, 1.0)
    for call in (rom.modes, rom.reduce):
        with pytest.raises(rom.SlipmodeError, match="contact: DOF 3 has no mass, which rigid"):
            call(rotated)


def test_an_elastic_contact_on_a_rotation_is_the_limit_of_small_inertia():
    """The error of a small inertia is proportional to it: extrapolate to none."""
    K, M = beam(8)
    law = rom.Jenkins(limit=0.02, stiffness=50.0)

    def answers(inertia):
        structure = rom.Structure(M + np.diag(np.tile([0.0, inertia], 8)), K, 1e-5, contact=[11])
        reduced = rom.reduce(structure, (0,), law=law)
        found = rom.steady_state(reduced, law, reduced.frequency, [{14: 0.5}])
        table = rom.modes(structure, law, 4)
        return np.concatenate(
            [np.abs(found.amplitude), found.displacement(11), table.states["stuck"].frequency]
        )

    limit = 2.0 * answers(5e-7) - answers(1e-6)
    np.testing.assert_allclose(answers(0.0), limit, rtol=1e-4)
