"""Full-order integration with elastic contacts: closed forms, order, continuation."""

import numpy as np
import pytest
from beside_oracle import with_laws
from oracles.system import Frictional, jenkins
from oracles.time_integration import integrate

from slipmode import rom
from slipmode.rom import Contacts, FrictionalContact, Jenkins, full

HEAVY = 1e9  # mass whose motion no contact disturbs
TURN = 2 * np.pi


def prescribed(columns, stiffness=0.0, others=1):
    """Heavy masses, one on each contact DOF, and light ones beside them; free to move."""
    masses = np.append(np.full(columns, HEAVY), np.ones(others))
    springs = np.append(np.full(columns, stiffness), np.ones(others))
    W = np.eye(len(masses))[:, :columns]
    return rom.Structure(np.diag(masses), np.diag(springs), 0.0, contact=W)


def shaken(law, X, samples, turns=3, **options):
    """x = -X cos(t) on one contact DOF of a free mass."""
    structure = prescribed(1)
    excitation = full.Excitation.harmonic(structure, ({0: HEAVY * X},), (1.0,))
    start = full.State(0.0, np.array([-X, 0.0]), np.zeros(2))
    times = TURN * np.linspace(0.0, turns, turns * samples + 1)
    return full.integrate(structure, law, excitation, times, start=start, **options)


# Closed forms


@pytest.mark.oracle
def test_jenkins_element_under_one_harmonic():
    """Masing's loop, and its area."""
    limit, stiffness, X = 2.0, 4.0, 3.0
    motion = shaken(Jenkins(limit, stiffness), X, 64, steps_per_period=1024)
    x, force = motion.contact_displacement[64:128, 0], motion.contact_force[64:128, 0]
    np.testing.assert_allclose(x, -X * np.cos(motion.time[64:128]), atol=1e-6)
    up = np.minimum(-limit + stiffness * (x[:32] + X), limit)
    down = np.maximum(limit + stiffness * (x[32:] - X), -limit)
    np.testing.assert_allclose(force, np.append(up, down), atol=1e-4)
    work = motion.dissipated[128] - motion.dissipated[64]
    assert work == pytest.approx(4 * limit * (X - limit / stiffness), rel=1e-5)


@pytest.mark.oracle
def test_one_sided_spring():
    """A mass on a spring and, where it closes, on a second: 2 omega / (1 + omega / omega_open)."""
    k, k_n = 1.0, 5.0
    structure = rom.Structure(np.eye(3), np.diag([1.0, k, 1.0]), 0.0, contact=np.eye(3)[:, :2])
    law = FrictionalContact(mu=0.0, preload=0.0, tangential_stiffness=1.0, normal_stiffness=k_n)
    still = full.Excitation.harmonic(structure, ({0: 0.0},), (1.0,))
    start = full.State(0.0, np.zeros(3), np.array([0.0, 1.0, 0.0]))
    closed, opened = np.sqrt(k + k_n), np.sqrt(k)
    expected = 2 * closed / (1 + closed / opened)
    motion = full.integrate(structure, law, still, 40 * TURN / expected, step=0.004, start=start)
    x, t = motion.contact_displacement[:, 1], motion.time
    rising = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossing = t[rising] - x[rising] * (t[rising + 1] - t[rising]) / (x[rising + 1] - x[rising])
    assert TURN / np.diff(crossing).mean() == pytest.approx(expected, rel=1e-5)
    assert motion.contact_displacement[:, 0].max() == 0.0
    np.testing.assert_allclose(motion.contact_force[:, 1], k_n * np.maximum(x, 0.0), atol=1e-12)
    speed = np.abs(motion.contact_velocity[rising, 1])
    np.testing.assert_allclose(speed, 1.0, rtol=1e-3)  # no energy is lost


def circling(samples):
    """Two tangential directions on a circle of unit radius; the force of the last instant."""
    law = FrictionalContact(
        mu=0.5, preload=4.0, tangential_stiffness=4.0, normal_stiffness=1.0, tangents=2
    )
    structure = prescribed(3)
    force = ({0: -HEAVY}, {1: -HEAVY})
    excitation = full.Excitation.harmonic(structure, force, (1.0, 1.0), (0.0, -np.pi / 2))
    start = full.State(0.0, np.array([1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0]))
    return full.integrate(
        structure, law, excitation, [4 * TURN], steps_per_period=samples, start=start
    )


@pytest.mark.oracle
def test_two_directions_under_circular_motion():
    """mu N against the motion, turned by asin(rho / X), rho = mu N / k_t: the slider lags."""
    errors = []
    for samples in (32, 64, 128):
        force = circling(samples).contact_force[0]
        assert np.hypot(*force[:2]) == pytest.approx(2.0, rel=1e-9)
        errors.append(np.abs(force[:2] - 2.0 * np.array([0.5, np.sqrt(0.75)])).max())
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.05)


# Against an independent integrator


