"""Full order on component modes: what they keep, and that the stated error is never too small."""

import numpy as np
import pytest
import scipy.sparse
from beside_oracle import relative_rms

from slipmode import rom
from slipmode.rom import full

N, CONTACTS, FORCED = 140, 3, 70
LAWS = {"elastic": rom.Jenkins(limit=0.15, stiffness=2.0), "rigid": rom.Coulomb(limit=0.02)}


def body(seed):
    """Masses in a row, springs between neighbours and some others, held at one end; sparse."""
    rng = np.random.default_rng(seed)
    pairs = [(k, k + 1) for k in range(N - 1)]
    pairs += [tuple(pair) for pair in rng.integers(0, N, (N // 3, 2)) if abs(np.diff(pair)) > 1]
    K = np.zeros((N, N))
    for i, j in pairs:
        spring = rng.uniform(20.0, 80.0) if abs(i - j) == 1 else rng.uniform(0.0, 0.05)
        K[[i, j], [i, j]] += spring
        K[[i, j], [j, i]] -= spring
    K[0, 0] += 50.0
    M = scipy.sparse.diags_array(rng.uniform(0.05, 0.15, N))
    contact = np.sort(rng.choice(np.arange(20, N), CONTACTS, replace=False))
    return rom.Structure(M, scipy.sparse.csr_array(K), 2e-2, contact=tuple(contact.tolist()))


def reduced(structure, law):
    return rom.reduce(structure, (0, 1), law=law if isinstance(law, rom.Jenkins) else None)


def excited(structure, law):
    """Both modes near resonance, under one point force each."""
    frequency = reduced(structure, law).frequency * (0.97, 0.98)
    force = ({N - 1: 0.05}, {FORCED: 0.1})
    return full.Excitation.harmonic(structure, force, frequency, phase=-0.5 * np.pi)


def receptance(K, M, loads, nu):
    return loads.T @ np.linalg.solve(K - nu**2 * M, loads)


def dense_held(structure, law):
    """K and M of the structure with stuck contacts, and the loads."""
    K, M = structure.stiffness.toarray(), structure.mass.toarray()
    W = structure.directions.toarray()
    force = np.eye(N)[:, [N - 1, FORCED]]
    return K + law.stiffness * W @ W.T, M, np.hstack((W, force))


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("modes", [2, 12])
def test_the_receptance_is_within_its_bound(seed, modes):
    """Against the body itself, with stuck contacts, up to the highest frequency and at it."""
    structure, law = body(seed), LAWS["elastic"]
    omega = reduced(structure, law).frequency
    K, M, loads = dense_held(structure, law)
    patterns = [{N - 1: 1.0}, {FORCED: 1.0}]
    probe = full.component_modes(structure, law, patterns, omega[0], modes=modes + 1)
    highest = 0.9 * probe.frequency[-1]
    small = full.component_modes(structure, law, patterns, highest, modes=modes)
    assert small.structure.n_dofs == modes + CONTACTS + 2
    basis = small.projection.basis
    scale = np.sqrt(np.diag(receptance(K, M, loads, 0.0)))
    worst = 0.0
    for nu in highest * np.array([0.0, 0.3, 0.7, 0.9, 1.0]):
        exact = receptance(K, M, loads, nu)
        found = receptance(basis.T @ K @ basis, basis.T @ M @ basis, basis.T @ loads, nu)
        error = np.abs((found - exact) / np.outer(scale, scale)).max()
        assert nu > 0.0 or error < 1e-8  # static answers are exact
        worst = max(worst, error)
    # a bound, and no idle one
    assert worst <= small.receptance_error
    assert worst > 0.1 * small.receptance_error


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", LAWS)
def test_half_as_many_modes_state_the_error_of_the_motion(seed, name):
    """Never below that against the body itself."""
    structure, law = body(seed), LAWS[name]
    excitation = excited(structure, law)
    times = np.linspace(0.5, 80.0, 160)

    highest = 3 * excitation.fastest(80.0)
    default = full.component_modes(structure, law, excitation.patterns, highest)
    assert default.receptance_error <= 1e-3
    assert default.frequency.size < N // 2

    def moved(modes):
        small = full.component_modes(
            structure, law, excitation.patterns, highest, modes=modes
        ).projection
        return full.integrate(
            *(small.structure, law, small.excitation(excitation), times),
            outputs=small.basis[[N - 1, FORCED]],
        )

    exact = full.integrate(structure, law, excitation, times, outputs=[N - 1, FORCED])
    slips = np.ptp(exact.contact_force, axis=0).max()
    assert slips == pytest.approx(2 * (0.15 if name == "elastic" else 0.02), rel=1e-6)
    found, rough = moved(default.frequency.size), moved(default.frequency.size // 2)
    for signal in ("displacement", "contact_displacement"):
        true = relative_rms(getattr(found, signal), getattr(exact, signal)).max()
        stated = relative_rms(getattr(rough, signal), getattr(found, signal)).max()
        assert true <= stated, signal
        assert true < 5e-3, signal
