"""Modes that harden or soften beside friction: closed forms, and full order in time."""

import numpy as np
import pytest
from beside_oracle import amplitudes, relative_rms, run
from scipy.integrate import solve_ivp

from slipmode import rom, runner
from slipmode.rom.reduction.nonlinear.stiffness import hardening

SIZE, END = 6, 5  # masses in a chain, the last one on a nonlinear spring
M = 0.5 * np.eye(SIZE)
K = np.diag([2e4, 2e4, 2.3e4, 2e4, 2e4, 1.05e4]) - 1e4 * (np.eye(SIZE, k=1) + np.eye(SIZE, k=-1))
C, W = 2e-4 * K, np.eye(SIZE)[:, [1, 4]]
LIMIT, SPRING = 0.3, 600.0
LAW = rom.Jenkins(LIMIT, SPRING)
STRUCTURE = rom.Structure(M, K, C, contact=W)
RANGE = np.array([2.5e-3, 2.5e-3])  # of amplitudes [kg^1/2 m]


def reduced(modes, cubic):
    """Return the chain reduced to modes, with the coefficients of a cubic spring at its end."""
    made = rom.reduce(STRUCTURE, modes, law=LAW)
    end = dict(zip("AB", made.mode_shapes[END], strict=False))
    names = ["AAAA", "AAAB", "AABB", "ABBB", "BBBB"][: 1 if len(end) == 1 else 5]
    return rom.with_nonlinear_stiffness(
        made, {name: cubic * np.prod([end[letter] for letter in name]) for name in names}
    )


def march(x, force, h, steps, nonlinear):
    """Return displacements (steps, n) from x at rest, by central differences."""
    slider = np.clip(0.0, *(W.T @ x + np.array([[-1.0], [1.0]]) * LIMIT / SPRING))
    inverse, back = np.linalg.inv(M / h**2 + C / (2 * h)), M / h**2 - C / (2 * h)
    found, before = np.empty((steps, SIZE)), None
    for k in range(steps):
        found[k], c = x, W.T @ x
        slider = np.clip(slider, c - LIMIT / SPRING, c + LIMIT / SPRING)
        f = force(k * h) - K @ x - SPRING * W @ (c - slider) - nonlinear(x)
        if before is None:
            before = x + 0.5 * h**2 * np.linalg.solve(M, f)
        x, before = inverse @ (f + 2.0 * M @ x / h**2 - back @ before), x
    return found


def along_modes(reduced):
    """Return the forces of the potential on all DOFs."""
    along, cubic = M @ reduced.mode_shapes, reduced.cubic
    return lambda x: along @ (cubic @ (x @ along) @ (x @ along) @ (x @ along))


def carriers(reduced, y, t, omega):
    """Return the amplitudes a_j at the frequencies omega of a steady motion y (samples, n)."""
    lines = np.exp(1j * np.outer(t, np.concatenate([k * omega for k in (1, -1, 3, -3)])))
    found = np.linalg.lstsq(lines, (y @ M @ reduced.mode_shapes).astype(complex), rcond=None)[0]
    return np.diagonal(found[: omega.size])


def period(alpha, gamma, top):
    """Return frequency and first harmonic |a| of q'' + q + alpha q^2 + gamma q^3 from q = top."""
    V = np.polynomial.Polynomial([0.0, 0.0, 0.5, alpha / 3.0, gamma / 4.0])
    roots = (V - V(top)).roots()
    bottom = max(r.real for r in roots if abs(r.imag) < 1e-9 and r.real < 0.0)
    u = (np.arange(2000) + 0.5) * np.pi / 2000
    q = 0.5 * (top + bottom) + 0.5 * (top - bottom) * np.cos(u)
    dt = 0.5 * (top - bottom) * np.sin(u) / np.sqrt(2.0 * (V(top) - V(q))) * np.pi / 2000
    omega, t = np.pi / dt.sum(), np.cumsum(dt) - 0.5 * dt
    return omega, float(np.sum(q * np.cos(omega * t) * dt)) * omega / np.pi


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("alpha", "gamma", "top", "error"),
    [(0.0, 1.0, 0.6, 1.2e-3), (0.0, -1.0, 0.5, 1.3e-3), (1.0, 2.0, 0.24, 7e-3)],  # 1.0, 1.1, 6.8
)
def test_backbones_of_stuck_contacts_have_the_frequency_of_a_closed_form(alpha, gamma, top, error):
    made = rom.reduce(rom.two_mass(beta=1e-6), (0,))  # 1 rad/s
    made = rom.with_nonlinear_stiffness(made, {"AAA": alpha, "AAAA": gamma})
    omega, a = period(alpha, gamma, top)
    model = rom.tabulate(made, rom.Coulomb(100.0), (1.01 * a,), warned=False)
    assert rom.backbone(model, amplitude=[a]).frequency == pytest.approx([omega], rel=error)
    assert abs(omega - 1.0) > 0.015


