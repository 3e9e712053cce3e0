"""Several modes on each of two tones, beside time integration of all degrees of freedom."""

import numpy as np
import pytest
from oracles.system import System, Tone, jenkins
from oracles.time_integration import integrate, steady_harmonics

from slipmode import fmu, rom

ZETA, LEVEL = 0.004, 2.5  # damping; frictionless motion of the contacts relative to the onset
TONES = (0, 0, 0, 1, 1)


def forced(rng, omega, W, shapes, modes, share, stuck):
    """A structure on its modes with open or stuck contacts, which slip under the forces."""
    k = rng.uniform(0.5, 1.5, W.shape[1])
    chosen = list(modes)
    k *= share / np.max(W[chosen] ** 2 @ k / omega[chosen] ** 2)
    K, C, one = np.diag(omega**2), np.diag(2.0 * ZETA * omega), np.eye(omega.size)
    K = K - (W * k) @ W.T if stuck else K
    near = rng.uniform(-0.3 * share, 0.0, 2)
    Omega = omega[[modes[0], modes[3]]] * (1.0 + near)
    tones = []
    for nu, f in zip(Omega, shapes, strict=True):
        moved = W.T @ np.linalg.solve(K + (W * k) @ W.T - nu**2 * one + 1j * nu * C, f)
        tones.append(Tone(float(nu), (f / np.abs(moved).max()).astype(complex)))
    limits = k / LEVEL * rng.uniform(0.6, 1.4, k.size)
    laws = [jenkins(*each) for each in zip(limits.tolist(), k.tolist(), strict=True)]
    return System(one, C, K, W, laws), tones


def square_plate(seed, share):
    """Modes (1, 4), (4, 1), (3, 3) and (3, 4), (4, 3) of a plate with dampers somewhere."""
    rng = np.random.default_rng([58, seed])
    m, n = (each.ravel() for each in np.meshgrid(np.arange(1, 7), np.arange(1, 7)))
    omega = 0.1 * (m**2 + ((1.0 + rng.uniform(0.003, 0.015)) * n) ** 2)
    order = np.argsort(omega)[:20]
    x, y = rng.uniform(0.1, 0.9, (2, int(rng.integers(1, 4)) + 2))
    shapes = np.sin(np.pi * np.outer(m[order], x)) * np.sin(np.pi * np.outer(n[order], y))
    modes = (8, 9, 10, 13, 14)
    return forced(rng, omega[order], shapes[:, 2:], shapes[:, :2].T, modes, share, False), modes


def drawn(seed, share):
    """Three modes within 6 %, two within 4 %, and four others, with random shapes."""
    rng = np.random.default_rng([57, seed])
    second = rng.uniform(1.3, 2.2)
    A = 1.0 + np.array([0.0, rng.uniform(0.0, 0.02), rng.uniform(0.02, 0.06)])
    B = second * np.array([1.0, 1.0 + rng.uniform(0.0, 0.04)])
    others = np.array([0.45, 2.6 * second / 2.0, 4.2, 6.1]) * rng.uniform(1.0, 1.1, 4)
    omega = np.sort(np.concatenate((A, B, others)))
    W = rng.standard_normal((9, int(rng.integers(1, 4)))) * np.minimum(omega, 1.0)[:, None] ** 2
    modes = (1, 2, 3, *np.flatnonzero(np.isin(omega, B)).tolist())
    return forced(rng, omega, W, rng.standard_normal((2, 9)), modes, share, True), modes


def tabulated(system, modes, tones=TONES, **options):
    laws = [rom.Sliders(each.limits, each.stiffnesses) for each in system.laws]
    law = rom.Contacts([(each, [contact]) for contact, each in enumerate(laws)])
    matrices = {"mass": system.M, "damping": system.C, "stiffness": system.K}
    structure = rom.Structure(**matrices, contact=system.W)
    reduced = rom.reduce(structure, modes, law=law, tones=tones, warned=False)
    return rom.tabulate(reduced, law, **options)


