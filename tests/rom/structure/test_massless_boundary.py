"""A massless-boundary model: the squeak test rig of NLstep, example 05, with two nodes in contact.

The oracle integrates five modes exactly under loads that are linear in each step, with the balance
of forces of the six boundary DOFs, K_bb b + K_bi q + f(b) = F_b, at its end.
"""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from slipmode import rom

DATA = Path(__file__).parents[4] / "shared/data/published/nlstep_squeak_rom.npz"
MU, PRELOAD, STIFFNESS, ZETA = 0.36, 6.8, 200.0, 0.01  # [-], [N], [N/mm], [-]
DIRECTIONS = np.eye(6)[:, [1, 2, 0, 4, 5, 3]] * [1, 1, -1, 1, 1, -1]  # normals open in the model


def contact_force(c, slider):
    """Forces (6,), their derivative and sliders of contact displacements c: t, t, normal twice."""
    f, J, moved = np.zeros(6), np.zeros((6, 6)), c.reshape(2, 3)[:, :2].copy()
    for i in range(2):
        t, n = slice(3 * i, 3 * i + 2), 3 * i + 2
        normal = max(0.0, PRELOAD + STIFFNESS * c[n])
        f[n] = normal - PRELOAD
        J[n, n] = STIFFNESS * (normal > 0.0)
        f[t] = STIFFNESS * (c[t] - slider[i])
        J[t, t] = STIFFNESS * np.eye(2)
        size, limit = np.hypot(*f[t]), MU * normal
        if size > limit:
            along = f[t] / size
            f[t] = limit * along
            J[t, t] = limit / size * STIFFNESS * (np.eye(2) - np.outer(along, along))
            J[t, n] = MU * J[n, n] * along
        moved[i] = c[t] - f[t] / STIFFNESS
    return f, J, moved


def integrated(K, F, Omega, periods, steps):
    """First harmonic (11,) in the last period of the motion from rest."""
    h, omega2 = 2.0 * np.pi / Omega / steps, np.diag(K)[6:]
    A = np.zeros((20, 20))
    A[:5, 5:10] = A[5:10, 10:15] = h * np.eye(5)
    A[5:10, :5], A[5:10, 5:10] = -h * np.diag(omega2), -2.0 * h * ZETA * np.diag(np.sqrt(omega2))
    A[10:15, 15:] = np.eye(5)
    exact = scipy.linalg.expm(A)[:10]
    after = exact[:, 15:]
    before = exact[:, 10:15] - after
    K_bi = DIRECTIONS.T @ K[:6, 6:]
    S = DIRECTIONS.T @ K[:6, :6] @ DIRECTIONS - K_bi @ after[:5] @ K_bi.T
    state, c, slider, load, first = np.zeros(10), np.zeros(6), np.zeros((2, 2)), np.zeros(5), 0.0
    for k in range(1, periods * steps + 1):
        phase = Omega * h * k
        force = F * np.cos(phase) * np.sin(0.25 * min(phase, 2.0 * np.pi)) ** 2
        free = exact[:, :10] @ state + before @ load + after @ force[6:]
        right = DIRECTIONS.T @ force[:6] - K_bi @ free[:5]
        while True:
            f, J, moved = contact_force(c, slider)
            missing = S @ c + f - right
            if np.abs(missing).max() < 1e-10:
                break
            c = c - np.linalg.solve(S + J, missing)
        slider, load, state = moved, force[6:] - K_bi.T @ c, free - after @ (K_bi.T @ c)
        if k > (periods - 1) * steps:
            first = first + np.exp(-1j * phase) * np.append(DIRECTIONS @ c, state[:5])
    return 2.0 * first / steps


@pytest.mark.oracle
@pytest.mark.skipif(not DATA.exists(), reason="the model of NLstep is not beside the repository")
@pytest.mark.filterwarnings("ignore:frequency is far from mode")
@pytest.mark.parametrize(  # of the test, far below the modes; resonance
    "hertz", [7.0, pytest.param(180.0, marks=pytest.mark.slow)]
)
def test_the_squeak_rig(hertz):
    factor, periods, steps = {7.0: (7.8, 4, 2000), 180.0: (3.0, 40, 200)}[hertz]
    given, Omega = np.load(DATA), 2.0 * np.pi * hertz
    K, F = 0.5 * (given["K"] + given["K"].T), factor * given["k_11x1"]
    C = np.diag(np.append(np.zeros(6), 2.0 * ZETA * np.sqrt(np.diag(K)[6:])))
    W = np.vstack((DIRECTIONS, np.zeros((5, 6))))
    law = rom.FrictionalContact(MU, PRELOAD, STIFFNESS, STIFFNESS, tangents=2)
    reduced = rom.reduce(rom.Structure(given["M"], K, C, contact=W), (0,), law=law)
    x = 2.0 * rom.steady_state(reduced, law, [Omega], [F]).displacement_harmonics()[0]
    expected = integrated(K, F, Omega, periods, steps)
    np.testing.assert_allclose(x, expected, atol=1e-3 * np.abs(expected).max())  # 3e-4