@pytest.mark.oracle
@pytest.mark.parametrize(
    "coefficients",
    [
        {"ABB": 0.5},
        {"AAA": 0.3, "AAB": 0.2, "BBB": 0.4, "AABB": 0.4},
        pytest.param({"AAB": 0.4}, marks=pytest.mark.slow),
    ],
)
def test_quadratic_terms_of_two_modes_shift_both_frequencies(coefficients):
    """Beside integrated free vibrations of both, whose phases give the frequencies."""
    made = rom.with_nonlinear_stiffness(rom.reduce(rom.two_mass()), coefficients)
    omega, alpha, gamma = made.frequency, made.quadratic, made.cubic

    def slope(_, y):
        q = y[:2]
        return np.append(y[2:], -(omega**2) * q - alpha @ q @ q - gamma @ q @ q @ q)

    t, half = np.arange(0.0, 1000.0, 0.2), 2500
    start = np.array([0.04, 0.032, 0.0, 0.0])
    q = solve_ivp(slope, t[[0, -1]], start, "DOP853", t, rtol=1e-9, atol=1e-12)
    turning = q.y[:2] * np.exp(-1j * np.outer(omega, t))
    first, last = (part @ np.hanning(half) for part in (turning[:, :half], turning[:, -half:]))
    exact = np.angle(last / first) / t[half]
    a = np.abs(first) / np.hanning(half).sum()
    found = np.sqrt(omega**2 + hardening(made) @ a**2) - omega
    np.testing.assert_allclose(found, exact, atol=0.03 * np.abs(exact).max())


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("cubic", "detuning", "local", "error"),
    [  # 0.52 (other modes follow), 0.67 %
        (5e7, 0.99, True, 8e-3),
        pytest.param(2e8, 0.98, False, 0.01, marks=pytest.mark.slow),
    ],
)
def test_steady_states_harden_beside_friction_as_in_full_order(cubic, detuning, local, error):
    made = reduced((0,), cubic)
    omega, force = detuning * made.frequency, 0.65 * np.eye(SIZE)[2]
    model = rom.tabulate(made, LAW, (RANGE[0],), tolerance=1e-3)
    found = rom.steady(model, omega, [force])
    h = 2.0 * np.pi / omega[0] / 200
    spring = (lambda x: cubic * x[END] ** 3 * np.eye(SIZE)[END]) if local else along_modes(made)
    y = march(np.zeros(SIZE), lambda t: force * np.cos(omega[0] * t), h, 24000, spring)
    exact = carriers(made, y[-4000:], h * np.arange(20000, 24000), omega)
    assert found == pytest.approx(exact, rel=error)
    linear = rom.tabulate(reduced((0,), 0.0), LAW, (RANGE[0],))
    assert abs(rom.steady(linear, omega, [force]) / found - 1.0) > 0.1
    ends = (0.99 * omega[0], 1.01 * omega[0])
    a, stable = rom.response_curve(model, omega, [force], "frequency_A", ends).at(omega[0])
    assert a[stable, 0] == pytest.approx(found, rel=1e-3)


@pytest.mark.slow
@pytest.mark.oracle
def test_two_modes_harden_each_other_as_in_full_order():
    made = reduced((0, 1), 1e8)
    a = RANGE * [0.4, 0.25]
    model = rom.tabulate(made, LAW, 1.6 * a, tolerance=0.01)
    mode = [rom.backbone(model, j, a[1 - j], amplitude=[a[j]]) for j in (0, 1)]
    omega = 0.98 * np.array([each.frequency[0] for each in mode])
    size = a * [4.0 * each.damping[0] * each.frequency[0] ** 2 for each in mode]
    forces = np.diag(size / np.diag(made.mode_shapes[[2, 1]])) @ np.eye(SIZE)[[2, 1]]
    found = rom.steady(model, omega, list(forces))
    h = 2.0 * np.pi / omega[1] / 100
    y = march(np.zeros(SIZE), lambda t: np.cos(omega * t) @ forces, h, 30000, along_modes(made))
    exact = carriers(made, y[-10000:], h * np.arange(20000, 30000), omega)
    assert found[0] == pytest.approx(exact[0], rel=0.025)  # 2.0 %, without coefficients 1.1 %
    assert found[1] == pytest.approx(exact[1], rel=0.01)  # 0.6 %


