"""Full-order integration: exact solutions, orders, energy, independent integrators."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import solve_ivp, trapezoid

from benchmarks.cases import many_contacts
from slipmode import rom
from slipmode.rom import full
from slipmode.rom.full import coordinates
from slipmode.rom.full.convergence import relative_rms

REFERENCE = Path(__file__).parents[4] / "shared" / "data" / "reference"
FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)


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


def linear_solution(structure, times):
    """Displacements from rest without friction: particular solution and matrix exponential."""
    M, C, K = (dense(getattr(structure, name)) for name in ("mass", "damping", "stiffness"))
    n = structure.n_dofs
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    forced = np.zeros((len(times), 2 * n))
    for dof, F, Omega, phase in ((0, 0.15, 0.98, 0.3), (1, 0.25, 1.65, -1.0)):
        response = np.linalg.solve(K - Omega**2 * M + 1j * Omega * C, F * np.eye(n)[dof])
        wave = np.exp(1j * (Omega * times + phase))[:, np.newaxis]
        forced += np.real(wave * np.append(response, 1j * Omega * response))
    values, vectors = np.linalg.eig(A)
    start = np.linalg.solve(vectors, -forced[0].astype(complex))
    free = np.real((np.exp(np.outer(times, values)) * start) @ vectors.T)
    return (forced + free)[:, :n]


def orders(errors):
    return np.log2(errors[:-1] / errors[1:])


# Accuracy


@pytest.mark.parametrize(
    ("build", "coarsest"), [(lambda: rom.two_mass(beta=0.01), 0.02), (chain, 0.1)]
)
def test_without_friction_the_exact_solution_to_fourth_order(build, coarsest):
    structure = build()
    times = np.linspace(0.0, 20.0, 51)
    exact = linear_solution(structure, times)
    errors = [
        np.linalg.norm(
            full.integrate(
                structure, rom.Coulomb(0.0), excitation_of(structure), times, step=step
            ).displacement
            - exact
        )
        for step in (coarsest, coarsest / 2, coarsest / 4)
    ]
    assert errors[-1] < 1e-6 * np.linalg.norm(exact)
    np.testing.assert_allclose(orders(np.array(errors)), 4.0, atol=0.25)


def test_fourth_order_with_tanh_friction(structure):
    times, law = np.linspace(0.0, 20.0, 51), rom.Tanh(2.0, 0.05)
    excitation = excitation_of(structure)
    runs = [
        full.integrate(structure, law, excitation, times, step=step)
        for step in (0.02, 0.01, 0.005, 0.00125)
    ]
    # the contact velocity is stiff: between the order of the stages plus one, and four
    for signal, least in (("displacement", 3.6), ("contact_velocity", 2.8)):
        exact = getattr(runs[-1], signal)
        errors = [np.linalg.norm(getattr(run, signal) - exact) for run in runs[:-1]]
        assert np.all(orders(np.array(errors)) > least), signal


def test_beyond_first_order_with_coulomb_friction(structure):
    times = np.linspace(0.0, 60.0, 301)
    excitation = full.Excitation.harmonic(structure, ({0: 0.6}, {1: 1.0}), FREQUENCY)
    steps = (0.04, 0.01, 0.0025, 0.00025)
    runs = [
        full.integrate(structure, rom.Coulomb(2.0), excitation, times, step=step) for step in steps
    ]
    exact = runs[-1].displacement
    errors = [np.linalg.norm(run.displacement - exact) for run in runs[:-1]]
    assert np.any(runs[-1].contact_velocity[-100:] != 0.0)
    assert errors[-1] < 1e-4 * np.linalg.norm(exact)
    assert np.log(errors[0] / errors[-1]) / np.log(16.0) > 1.5


@pytest.mark.parametrize("law", [rom.Tanh(2.0, 0.02), rom.Tanh([1.0, 0.5], 0.05)])
def test_agrees_with_radau(structure, law):
    times = np.linspace(0.0, 12.0, 61)
    exact = radau(structure, law, harmonic_force(structure), times)
    motion = full.integrate(structure, law, excitation_of(structure), times, step=2e-3)
    assert np.all(relative_rms(motion.displacement, exact) < 1e-6)


@pytest.mark.parametrize("contacts", [1, 2, 3])
def test_relative_contacts_of_a_chain_agree_with_radau(contacts):
    structure, law = chain(contacts), rom.Tanh(0.05, 0.02)
    times = np.linspace(0.0, 20.0, 41)
    exact = radau(structure, law, harmonic_force(structure), times)
    motion = full.integrate(structure, law, excitation_of(structure), times, step=5e-3)
    assert np.all(relative_rms(motion.displacement, exact) < 1e-6)
    np.testing.assert_allclose(
        motion.contact_displacement, motion.displacement @ structure.directions, atol=1e-13
    )


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


def test_a_stuck_coulomb_contact_does_not_move_at_all(structure):
    times = np.linspace(0.0, 50.0, 501)
    motion = full.integrate(
        structure, rom.Coulomb(50.0), excitation_of(structure), times, steps_per_period=100
    )
    assert np.all(motion.contact_velocity == 0.0)
    assert np.all(motion.contact_displacement == 0.0)
    assert np.all(motion.dissipated == 0.0)
    parts = structure.partition()
    bonded = rom.Structure(
        scipy.linalg.block_diag(parts.M_ee, 1.0),
        scipy.linalg.block_diag(parts.K_ee, 1.0),
        0.01,
        contact=(2,),
    )
    exact = linear_solution(bonded, times)[:, :2]
    assert np.all(relative_rms(motion.displacement[:, :2], exact) < 1e-5)


def test_coulomb_is_the_limit_of_tanh(structure):
    times = np.linspace(0.0, 30.0, 151)
    excitation = full.Excitation.harmonic(structure, ({0: 0.6}, {1: 1.0}), FREQUENCY)
    exact = full.integrate(structure, rom.Coulomb(2.0), excitation, times, step=2e-3).displacement
    errors = [
        relative_rms(
            full.integrate(
                structure, rom.Tanh(2.0, alpha), excitation, times, step=2e-3
            ).displacement,
            exact,
        ).max()
        for alpha in (1e-2, 1e-3, 1e-4)
    ]
    assert errors[2] < 1e-3
    assert errors[2] < 0.2 * errors[1] < 0.04 * errors[0]


@pytest.mark.parametrize("alpha", [1.0, 1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("limit", [0.0, [0.0, 3.0], 1e-6, 2.0, 1e6])
def test_no_step_fails(structure, alpha, limit):
    excitation = full.Excitation.harmonic(structure, ({0: 3.0}, {1: 5.0}), FREQUENCY)
    motion = full.integrate(
        structure, rom.Tanh(limit, alpha), excitation, 100.0, steps_per_period=9
    )
    assert np.all(np.isfinite(motion.displacement))
    assert np.all(np.abs(motion.contact_force) <= limit)


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


# Coordinates, excitation and times


def test_diagonal_and_dense_damping_agree_to_rounding(structure, monkeypatch):
    law, times = rom.Tanh(2.0, 0.02), np.linspace(0.0, 30.0, 61)
    matrix = rom.Structure(structure.mass, structure.stiffness, structure.damping, contact=(2, 3))
    diagonal = full.integrate(matrix, law, excitation_of(structure), times)
    modal = coordinates.ModalCoordinates.of(matrix)
    assert modal.damping.ndim == 1
    dense = replace(modal, damping=np.diag(modal.damping))
    monkeypatch.setattr(coordinates.ModalCoordinates, "of", lambda structure: dense)
    full_matrix = full.integrate(matrix, law, excitation_of(structure), times)
    assert np.all(relative_rms(full_matrix.displacement, diagonal.displacement) < 1e-11)
    assert np.all(relative_rms(full_matrix.contact_velocity, diagonal.contact_velocity) < 1e-9)


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


@pytest.mark.parametrize("times", [np.linspace(0.0, 15.0, 31), [0.1, 3.7, 7.3, 7.4, 15.0]])
def test_scripted_excitation(structure, times):
    law = rom.Tanh(2.0, 0.05)
    exact = radau(structure, law, scripted_force, np.asarray(times))
    motion = full.integrate(structure, law, scripted(structure), times, step=2e-3)
    assert np.all(relative_rms(motion.displacement, exact) < 1e-5)


def test_end_state_continues_the_motion(structure):
    law, excitation = rom.Coulomb(0.5), excitation_of(structure)
    whole = full.integrate(structure, law, excitation, np.linspace(0.0, 40.0, 81))
    first = full.integrate(structure, law, excitation, np.linspace(0.0, 20.0, 41))
    second = full.integrate(
        structure, law, excitation, np.linspace(20.5, 40.0, 40), start=first.end
    )
    np.testing.assert_allclose(second.displacement, whole.displacement[41:], atol=1e-9)
    total = first.dissipated[-1] + second.dissipated[-1]
    assert total == pytest.approx(whole.dissipated[-1], rel=1e-9)


def test_every_step_is_a_sample_if_only_the_end_is_given(structure):
    motion = full.integrate(
        structure, rom.Coulomb(0.5), excitation_of(structure), 10.0, step=0.3, outputs=[1]
    )
    assert motion.time[0] == 0.0
    assert motion.time[-1] == 10.0
    assert motion.steps == motion.time.size - 1 == 34
    assert motion.displacement.shape == (35, 1)
    assert motion.displacement[0] == 0.0


def test_outputs_may_combine_dofs(structure):
    law, excitation = rom.Tanh(2.0, 0.02), excitation_of(structure)
    rows = [[1.0, 0.0, -1.0, 0.0], [0.0, 2.0, 0.0, 0.5]]
    combined = full.integrate(structure, law, excitation, [5.0], outputs=rows)
    single = full.integrate(structure, law, excitation, [5.0])
    np.testing.assert_allclose(combined.velocity, single.velocity @ np.transpose(rows), rtol=1e-13)


# Steady amplitudes and error estimates


def test_steady_amplitude_without_friction_is_the_frequency_response(structure):
    result = full.steady_amplitude(
        structure, rom.Coulomb(0.0), excitation_of(structure), tolerance=1e-7
    )
    for row, (dof, F, Omega, phase) in enumerate(((0, 0.15, 0.98, 0.3), (1, 0.25, 1.65, -1.0))):
        dynamic = structure.stiffness - Omega**2 * structure.mass + 1j * Omega * structure.damping
        exact = np.linalg.solve(dynamic, F * np.eye(4)[dof]) * np.exp(1j * phase) / 2
        difference = np.abs(result.amplitude[row] - exact)
        assert np.all(difference < 1e-6 * np.abs(exact).max())
        assert np.all(difference < result.error[row] + 1e-9)


def test_steady_amplitude_of_both_modes(structure):
    """Against amplitudes from a converged TR-BDF2 integration."""
    excitation = full.Excitation.harmonic(structure, FORCE, (0.9825, 1.654))
    result = full.steady_amplitude(structure, rom.Tanh(2.0, 0.02), excitation, outputs=(0, 1))
    assert abs(result.amplitude[0, 0]) == pytest.approx(3.1000, abs=2e-3)
    assert abs(result.amplitude[1, 1]) == pytest.approx(1.2541, abs=1e-3)
    assert result.error.max() < 1e-3
    again = full.steady_amplitude(
        structure, rom.Tanh(2.0, 0.02), excitation, outputs=(0, 1), start=result.end
    )
    assert np.all(np.abs(again.amplitude - result.amplitude) < 2 * (result.error + again.error))


def test_steady_amplitude_of_one_mode(structure):
    excitation = full.Excitation.harmonic(structure, ({0: 0.15}, {1: 0.0}), (0.9825, 1.65))
    result = full.steady_amplitude(structure, rom.Tanh(2.0, 0.02), excitation, outputs=(0, 1))
    assert abs(result.amplitude[0, 0]) == pytest.approx(3.1317, abs=1e-3)
    assert np.all(np.abs(result.amplitude[1]) < 1e-6)


def test_a_transient_that_does_not_settle_is_said(structure):
    with pytest.raises(rom.SlipmodeError, match="still changes after 2 windows"):
        full.steady_amplitude(
            structure, rom.Coulomb(0.0), excitation_of(structure), tolerance=1e-12, most_windows=2
        )


@pytest.mark.parametrize("law", [rom.Coulomb(0.5), rom.Tanh(0.5, 0.005)])
def test_converged_bounds_its_error(structure, law):
    times, excitation = np.linspace(0.0, 60.0, 301), excitation_of(structure)
    result = full.converged(structure, law, excitation, times, steps_per_period=30)
    exact = full.integrate(structure, law, excitation, times, steps_per_period=3000)
    motion = result.motion
    for name in ("displacement", "velocity", "contact_displacement", "contact_velocity"):
        error = relative_rms(getattr(motion, name), getattr(exact, name))
        assert np.all(error <= getattr(result, f"{name}_error")), name


@pytest.mark.parametrize("contacts", [2, 10, 30, 100])
def test_a_bar_is_the_more_one_contact_the_stiffer_it_is(contacts):
    """The contacts of a bar slip one after the other, or all together."""

    def displacement(contacts, joint):
        case = many_contacts(contacts, joint)
        excitation = full.Excitation.harmonic(case.structure, ({0: 0.6},), case.frequency)
        times = np.linspace(0.0, 30.0, 61)
        return full.integrate(
            case.structure, case.law, excitation, times, outputs=(0,), steps_per_period=64
        ).displacement

    single = displacement(1, 0.0)
    joints = (1.0, 25.0, 1e3, 1e4, 1e5)
    errors = [relative_rms(displacement(contacts, joint), single) for joint in joints]
    assert np.all(np.diff(errors, axis=0) < 0)
    # order 1 in the flexibility: measured 0.94 to 1.00
    assert np.log10(errors[-2] / errors[-1]).item() == pytest.approx(1.0, abs=0.1)


# Refusals


def test_refusals(structure):
    law, excitation = rom.Tanh(2.0, 0.02), excitation_of(structure)

    def refused(match, *arguments, **options):
        with pytest.raises(rom.SlipmodeError, match=match):
            full.integrate(*arguments, **options)

    refused("times: must be increasing", structure, law, excitation, [1.0, 1.0])
    refused("times: must be finite", structure, law, excitation, [])
    refused("times: must be finite", structure, law, excitation, np.nan)
    refused("times: must not lie before", structure, law, excitation, [-1.0, 1.0])
    refused("step: must be", structure, law, excitation, 1.0, step=0.0)
    refused("steps_per_period: must be", structure, law, excitation, 1.0, steps_per_period=np.inf)
    refused("outputs: DOFs", structure, law, excitation, 1.0, outputs=[4])
    refused("outputs: must be DOFs, or rows", structure, law, excitation, 1.0, outputs=[[1.0]])
    refused("excitation: patterns", chain(), law, excitation, 1.0)
    refused("limit", structure, rom.Tanh([1.0] * 3, 0.1), excitation, 1.0)
    short = full.State(0.0, np.zeros(3), np.zeros(4))
    refused("start.displacement", structure, law, excitation, 1.0, start=short)
    early = full.State(-1.0, np.zeros(4), np.zeros(4))
    refused("start: must not lie before", structure, law, excitation, 1.0, start=early)
    with pytest.raises(rom.SlipmodeError, match="frequency: must stay > 0"):
        full.Excitation.harmonic(structure, FORCE, (0.98, 0.0))
    with pytest.raises(rom.SlipmodeError, match="frequency: must be 2 numbers"):
        full.Excitation.harmonic(structure, FORCE, (0.98, 1.0, 2.0))
    with pytest.raises(rom.SlipmodeError, match="excitation: must be constant"):
        full.steady_amplitude(structure, law, scripted(structure))
