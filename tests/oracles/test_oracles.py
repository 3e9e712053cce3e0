"""The oracles against closed forms, against SciPy's integrators, and against each other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from oracles.closed_forms import jenkins_dissipation, jenkins_first_harmonic
from oracles.harmonic_balance import balance, contact_forces, nonlinear_mode, to_complex
from oracles.system import Coulomb, Frictional, Sliders, System, Tanh, Tone, jenkins
from oracles.time_integration import NotSteadyError, integrate, steady_harmonics

pytestmark = pytest.mark.oracle
ONE = np.eye(1)


def chain(laws, contacts=((2, 1.0), (5, 1.0)), n=6, zeta=0.005):
    """A chain between two walls: system, natural frequencies with stuck contacts, shapes."""
    K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    W = np.zeros((n, len(contacts)))
    for column, (dof, size) in enumerate(contacts):
        W[dof, column] = size
    squares, shapes = np.linalg.eigh(System(np.eye(n), K, K, W, laws).stuck())
    omega = np.sqrt(squares)
    return System(np.eye(n), (shapes * 2 * zeta * omega) @ shapes.T, K, W, laws), omega, shapes


def at(dof, size, n=6):
    """A force on one DOF."""
    return size * np.eye(n, dtype=complex)[dof]


def test_stuck_contacts_leave_the_linear_response():
    system, omega, _ = chain([jenkins(1e3, 0.2), jenkins(1e3, 0.3)])
    tones = [Tone(0.98 * omega[0], at(0, 0.1)), Tone(1.01 * omega[1], at(3, 0.2j))]
    found = steady_harmonics(system, tones, [[1, 0], [0, 1]], steps=512)
    for tone, x, error in zip(tones, found.amplitude, found.error, strict=True):
        w = tone.Omega
        stuck = system.stuck() - w**2 * system.M + 1j * w * system.C
        assert np.all(np.abs(x - np.linalg.solve(stuck, tone.F)) <= error + 1e-12)
    assert found.error.max() < 5e-5 * np.abs(found.amplitude).max()


def test_sliding_mass_has_den_hartogs_amplitude():
    """x'' + x + limit sign(x') = cos(Omega t) without stops: Trans. ASME 53 (1931), APM-107."""
    system = System(ONE, 0 * ONE, ONE, ONE, [Coulomb(0.5)])
    periods, steps = 200, 512
    motion = integrate(
        *(system, ONE, lambda t: np.cos(0.8 * t)[:, np.newaxis]),
        *(2 * np.pi / 0.8 * periods, steps * periods),
    )
    peak = np.abs(motion.x[-steps:]).max()
    V, turn = 1.0 / (1.0 - 0.8**2), np.pi / 0.8
    U = np.sin(turn) / (0.8 * (1.0 + np.cos(turn)))
    assert peak == pytest.approx(np.sqrt(V**2 - (0.5 * U) ** 2), rel=1e-4)


@pytest.mark.parametrize("X", [0.5, 1.1, 2.0, 10.0])
def test_forces_of_a_jenkins_element_have_their_closed_form(X):
    limit, stiffness = 1.5, 1.5
    system = System(ONE, ONE, ONE, ONE, [jenkins(limit, stiffness)])
    c = np.zeros((1, 61))
    c[0, 1] = X
    first = to_complex(contact_forces(system, c)[0])[1, 0]
    assert first == pytest.approx(jenkins_first_harmonic(X, limit, stiffness), rel=1e-5)
    work = np.pi * X * first.imag
    assert work == pytest.approx(jenkins_dissipation(X, limit, stiffness), abs=2e-5 * X * limit)


@pytest.mark.parametrize(
    ("law", "force"),
    [
        (Tanh(0.5, 0.1), lambda x, v: 0.5 * np.tanh(v / 0.1)),
        (Frictional(0.0, 0.3, 1.0, 2.0), lambda x, v: max(0.0, 0.3 + 2.0 * x) - 0.3),
        (Frictional(0.0, 0.0, 1.0, 2.0, gap=0.4), lambda x, v: max(0.0, 2.0 * (x - 0.4))),
    ],
)
def test_laws_without_memory_agree_with_scipy_and_converge_with_order_2(law, force):
    # with friction: the tangential DOF is fixed to nothing that moves
    W = np.array([[0.0, 1.0]]) if isinstance(law, Frictional) else ONE
    system, t_end = System(ONE, 0.05 * ONE, ONE, W, [law]), 40.0
    exact = solve_ivp(
        lambda t, z: [z[1], np.cos(0.8 * t) - 0.05 * z[1] - z[0] - force(*z)],
        *((0.0, t_end), [0.0, 0.0]),
        **{"method": "DOP853", "rtol": 1e-11, "atol": 1e-12, "max_step": 0.01},
    ).y[0, -1]
    errors = []
    for steps in (500, 1000, 2000, 4000):
        motion = integrate(system, ONE, lambda t: np.cos(0.8 * t)[:, np.newaxis], t_end, steps)
        errors.append(abs(motion.x[-1, 0] - exact))
    assert errors[-1] < 2e-4
    order = np.log2(errors[0] / errors[-1]) / 3.0
    assert 1.7 < order < 2.6


def test_friction_under_a_constant_normal_force_is_a_jenkins_element():
    frictional, *_ = chain([Frictional(0.5, 0.2, 0.3, 1.0)], ((2, 1.0), (2, 0.0)))
    sliding, omega, _ = chain([jenkins(0.1, 0.3)], ((2, 1.0),))
    tones = [Tone(0.97 * omega[0], at(0, 0.05))]
    one = steady_harmonics(frictional, tones, [[1], [3]], steps=256)
    other = steady_harmonics(sliding, tones, [[1], [3]], steps=256)
    np.testing.assert_allclose(one.amplitude, other.amplitude, atol=1e-6)


@pytest.mark.parametrize(
    "laws",
    [
        [jenkins(0.03, 0.2), jenkins(0.05, 0.15)],
        [Sliders((0.01, 0.02, 0.05), (0.1, 0.1, 0.1)), jenkins(0.05, 0.15)],
    ],
)
def test_time_integration_and_harmonic_balance_agree_within_their_errors(laws):
    system, omega, _ = chain(laws)
    F, Omega = at(0, 0.02), 0.99 * omega[0]
    found = steady_harmonics(system, [Tone(Omega, F)], [[1], [3]])
    few, many = (balance(system, Omega, F, harmonics=H) for H in (9, 19))
    for row, h in enumerate((1, 3)):
        own = np.abs(many[h] - few[h])
        assert np.all(np.abs(many[h] - found.amplitude[row]) <= found.error[row] + own)
    size = np.abs(found.amplitude).max()
    assert found.error.max() < 1e-4 * size


def test_the_error_stated_from_two_steps_covers_a_run_of_four_times_as_many():
    system, omega, _ = chain([jenkins(0.05, 0.2), jenkins(0.08, 0.3)])
    tones = [Tone(0.99 * omega[0], at(0, 0.03)), Tone(1.01 * omega[1], at(3, 0.05))]
    orders = [[1, 0], [0, 1], [2, -1]]
    coarse, fine = (
        steady_harmonics(system, tones, orders, 1e-4, steps, most_periods=4000)
        for steps in (192, 768)
    )
    size = np.abs(fine.amplitude).max()
    bound = (coarse.error + fine.error).max(axis=1, keepdims=True) + 1e-5 * size
    assert np.all(np.abs(coarse.amplitude - fine.amplitude) <= bound)
    assert fine.error.max() < 3e-4 * size


def test_a_nonlinear_mode_is_the_motion_under_the_force_that_balances_its_damping():
    system, omega, shapes = chain([jenkins(0.03, 0.2), jenkins(0.05, 0.15)])
    stuck = nonlinear_mode(system, shapes[:, 0], 0.01)
    assert (stuck.omega, stuck.zeta) == pytest.approx((omega[0], 0.005))
    mode = nonlinear_mode(system, shapes[:, 0], 0.6)
    tones = [
        Tone(h * mode.omega, 2j * h * mode.zeta * mode.omega**2 * (system.M @ mode.X[h]))
        for h in (1, 3)
    ]
    forced = steady_harmonics(system, tones, [[1, 0], [0, 1]], steps=3 * 256)
    assert mode.omega < 0.99 * omega[0]
    assert mode.zeta > 0.02
    for row, h in enumerate((1, 3)):
        np.testing.assert_allclose(forced.amplitude[row], mode.X[h], atol=2e-4)


def test_a_motion_that_does_not_become_steady_is_reported():
    system, omega, _ = chain([jenkins(1e3, 0.2), jenkins(1e3, 0.3)], zeta=1e-5)
    with pytest.raises(NotSteadyError):
        steady_harmonics(system, [Tone(omega[0], at(0, 0.1))], [[1]], most_periods=100)