@pytest.mark.oracle
def test_a_decay_has_the_frequency_and_damping_of_full_order(tmp_path):
    made = reduced((0,), 3e7)
    model = rom.tabulate(made, LAW, (RANGE[0],), tolerance=1e-3)
    model.save(tmp_path / "model.npz")
    model = rom.Model.load(tmp_path / "model.npz")
    a, h = 0.9 * RANGE[0], 2.0 * np.pi / made.frequency[0] / 200
    y = march(2.0 * a * made.mode_shapes[:, 0], lambda t: 0.0, h, 8000, along_modes(made))
    t = h * np.arange(1, 8000)
    decay = run(model, [np.eye(SIZE)[2]], t, start=a, frequency_A=made.frequency[0])
    q = 2.0 * (amplitudes(decay)[:, 0] * np.exp(1j * decay["theta_A"])).real
    exact = (y @ M @ made.mode_shapes[:, 0])[1:]
    assert relative_rms(q, exact) < 0.02  # 1.8 %


SCENE = """
structure.model = "two-mass"
friction = { law = "coulomb", limit = 2.0 }
modes = { A = 0, B = 1 }
forcing.A = { dof = 0, amplitude = 0.15, frequency = 1.03 }
forcing.B = { dof = 1, amplitude = 0.25, frequency = 1.7 }
nonlinear_stiffness = { AAAA = 0.004, AABB = 0.02, BBBB = 0.01 }
run = { duration = 300, step = 3 }
model = { amplitude = [4.0, 1.5], tolerance = 0.01 }
"""


def test_a_scene_and_its_fmu_harden_alike(tmp_path):
    scene = runner.parse_scene(SCENE, ".")
    path = runner.export_fmu(scene, tmp_path / "hard.fmu", headroom=1.0)
    made = [
        runner.run(scene, tmp_path / "out", **options).read().channels["/modes"]
        for options in ({}, {"fmu": path})
    ]
    np.testing.assert_array_equal(made[0][2], made[1][2])
    plan = runner.make_plan(scene)
    np.testing.assert_allclose(hardening(plan.excited.reduced), [[0.012, 0.12], [0.12, 0.03]])
    B = SCENE.replace("amplitude = 0.15", "amplitude = 0.0")
    alone = runner.make_plan(runner.parse_scene(B, "."))
    np.testing.assert_allclose(hardening(alone.excited.reduced), [[0.03]])


@pytest.mark.oracle
@pytest.mark.parametrize("enforced", [True, False])
def test_coefficients_of_static_cases_are_those_of_the_spring(enforced):
    """Under forces the other modes follow the spring: implicit condensation."""
    made = reduced((0, 1), 1e8)
    c = np.random.default_rng(1).uniform(-1e-4, 1e-4, (24, 2))
    stuck, spring = K + SPRING * W @ W.T, 1e8 * np.eye(SIZE)[END]
    u = c @ made.mode_shapes.T
    forces = u @ stuck + u[:, [END]] ** 3 * spring
    if not enforced:
        forces = c * made.frequency**2 @ made.mode_shapes.T @ M
        for _ in range(20):
            u = np.linalg.solve(stuck, (forces - u[:, [END]] ** 3 * spring).T).T
    found = rom.with_nonlinear_stiffness(made, rom.fit_nonlinear_stiffness(made, u, forces))
    error = 1e-6 if enforced else 0.02
    np.testing.assert_allclose(found.cubic, made.cubic, rtol=error)
    np.testing.assert_allclose(hardening(found), hardening(made), rtol=error)
    with pytest.raises(rom.SlipmodeError, match="3 load cases do not determine the 9 coeff"):
        rom.fit_nonlinear_stiffness(made, u[:3], forces[:3])


def test_what_is_not_modelled_is_refused():
    two = rom.reduce(rom.two_mass())
    for coefficients, message in (
        ({"AAAB": 1.0, "AABA": 2.0}, "AABA = 2: other orders of these letters have 1"),
        ({"AAC": 1.0}, "AAC: must be three or four of the letters A, B"),
        ({"AAAA": np.nan}, "AAAA: must be 0 or 1e-30"),
    ):
        with pytest.raises(rom.SlipmodeError, match=message):
            rom.with_nonlinear_stiffness(two, coefficients)
    three = rom.Structure(np.eye(3), np.diag([1.0, 9.3, 20.0]), contact=(2,))
    with pytest.raises(rom.SlipmodeError, match=r"3 omega_A is 1.6 % from omega_B"):
        made = rom.with_nonlinear_stiffness(rom.reduce(three), {"AAAB": 1.0})
        rom.tabulate(made, rom.Coulomb(2.0), (1.0, 1.0), warned=False)
    soft = rom.with_nonlinear_stiffness(rom.reduce(rom.two_mass(), (0,)), {"AAAA": -0.02})
    with pytest.raises(rom.SlipmodeError, match="soften mode A to instability within the range"):
        rom.tabulate(soft, rom.Coulomb(2.0), (4.0,))
    with pytest.raises(rom.SlipmodeError, match=r"rom.steady_state does not include it"):
        rom.steady_state(soft, rom.Coulomb(2.0), [1.0], [{0: 1.0}])
