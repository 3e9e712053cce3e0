"""Full order with rigid friction: exact solutions, orders, energy, independent integrators."""

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from beside_oracle import relative_rms
from oracles.system import Coulomb, System
from oracles.time_integration import integrate
from scipy.integrate import solve_ivp, trapezoid

from benchmarks.cases import many_contacts
from slipmode import rom
from slipmode.rom import full

REFERENCE = Path(__file__).parents[4] / "shared" / "data" / "reference"
FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)
LAW = rom.Tanh(2.0, 0.02)


@pytest.fixture
def structure():
    return rom.two_mass(beta=0.01)


def excitation_of(structure):
    return full.Excitation.harmonic(structure, FORCE, FREQUENCY, phase=(0.3, -1.0))


def chain(contacts=2):
    """Six masses, relative contacts, dashpots that the modes do not diagonalise."""
    springs = np.array([1.0, 1.3, 0.8, 1.1, 0.9, 1.2])
    stiffness = np.diag(springs + np.append(springs[1:], 0.0))
    stiffness -= np.diag(springs[1:], 1) + np.diag(springs[1:], -1)
    W = np.zeros((6, contacts))
    for contact, (node, other) in enumerate(((2, 0), (5, 3), (4, 1))[:contacts]):
        W[node, contact], W[other, contact] = 1.0, -1.0
    mass = np.diag([1.0, 2.0, 1.5, 1.0, 0.7, 1.2])
    dashpots = np.diag([0.1, 0.0, 0.02, 0.0, 0.0, 0.05])
    return rom.Structure(mass, stiffness, dashpots, contact=W)


def dense(matrix):
    return np.asarray(matrix)


def radau(structure, law, force, times, rtol=1e-9):
    """Displacements from rest by scipy's Radau IIA in the original coordinates."""
    M, C, K = (dense(getattr(structure, name)) for name in ("mass", "damping", "stiffness"))
    W, n = dense(structure.directions), structure.n_dofs
    limit = np.broadcast_to(law.limit, structure.n_contacts)
    inverse = np.linalg.inv(M)

    def rate(t, z):
        friction = W @ (limit * np.tanh(W.T @ z[n:] / law.alpha))
        return np.append(z[n:], inverse @ (force(t) - K @ z[:n] - C @ z[n:] - friction))

    def jacobian(t, z):
        slope = W @ np.diag(limit / law.alpha / np.cosh(W.T @ z[n:] / law.alpha) ** 2) @ W.T
        return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ (C + slope)]])

    span = (0.0, times[-1])
    options = {"method": "Radau", "rtol": rtol, "atol": 1e-3 * rtol, "jac": jacobian}
    return solve_ivp(rate, span, np.zeros(2 * n), t_eval=times, **options).y[:n].T


def harmonic_force(structure):
    """The force vector of excitation_of, over time."""

    def force(t):
        f = np.zeros(structure.n_dofs)
        f[0] = 0.15 * np.cos(0.98 * t + 0.3)
        f[1] = 0.25 * np.cos(1.65 * t - 1.0)
        return f

    return force


def orders(errors):
    return np.log2(errors[:-1] / errors[1:])


# Accuracy


@pytest.mark.oracle
@pytest.mark.parametrize(
    "name", ["two masses", 3, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, "bar"))]
)
def test_tanh_friction_agrees_with_radau_to_fourth_order(name):
    """Of two limits, of relative contacts in a chain, of 30 contacts on a bar."""
    times = np.linspace(0.0, 8.0, 21)
    if name == "two masses":
        structure, law, step = rom.two_mass(beta=0.01), rom.Tanh([1.0, 0.5], 0.05), 0.016
    elif name == "bar":
        case, times = many_contacts(30, 1.0), np.linspace(0.0, 1.5, 8)
        structure, law, step = case.structure, rom.Tanh(case.law.limit, 0.05), 0.008
    else:
        structure, law, step = chain(name), rom.Tanh(0.05, 0.05), 0.08
    exact = radau(structure, law, harmonic_force(structure), times, rtol=1e-11)
    excitation, errors = excitation_of(structure), []
    for each in (step, step / 2, step / 4):
        motion = full.integrate(structure, law, excitation, times, step=each)
        errors.append(np.linalg.norm(motion.displacement - exact))
    # light contacts of the bar are stiff, which lowers the order there
    assert errors[-1] < (5e-5 if name == "bar" else 1e-5) * np.linalg.norm(exact)
    assert name == "bar" or np.all(orders(np.array(errors)) > 3.5)
    W = dense(structure.directions)
    np.testing.assert_allclose(motion.contact_displacement, motion.displacement @ W, atol=1e-13)
    np.testing.assert_allclose(motion.contact_velocity, motion.velocity @ W, atol=1e-13)


