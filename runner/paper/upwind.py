"""The paper's scheme (31) on the torus, taken literally: upwind, from zero, a few periods."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import Reduced, Tanh
from slipmode.rom.arrays import Complexes, Floats

_NEWTON_PASSES = 60
_HALVINGS = 30
_CONVERGED = 1e-9  # of the friction limit


def friction_functions(
    reduced: Reduced, law: Tanh, amplitudes: ArrayLike, steps: int, periods: int = 2
) -> Complexes:
    """Q_A, Q_B (points, 2) from the last of several periods in each direction of the torus.

    Parameters
    ----------
    reduced : Reduced
        In the paper's formulation.
    law : Tanh
        With one friction limit.
    amplitudes : (points, 2) array_like
        |A|, |B| [kg^1/2 m], > 0.
    steps : int
        Per period, in both directions.
    """
    moduli = np.asarray(amplitudes, dtype=float)
    x = _march(reduced, law, moduli, steps, periods)
    last = np.arange(steps * (periods - 1) + 1, steps * periods + 1)
    weight = np.exp(-2j * np.pi * last / steps) / steps**2
    window = x[np.ix_(last, last)]
    L = reduced.spring
    P_10 = np.einsum("n,nmpc->pc", weight, window)
    P_01 = np.einsum("m,nmpc->pc", weight, window)
    Q: Complexes = -np.stack((P_10 @ L[0], P_01 @ L[1]), axis=-1) / moduli
    return Q


def _march(reduced: Reduced, law: Tanh, moduli: Floats, steps: int, periods: int) -> Floats:
    """x_nm (N + 1, N + 1, points, 2), zero where n = 0 or m = 0; a diagonal n + m at a time."""
    count, dt = steps * periods, 2 * np.pi / steps
    omega, K, L = reduced.frequency, reduced.stiffness, reduced.spring
    rate = omega.sum() / dt
    x = np.zeros((count + 1, count + 1, *moduli.shape))
    for diagonal in range(2, 2 * count + 1):
        n = np.arange(max(1, diagonal - count), min(count, diagonal - 1) + 1)
        m = diagonal - n
        before = (omega[0] * x[n - 1, m] + omega[1] * x[n, m - 1]) / dt
        cosines = np.cos(dt * np.stack((n, m), axis=-1))[:, np.newaxis]
        force = -(2 * cosines * moduli) @ L - before @ K / rate
        x[n, m] = (_velocity(K / rate, law, force) + before) / rate
    return x


def _velocity(S: Floats, law: Tanh, force: Floats) -> Floats:
    """Solve S v + g(v) = force: Newton on its convex potential, the step halved if it rises."""
    alpha, limit = law.alpha, float(np.max(law.limit))

    def potential(v: Floats) -> Floats:
        smooth = limit * alpha * np.logaddexp(v / alpha, -v / alpha)
        return np.asarray(np.sum(0.5 * v * (v @ S) + smooth - force * v, axis=-1))

    v = np.zeros_like(force)
    height = potential(v)
    for _ in range(_NEWTON_PASSES):
        slip = np.tanh(v / alpha)
        residual = v @ S + limit * slip - force
        if np.abs(residual).max() <= _CONVERGED * limit:
            break
        hessian = S + (limit / alpha * (1 - slip**2))[..., np.newaxis] * np.eye(2)
        step = -np.linalg.solve(hessian, residual[..., np.newaxis])[..., 0]
        for _ in range(_HALVINGS):
            rising = potential(v + step) > height + 1e-13
            if not rising.any():
                break
            step[rising] *= 0.5
        v = v + step
        height = potential(v)
    return v