def chain():
    """Six masses free at both ends, three contact directions, dashpots."""
    springs = np.array([0.0, 1.3, 0.8, 1.1, 0.9, 1.2])
    K = np.diag(springs + np.append(springs[1:], 0.0))
    K -= np.diag(springs[1:], 1) + np.diag(springs[1:], -1)
    W = np.zeros((6, 3))
    W[2, 0] = W[4, 1] = W[1, 2] = 1.0
    W[5, 0] = W[3, 2] = -1.0
    M = np.diag([1.0, 2.0, 1.5, 1.0, 0.7, 1.2])
    return rom.Structure(M, K, np.diag([0.1, 0.05, 0.02, 0.05, 0.02, 0.05]), contact=W)


MIXED = Contacts(
    [
        (Jenkins(0.06, 5.0), (0,)),
        (
            FrictionalContact(mu=0.5, preload=0.1, tangential_stiffness=6.0, normal_stiffness=8.0),
            (1, 2),
        ),
    ]
)


def chain_excitation(structure):
    return full.Excitation.harmonic(structure, ({0: 0.15}, {1: 0.25}), (0.98, 1.65), (0.3, -1.0))


@pytest.mark.oracle
def test_a_free_structure_with_two_laws_agrees_with_the_oracle_and_converges():
    structure, t_end = chain(), 60.0
    system = with_laws(structure, [jenkins(0.06, 5.0), Frictional(0.5, 0.1, 6.0, 8.0)])
    columns = np.eye(6)[:, :2] * [0.15, 0.25]

    def signals(t):
        return np.cos(np.outer(t, [0.98, 1.65]) + np.array([0.3, -1.0]))

    exact, rough = (
        integrate(system, columns, signals, t_end, 200 * each, each) for each in (1600, 800)
    )
    own = np.linalg.norm(exact.x - rough.x)
    steps, errors = 0.08 / 2.0 ** np.arange(4), []
    for step in steps:
        motion = full.integrate(structure, MIXED, chain_excitation(structure), exact.t, step=step)
        errors.append(np.linalg.norm(motion.displacement - exact.x))
    assert own < 3e-4 * np.linalg.norm(exact.x)
    assert errors[-1] < 1e-3 * np.linalg.norm(exact.x)
    assert errors[0] > 3.0 * errors[-1]  # the last one is mostly the oracle's
    normal, tangential = 0.1 + motion.contact_force[:, 2], np.abs(motion.contact_force[:, 1])
    slips = tangential >= (1.0 - 1e-9) * 0.5 * normal
    for state in (normal <= 1e-12, slips & (normal > 0.0), ~slips):
        assert state.any()


# States


def test_end_state_continues_the_motion():
    structure = chain()
    excitation = chain_excitation(structure)
    whole = full.integrate(structure, MIXED, excitation, np.linspace(0.0, 40.0, 81))
    first = full.integrate(structure, MIXED, excitation, np.linspace(0.0, 20.0, 41))
    rest = np.linspace(20.5, 40.0, 40)
    second = full.integrate(structure, MIXED, excitation, rest, start=first.end)
    np.testing.assert_allclose(second.displacement, whole.displacement[41:], atol=1e-9)
    np.testing.assert_allclose(second.contact_force, whole.contact_force[41:], atol=1e-8)
    np.testing.assert_allclose(second.end.contact_memory, whole.end.contact_memory, atol=1e-9)
    total = first.dissipated[-1] + second.dissipated[-1]
    assert total == pytest.approx(whole.dissipated[-1], rel=1e-8)
    forgetful = full.State(first.end.time, first.end.displacement, first.end.velocity)
    other = full.integrate(structure, MIXED, excitation, rest, start=forgetful)
    assert np.abs(other.displacement - whole.displacement[41:]).max() > 1e-3


# The step itself


def oscillator():
    """A mode in resonance, one above, and a stiff one; all see the contact."""
    return rom.Structure(
        np.eye(3), np.diag([1.0, 40.0, 1e8]), np.diag([0.01, 0.1, 1.0]), contact=np.ones((3, 1))
    )


@pytest.mark.oracle
@pytest.mark.parametrize("frequency", [0.9, 1.13, 1.4])
def test_a_response_at_the_forcing_frequency_is_exact_at_any_step(frequency):
    """Contacts that stick: plain trapezoids, sixteen a period, are 3 to 165 % off."""
    structure, law = oscillator(), Jenkins(limit=1e9, stiffness=0.3)
    excitation = full.Excitation.harmonic(structure, ({0: 1.0},), (frequency,))
    times = TURN / frequency * np.linspace(400.0, 420.0, 160)
    motion = full.integrate(structure, law, excitation, times, steps_per_period=4)
    K = structure.stiffness + 0.3 * np.ones((3, 3))
    Z = K - frequency**2 * np.eye(3) + 1j * frequency * np.asarray(structure.damping)
    x = np.linalg.solve(Z, [1.0, 0.0, 0.0])
    wave = np.exp(1j * frequency * times)[:, np.newaxis]
    for found, size in ((motion.displacement, x), (motion.velocity, 1j * frequency * x)):
        exact = np.real(size * wave)[:, 0]
        assert np.linalg.norm(found[:, 0] - exact) < 1.2e-3 * np.linalg.norm(exact)