@pytest.mark.oracle
def test_coulomb_friction_agrees_with_the_oracle_and_converges(structure):
    force, t_end = ({0: 0.6}, {1: 1.0}), 60.0
    excitation = full.Excitation.harmonic(structure, force, FREQUENCY)
    matrices = structure.mass, structure.damping, structure.stiffness, structure.directions
    system = System(*map(dense, matrices), [Coulomb(2.0)] * 2)

    def signals(t):
        return np.cos(np.outer(t, FREQUENCY))

    columns = np.eye(4)[:, :2] * [0.6, 1.0]
    exact, rough = (
        integrate(system, columns, signals, t_end, 300 * each, each) for each in (640, 320)
    )
    own = np.linalg.norm(exact.x - rough.x) / np.linalg.norm(exact.x)
    motions = [
        full.integrate(structure, rom.Coulomb(2.0), excitation, exact.t, step=step)
        for step in (0.04, 0.01, 0.0025)
    ]
    errors = [
        np.linalg.norm(each.displacement - exact.x) / np.linalg.norm(exact.x) for each in motions
    ]
    assert np.any(motions[-1].contact_velocity[-100:] != 0.0)
    assert errors[-1] < 1e-4 + own
    assert errors[0] > 5.0 * errors[-1]


@pytest.mark.oracle
@pytest.mark.parametrize("name", ["two-mode", "one-mode", "near-commensurate"])
def test_stored_reference_signals(name):
    if not (REFERENCE / f"{name}.npz").exists():
        pytest.skip("the reference signals are not beside the repository")
    given = json.loads((REFERENCE / f"{name}.json").read_text())
    stored = np.load(REFERENCE / f"{name}.npz")
    structure = rom.two_mass(beta=given["damping_beta"])
    force = ({0: given["force_A"]}, {1: given["force_B"]})
    frequency = (given["omega_A"], given["omega_B"])
    excitation = full.Excitation.harmonic(structure, force, frequency)
    law = rom.Tanh(given["limit"], given["alpha"])
    result = full.converged(structure, law, excitation, stored["t"], step=0.02)
    difference = relative_rms(result.motion.displacement, stored["x"].astype(float))
    # of a second-order method, a third of its change on halving; single precision
    own_error = np.array(given["relative_rms_change_on_halving_the_step"]) / 3
    assert np.all(difference < 1.2 * own_error + result.displacement_error + 1e-7)


# Friction


@pytest.mark.oracle
def test_a_stuck_coulomb_contact_does_not_move_at_all(structure):
    times = np.linspace(0.0, 50.0, 501)
    motion = full.integrate(
        structure, rom.Coulomb(50.0), excitation_of(structure), times, steps_per_period=100
    )
    assert np.all(motion.contact_velocity == 0.0)
    assert np.all(motion.contact_displacement == 0.0)
    assert np.all(motion.dissipated == 0.0)
    parts = structure.partition()
    body, foot = scipy.linalg.block_diag, 1.0
    bonded = rom.Structure(body(parts.M_ee, foot), body(parts.K_ee, foot), 0.01, contact=(2,))
    exact = radau(bonded, rom.Tanh(0.0, 1.0), harmonic_force(bonded), times)[:, :2]
    assert np.all(relative_rms(motion.displacement[:, :2], exact) < 1e-5)


@pytest.mark.oracle
def test_energy_balance_to_fourth_order(structure):
    law, excitation = rom.Tanh(2.0, 0.05), excitation_of(structure)
    M, C, K = structure.mass, structure.damping, structure.stiffness

    def imbalance(step):
        motion = full.integrate(
            structure, law, excitation, np.linspace(0.0, 20.0, round(20 / step) + 1)
        )
        x, v, t = motion.displacement, motion.velocity, motion.time
        assert motion.steps == t.size - 1
        force = np.array([harmonic_force(structure)(now) for now in t])
        power = np.sum(force * v, axis=1) - np.einsum("ti,ij,tj->t", v, C, v)
        # trapezoidal sums at the step and at twice the step: Simpson's rule
        work = (4 * trapezoid(power, t) - trapezoid(power[::2], t[::2])) / 3
        stored = 0.5 * (v[-1] @ M @ v[-1] + x[-1] @ K @ x[-1])
        assert motion.dissipated[-1] > 0.2 * work
        return (work - stored - motion.dissipated[-1]) / work

    errors = np.abs([imbalance(step) for step in (0.01, 0.005, 0.0025)])
    assert errors[-1] < 1e-7
    assert np.all(orders(errors) > 3.5)


