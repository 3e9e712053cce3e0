"""Several modes on each of two tones, beside time integration of all degrees of freedom."""

import numpy as np
import pytest
from oracles.system import System, Tone, jenkins
from oracles.time_integration import steady_harmonics

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


(SYSTEM, FORCES), MODES = square_plate(1, 0.03)
OMEGA, PATTERNS = [each.Omega for each in FORCES], [each.F.real for each in FORCES]


@pytest.mark.oracle
def test_one_force_leaves_the_states_of_one_tone():
    """The other tone is at rest; friction is odd, so that the phases turn with the forces."""
    both, alone = tabulated(SYSTEM, MODES), tabulated(SYSTEM, MODES[:3], (0, 0, 0))
    expected = rom.steady(alone, OMEGA[:1], PATTERNS[:1])
    a = rom.steady(both, OMEGA, [PATTERNS[0], 0.0 * PATTERNS[1]], (0.5, 0.0))
    assert np.abs(a[:3] * np.exp(-0.5j) - expected).max() < 5e-4 * np.abs(expected).max()
    assert np.abs(a[3:]).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: rom.steady(m, OMEGA[:1], PATTERNS), "last axis of length 2"),
        (lambda m: rom.steady(m, OMEGA, PATTERNS[:1]), "force: needs one entry"),
        (lambda m: rom.steady(m, [OMEGA[0]] * 2, PATTERNS), "is 1 times .* put all modes on tone"),
        (lambda m: rom.steady(m, [OMEGA[0], 1.0], PATTERNS), "mode B resonates at 2.5"),
        (lambda m: rom.tone_curve(m, PATTERNS[0], (1.7, 1.8)), "two tones.* use rom.steady"),
        (lambda m: rom.tone_flow(m, OMEGA[0], PATTERNS[0]), "two tones.* use rom.steady"),
        (lambda m: fmu.Component(m, PATTERNS), "two tones.* use rom.steady"),
        (
            lambda m: rom.response_curve(m, OMEGA, PATTERNS, "frequency_A", (1.7, 1.8)),
            "two tones.* use rom.steady",
        ),
    ],
)
def test_wrong_calls_are_refused(call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(tabulated(SYSTEM, MODES))