@pytest.mark.slow
@pytest.mark.oracle
@pytest.mark.parametrize(
    ("draw", "seed", "share"),
    [
        (square_plate, 1, 0.03),
        (drawn, 1, 0.03),
        (drawn, 4, 0.03),
        (drawn, 5, 0.1),
        (drawn, 3, 0.25),
    ],
)
def test_steady_states_beside_time_integration(draw, seed, share):
    """Within the default tolerance, 0.1 %."""
    (system, tones), modes = draw(seed, share)
    model = tabulated(system, modes)
    a = rom.steady(model, [each.Omega for each in tones], [each.F.real for each in tones])
    exact = steady_harmonics(system, tones, np.eye(2, dtype=int).tolist(), steps=512)
    rows = 0.5 * model.reduced.mode_shapes.T @ system.M
    expected, own = (rows @ exact.amplitude.T, np.abs(rows) @ exact.error.T)
    at = np.arange(5), TONES
    off, size = np.abs(a - expected[at]), np.abs(expected[at]).max()
    assert model.reduced.mode_names == ["A", "A2", "A3", "B", "B2"]
    assert np.all(off < 1e-3 * size + own[at])


@pytest.mark.slow
@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize(
    ("draw", "seed", "share"), [(square_plate, 1, 0.03), (drawn, 4, 0.03), (drawn, 3, 0.25)]
)
def test_motion_from_rest_beside_time_integration(draw, seed, share):
    """Modal coordinates within 0.5 %, and amplitudes at the end within 0.2 %."""
    (system, tones), modes = draw(seed, share)
    model, Omega = tabulated(system, modes), np.array([each.Omega for each in tones])
    patterns = np.array([each.F.real for each in tones])
    flow, end = rom.tone_flow(model, Omega, patterns), 100.0 * 2.0 * np.pi / Omega[0]
    flow.step(0.0, magnitude=(1.0, 1.0))
    exact = integrate(system, patterns.T, lambda t: np.cos(np.outer(t, Omega)), end, 51200, 61)
    found = []
    for t in exact.t:
        flow.step(t - flow.time)
        found.append(2.0 * np.real(np.exp(1j * flow.angle) @ flow.modal_amplitude()[:, :5]))
    expected = exact.x @ system.M @ model.reduced.mode_shapes
    assert np.linalg.norm(found - expected) < 0.006 * np.linalg.norm(expected)
    flow.step(4000.0)
    a = rom.steady(model, Omega, patterns)
    assert np.abs(flow.modal_amplitude()[TONES, range(5)] - a).max() < 0.004 * np.abs(a).max()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_sliders_of_very_different_limits():
    """The first of 72 slips at 3e-5 of the motion; runs end in the steady state."""
    (system, tones), modes = drawn(3, 0.25)
    (k,), (limit,) = system.laws[0].stiffnesses, system.laws[0].limits
    law = rom.Iwan(0.5 * limit, k, -0.5, 0.5)
    matrices = {"mass": system.M, "damping": system.C, "stiffness": system.K}
    structure = rom.Structure(**matrices, contact=system.W)
    model = rom.tabulate(rom.reduce(structure, modes, law=law, tones=TONES, warned=False), law)
    Omega, patterns = [each.Omega for each in tones], [each.F.real for each in tones]
    a, flow = rom.steady(model, Omega, patterns), rom.tone_flow(model, Omega, patterns)
    flow.step(0.0, magnitude=(1.0, 1.0))
    flow.step(4000.0)
    assert np.abs(flow.modal_amplitude()[TONES, range(5)] - a).max() < 0.004 * np.abs(a).max()


(SYSTEM, FORCES), MODES = square_plate(1, 0.03)
OMEGA, PATTERNS = [each.Omega for each in FORCES], [each.F.real for each in FORCES]


@pytest.fixture(scope="module")
def model():
    return tabulated(SYSTEM, MODES)


@pytest.mark.slow
def test_curves_are_steady_states():
    """The other frequency stays; displacements are at both."""
    model, span = tabulated(SYSTEM, MODES, tolerance=0.01), OMEGA[1] * np.array([0.998, 1.002])
    curve = rom.response_curve(model, OMEGA, PATTERNS, "frequency_B", span)
    assert np.all(curve.carrier[:, 0] == OMEGA[0])
    a = rom.steady(model, curve.carrier[5], PATTERNS)
    assert np.abs(curve.amplitude[5] - a).max() < curve.error[5].max()
    assert curve.displacement(0).shape == curve.carrier.shape