# Excitation and times


def scripted(structure):
    """A ramp and a sweep, then jumps of amplitude, frequency and phase at t = 7.3."""
    return full.Excitation(
        patterns=np.eye(structure.n_dofs)[:2],
        start=[0.0, 7.3],
        amplitude=[[0.0, 0.25], [0.3, 0.1]],
        amplitude_rate=[[0.03, 0.0], [0.0, 0.01]],
        frequency=[[0.9, 1.7], [1.1, 1.6]],
        frequency_rate=[[0.02, -0.01], [-0.01, 0.0]],
        phase=[[0.0, 0.5], [1.0, 0.5]],
        phase_rate=[[0.0, 0.0], [0.0, 0.05]],
    )


def scripted_force(t):
    """The same written out, theta from the integrals of the frequencies."""
    s = t - 7.3
    if s < 0:
        theta = (0.9 * t + 0.01 * t**2, 1.7 * t - 0.005 * t**2)
        return np.array([0.03 * t * np.cos(theta[0]), 0.25 * np.cos(theta[1] + 0.5), 0, 0])
    theta = (0.9 * 7.3 + 0.01 * 7.3**2 + 1.1 * s - 0.005 * s**2,)
    theta += (1.7 * 7.3 - 0.005 * 7.3**2 + 1.6 * s,)
    second = (0.1 + 0.01 * s) * np.cos(theta[1] + 0.5 + 0.05 * s)
    return np.array([0.3 * np.cos(theta[0] + 1.0), second, 0, 0])


@pytest.mark.oracle
@pytest.mark.parametrize("times", [np.linspace(0.0, 15.0, 31), [0.1, 3.7, 7.3, 7.4, 15.0]])
def test_scripted_excitation(structure, times):
    law = rom.Tanh(2.0, 0.05)
    exact = radau(structure, law, scripted_force, np.asarray(times))
    excitation = scripted(structure)
    motion = full.integrate(structure, law, excitation, times, step=2e-3)
    assert np.all(relative_rms(motion.displacement, exact) < 1e-5)
    force = [scripted_force(t)[:2] for t in times]
    np.testing.assert_allclose(excitation.at(motion.time)[2], force, atol=1e-12)


def test_outputs_are_dofs_or_combine_them_and_every_step_is_a_sample_by_default(structure):
    law, excitation = LAW, excitation_of(structure)
    rows = [[1.0, 0.0, -1.0, 0.0], [0.0, 2.0, 0.0, 0.5]]
    combined, single, one = (
        full.integrate(structure, law, excitation, 10.0, step=0.3, outputs=outputs)
        for outputs in (rows, None, [1])
    )
    np.testing.assert_allclose(combined.velocity, single.velocity @ np.transpose(rows), rtol=1e-12)
    np.testing.assert_array_equal(one.displacement[:, 0], single.displacement[:, 1])
    assert (one.time[0], one.time[-1]) == (0.0, 10.0)
    assert one.steps == one.time.size - 1 == 34


# Refusals


EARLY = full.State(-1.0, np.zeros(4), np.zeros(4))
REFUSED = [
    ({"times": [1.0, 1.0]}, "times: must be increasing"),
    ({"times": [-1.0, 1.0]}, "times: must not lie before"),
    ({"step": 0.0}, "step: must be"),
    ({"outputs": [[1.0]]}, "outputs: must be DOFs, or rows"),
    ({"start": EARLY}, "start: must not lie before"),
    ({"frequency": (0.98, 0.0)}, "frequency: must stay > 0"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_refuses_in_one_line(structure, change, message):
    given = {"structure": structure, "law": LAW, "times": 1.0, "frequency": FREQUENCY} | change
    frequency = given.pop("frequency")
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        excitation = full.Excitation.harmonic(structure, FORCE, frequency)
        full.integrate(excitation=excitation, **given)
    assert "\n" not in str(refusal.value)
