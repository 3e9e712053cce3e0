"""Steady states of two modes on rigid contacts, integrated from rest: drawn chains, full order."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.slow.direct.steady_harmonics import relative_error


def drawn_chain(seed):
    """Masses on springs, one to three of them on friction that slips now and then."""
    rng = np.random.default_rng(seed)
    n, contacts = int(rng.integers(5, 12)), int(rng.integers(1, 4))
    springs = rng.uniform(0.5, 2.0, n + 1) * n
    K = np.diag(springs[:-1] + springs[1:])
    K -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    structure = rom.Structure(
        np.diag(rng.uniform(0.5, 1.5, n)),
        K,
        rng.uniform(2e-3, 1e-2),
        contact=sorted(rng.choice(n, contacts, replace=False).tolist()),
    )
    natural = rom.reduce(structure)
    frequency = natural.frequency * (1.0 + rng.uniform(-0.01, 0.01, 2))
    force = rng.normal(size=(2, n))
    push = np.abs(np.einsum("jn,nj->j", force, natural.mode_shapes))
    stuck = push / (2.0 * natural.modal_damping * frequency)
    force[1] *= stuck[0] / stuck[1] * rng.uniform(0.2, 1.0)
    limit = 2.0 * np.abs(natural.spring[0]).max() * stuck[0] * rng.uniform(0.1, 0.6)
    moves = stuck[0] * frequency[0] * np.abs(natural.mode_shapes[:, 0]).max()
    return structure, rom.Tanh(limit, (0.1, 0.01)[seed % 2] * moves), frequency, force


@pytest.mark.parametrize(
    "seed", [2, 5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(8, 20))]
)
def test_the_stated_error_is_not_below_the_true_one(seed):
    structure, law, frequency, force = drawn_chain(seed)
    reduced = rom.reduce(structure, smallest_response=0.0).at_carrier(frequency.tolist())
    excitation = full.Excitation.harmonic(structure, force, frequency)
    rows = reduced.mode_shapes.T @ structure.mass
    try:
        exact = full.steady_amplitude(
            structure, law, excitation, outputs=rows, tolerance=2e-4, most_windows=30
        )
    except rom.SlipmodeError as reason:
        pytest.skip(f"full order: {reason}")
    expected, own = np.diagonal(exact.amplitude), np.diagonal(exact.error)
    for tolerance in (1e-2, 1e-3):
        state = rom.steady_state(reduced, law, frequency, force, tolerance)
        assert state.method == "integration"
        off = relative_error(reduced, state.amplitude - expected, expected)
        stated = relative_error(reduced, state.error, expected)
        assert stated <= tolerance
        assert off <= stated + relative_error(reduced, own, expected)


@pytest.mark.parametrize("apart", [0.01, 0.2])
def test_carriers_may_be_close_to_each_other(apart):
    """Two masses that are about alike, on a third that rubs: windows are as long as that takes."""
    K = np.array([[1.0, 0.0, -0.3], [0.0, 1.0 + 2.0 * apart, -0.25], [-0.3, -0.25, 2.0]])
    structure = rom.Structure(np.diag([1.0, 1.0, 0.1]), K, 0.01, contact=[2])
    law, force = rom.Tanh(0.5, 0.05), ({0: 0.03}, {1: 0.03})
    reduced = rom.reduce(structure, smallest_response=0.0)
    frequency = reduced.frequency * np.array([0.999, 1.001])
    state = rom.steady_state(reduced, law, frequency, force)
    excitation = full.Excitation.harmonic(structure, force, frequency)
    rows = reduced.mode_shapes.T @ structure.mass
    exact = full.steady_amplitude(structure, law, excitation, outputs=rows, tolerance=2e-4)
    off = np.abs(state.amplitude / np.diagonal(exact.amplitude) - 1.0)
    assert state.method == "integration"
    assert off.max() <= 5e-4