@pytest.mark.oracle
def test_one_force_leaves_the_states_of_one_tone(model):
    """The other tone is at rest; friction is odd, so that the phases turn with the forces."""
    both, alone = model, tabulated(SYSTEM, MODES[:3], (0, 0, 0))
    expected = rom.steady(alone, OMEGA[:1], PATTERNS[:1])
    a = rom.steady(both, OMEGA, [PATTERNS[0], 0.0 * PATTERNS[1]], (0.5, 0.0))
    assert np.abs(a[:3] * np.exp(-0.5j) - expected).max() < 5e-4 * np.abs(expected).max()
    assert np.abs(a[3:]).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.slow
@pytest.mark.oracle
def test_components_are_flows_whose_forces_do_the_work_of_friction_and_dampers(model):
    """With sweeps of both frequencies, and displacements at both carriers."""
    of = {"tolerance": model.tolerance, "contact": True, "elastic": (0, 3), "warned": False}
    made = fmu.Component(model, PATTERNS, **of)
    middle = np.array(model.middle)
    flow = rom.tone_flow(model, middle, PATTERNS)
    flow.step(0.0, magnitude=(1.0, 2.0), phase=(0.0, 0.4))
    flow.step(100.0, frequency=OMEGA)
    made.set_inputs(force_A=1.0, force_B=2.0, phase_B=0.4)
    rate_A, rate_B = (np.array(OMEGA) - middle) / 100.0
    made.set_inputs(frequency_rate_A=rate_A, frequency_rate_B=rate_B)
    made.do_step(0.0, 100.0)
    made.set_inputs(frequency_rate_A=0.0, frequency_rate_B=0.0)
    now, a = made.outputs(), flow.modal_amplitude()[TONES, range(5)]
    found = [now[f"{mode}_re"] + 1j * now[f"{mode}_im"] for mode in model.reduced.mode_names]
    assert np.abs(found - a).max() < 1e-9 * np.abs(a).max()
    turned = np.exp(1j * flow.angle) @ flow.displacement()
    assert now["x_3"] == pytest.approx(2.0 * turned[3].real, rel=1e-9)
    made.do_step(100.0, 4000.0)
    flow.step(4000.0)
    now, c = made.outputs(), 2.0 * flow.displacement()
    damped = 0.5 * np.sum(
        np.array(OMEGA) ** 2 * np.einsum("tn,nk,tk->t", c.conj(), SYSTEM.C, c).real
    )
    assert now["input_power"] == pytest.approx(damped + now["dissipated_power"], rel=2e-3)
    assert now["dissipated_power"] > 0.05 * damped


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: rom.steady(m, OMEGA[:1], PATTERNS), "last axis of length 2"),
        (lambda m: rom.steady(m, OMEGA, PATTERNS[:1]), "force: needs one entry"),
        (lambda m: rom.steady(m, [OMEGA[0]] * 2, PATTERNS), "is 1 times .* put all modes on tone"),
        (lambda m: rom.steady(m, [OMEGA[0], 1.0], PATTERNS), "mode B resonates at 2.5"),
        (lambda m: rom.tone_curve(m, PATTERNS[0], (1.7, 1.8)), "frequency: must be two numbers"),
        (lambda m: rom.tone_flow(m, OMEGA[0], PATTERNS[0]), "frequency: .* 2 tones, got 1"),
        (lambda m: rom.tone_flow(m, OMEGA, PATTERNS[0]), "force: "),
        (lambda m: fmu.Component(m, PATTERNS[:1]), "force_patterns: force: needs one entry"),
        (
            lambda m: rom.response_curve(m, OMEGA, PATTERNS, "force_B", (1.7, 1.8)),
            "vary = 'force_B': must be 'frequency_A' or 'frequency_B'",
        ),
    ],
)
def test_wrong_calls_are_refused(call, message, model):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(model)


def test_wrong_steps_are_refused(model):
    flow = rom.tone_flow(model, OMEGA, PATTERNS)
    for inputs, message in [
        ({"magnitude": 1.0}, "magnitude: must be two numbers"),
        ({"phase": (0.0, np.nan)}, "phase: must be a finite number, got nan"),
        ({"frequency": (OMEGA[0], 1.2 * OMEGA[1])}, "must be within 10 % of 2.4"),
    ]:
        with pytest.raises(rom.SlipmodeError, match=message):
            flow.step(1.0, **inputs)
