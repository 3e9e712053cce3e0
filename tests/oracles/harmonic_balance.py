"""Harmonic balance of slider contacts under one tone, by alternating frequency and time.

x = Re(sum_h X_h exp(i h Omega t)), h = 0 .. H. Unknowns are the contact displacements' harmonics;
Newton's method has the exact derivative of the sliders' motion. More harmonics state the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from oracles.system import Law, Sliders, System

HARMONICS, PER_HARMONIC = 15, 32  # samples per period of the last harmonic
MOST_STEPS, RESIDUAL = 60, 1e-9


class NotBalancedError(Exception):
    """Newton's method did not converge."""


@dataclass(frozen=True)
class Balance:
    """Displacement harmonics (H + 1, n), the residual relative to the force, and the unknowns."""

    X: np.ndarray
    contact: np.ndarray
    residual: float


@dataclass(frozen=True)
class NonlinearMode:
    """Damped nonlinear mode: frequency [rad/s], damping ratio [-], harmonics (H + 1, n)."""

    omega: float
    zeta: float
    X: np.ndarray
    residual: float


def _basis(H: int) -> tuple[np.ndarray, np.ndarray]:
    """Return samples of unknowns (samples, 2 H + 1) and their projection back."""
    samples = PER_HARMONIC * H
    theta = 2.0 * np.pi * np.arange(samples) / samples
    h = np.arange(1, H + 1)
    angles = np.outer(theta, h)
    basis = np.hstack((np.ones((samples, 1)), np.cos(angles), -np.sin(angles)))
    back = 2.0 * basis.T / samples
    back[0] *= 0.5
    return basis, back


def _padded(laws: Sequence[Law]) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffnesses and reaches limit / stiffness (contacts, most sliders)."""
    assert all(isinstance(law, Sliders) for law in laws)
    most = max(len(law.limits) for law in laws)
    k, reach = np.zeros((len(laws), most)), np.full((len(laws), most), np.inf)
    for i, law in enumerate(laws):
        k[i, : len(law.limits)] = law.stiffnesses
        reach[i, : len(law.limits)] = np.divide(law.limits, law.stiffnesses)
    return k, reach


def contact_forces(system: System, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force unknowns (contacts, 2 H + 1) of displacement unknowns, and derivatives.

    The sliders march over two periods from rest; the second one counts.
    """
    basis, back = _basis(c.shape[1] // 2)
    k, reach = _padded(system.laws)
    x = basis @ c.T
    low, high = x[:, :, np.newaxis] - reach, x[:, :, np.newaxis] + reach
    s, ds = np.zeros_like(k), np.zeros((*k.shape, c.shape[1]))
    force, slope = np.empty_like(x), np.empty((len(x), *c.shape))
    for _ in range(2):
        for i, row in enumerate(basis):
            moved = np.clip(s, low[i], high[i])
            slips = moved != s
            if slips.any():
                ds[slips] = row
            s = moved
            force[i] = (k * (x[i][:, np.newaxis] - s)).sum(axis=1)
            slope[i] = np.einsum("cs,csu->cu", k, row - ds)
    return (back @ force).T, np.einsum("us,scv->cuv", back, slope)


def to_complex(c: np.ndarray) -> np.ndarray:
    """Return harmonics (H + 1, contacts) of unknowns (contacts, 2 H + 1)."""
    H = c.shape[1] // 2
    return np.vstack((c[:, :1].T, (c[:, 1 : H + 1] + 1j * c[:, H + 1 :]).T)).astype(complex)


def to_unknowns(C: np.ndarray) -> np.ndarray:
    """Return unknowns (contacts, 2 H + 1) of harmonics (H + 1, contacts)."""
    return np.hstack((C[:1].T.real, C[1:].T.real, C[1:].T.imag))


def _flexibility(system: System, omega: float, H: int) -> list[np.ndarray]:
    """Inverse dynamic stiffnesses of stuck contacts."""
    stuck = System(system.M, system.C, system.stuck(), system.W, system.laws)
    return [np.linalg.inv(stuck.dynamic_stiffness(h * omega)) for h in range(H + 1)]


def _compliance(G: np.ndarray, W: np.ndarray) -> np.ndarray:
    """Contact response (contacts, m, contacts, m) to contact forces, as unknowns."""
    H, N = len(G) - 1, W.shape[1]
    found = np.zeros((N, 2 * H + 1, N, 2 * H + 1))
    for h in range(H + 1):
        g = W.T @ G[h] @ W
        found[:, h, :, h] = g.real
        if h:
            found[:, H + h, :, H + h] = g.real
            found[:, h, :, H + h] = -g.imag
            found[:, H + h, :, h] = g.imag
    return found


def balance(
    system: System,
    Omega: float,
    F: np.ndarray,
    start: np.ndarray | None = None,
    harmonics: int = HARMONICS,
) -> Balance:
    """Solve for the periodic motion under Re(F exp(i Omega t)). Raises NotBalancedError."""
    W, k = system.W, system.stuck_stiffness()
    G = _flexibility(system, Omega, harmonics)
    linear = np.zeros((harmonics + 1, W.shape[1]), dtype=complex)
    linear[1] = W.T @ G[1] @ F
    free = to_unknowns(linear)
    D = _compliance(np.array(G), W)
    c = free if start is None else start
    size = max(np.abs(free).max(), np.abs(c).max())

    def missing(c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        f, df = contact_forces(system, c)
        u = k[:, np.newaxis] * c - f
        return c - free - np.einsum("imjn,jn->im", D, u), u, df

    c, u = _newton(missing, D, k, c, size)
    X = [G[h] @ (W @ part + (F if h == 1 else 0.0)) for h, part in enumerate(to_complex(u))]
    left = residuals(system, Omega, np.array(X), F)
    return Balance(np.array(X), c, float(np.linalg.norm(left) / np.linalg.norm(F)))


def _newton(missing, D, k, c, size):
    r, u, df = missing(c)
    for _ in range(MOST_STEPS):
        if np.abs(r).max() <= RESIDUAL * size:
            return c, u
        J = np.eye(c.size).reshape(D.shape)
        m = np.arange(c.shape[1])
        for j in range(len(k)):
            slope = -df[j]
            slope[m, m] += k[j]
            J[:, :, j, :] -= D[:, :, j, :] @ slope
        step = np.linalg.solve(J.reshape(c.size, -1), r.ravel()).reshape(c.shape)
        share = 1.0
        while True:
            trial = missing(c - share * step)
            if np.linalg.norm(trial[0]) < np.linalg.norm(r) or share < 1e-3:
                break
            share *= 0.5
        c = c - share * step
        r, u, df = trial
    raise NotBalancedError(f"residual {np.abs(r).max() / size:.1e} of the motion")


def residuals(
    system: System, Omega: float, X: np.ndarray, F: np.ndarray, turn: np.ndarray | float = 0.0
) -> np.ndarray:
    """Return what harmonics X (H + 1, n) leave of the equations of motion, (H + 1, n).

    `turn`, (n, n) or by harmonic (H + 1, n, n), is subtracted from the damping.
    """
    forces = to_complex(contact_forces(system, to_unknowns(X @ system.W))[0])
    turns = np.broadcast_to(turn, (len(X), *system.M.shape))
    left = [
        (system.dynamic_stiffness(h * Omega) - 1j * h * Omega * turns[h]) @ part + system.W @ force
        for h, (part, force) in enumerate(zip(X, forces, strict=True))
    ]
    left[1] = left[1] - F
    return np.array(left)


def curve(
    system: System,
    frequencies: Sequence[float],
    F: np.ndarray,
    harmonics: int = HARMONICS,
) -> list[Balance]:
    """Return the motion at each frequency, each from the one before."""
    found: list[Balance] = []
    for Omega in frequencies:
        found.append(balance(system, Omega, F, found[-1].contact if found else None, harmonics))
    return found


def nonlinear_mode(
    system: System,
    shape: np.ndarray,
    amplitude: float,
    start: NonlinearMode | None = None,
    harmonics: int = HARMONICS,
    alone: bool = False,
) -> NonlinearMode:
    """Return the damped nonlinear mode near `shape` (n,), |shape^T M X_1| = amplitude.

    Extended periodic motion (Krack 2015): M x'' + (C - 2 zeta omega M) x' + K x + W f = 0.
    `shape` has a modal mass of 1. Unknowns are X and omega, zeta; the phase has Im = 0. `alone`:
    the negative damping acts on the first harmonic of this mode only; the two differ where modes
    respond at multiples of omega.
    """
    W, M, H = system.W, system.M, harmonics
    n, weight = len(M), shape @ M
    N = np.broadcast_to(M, (H + 1, n, n))
    if alone:
        N = (np.arange(H + 1) == 1)[:, np.newaxis, np.newaxis] * np.outer(weight, weight)
    if start is None:
        omega = float(np.sqrt(shape @ system.stuck() @ shape))
        turn, X = float(shape @ system.C @ shape), np.zeros((H + 1, n), dtype=complex)
        X[1] = amplitude * shape
    else:
        omega, turn = start.omega, 2.0 * start.zeta * start.omega
        X = start.X * amplitude / abs(weight @ start.X[1])
    y = np.append(to_unknowns(X).T.ravel(), [omega, turn])

    def missing(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        omega, turn = y[-2:]
        x = y[:-2].reshape(2 * H + 1, n).T
        f, df = contact_forces(system, W.T @ x)
        r, J = np.zeros((2 * H + 1, n)), np.zeros((2 * H + 1, n, 2 * H + 1, n))
        slopes = np.zeros((2 * H + 1, n, 2))
        for h in range(H + 1):
            S = system.K - (h * omega) ** 2 * M
            T = h * omega * (system.C - turn * N[h])
            dS, dT = -2.0 * h**2 * omega * M, h * (system.C - turn * N[h])
            parts = [(h, h, S)] if h == 0 else [
                (h, h, S), (h, H + h, -T), (H + h, h, T), (H + h, H + h, S)
            ]  # fmt: skip
            for row, column, block in parts:
                r[row] += block @ x[:, column]
                J[row, :, column, :] += block
            if h:
                re, im = x[:, h], x[:, H + h]
                slopes[h, :, 0], slopes[H + h, :, 0] = dS @ re - dT @ im, dT @ re + dS @ im
                slopes[h, :, 1], slopes[H + h, :, 1] = (
                    h * omega * N[h] @ im,
                    -h * omega * N[h] @ re,
                )
        r += (W @ f).T
        J += np.einsum("ai,ipq,bi->paqb", W, df, W)
        size = (2 * H + 1) * n
        full = np.zeros((size + 2, size + 2))
        full[:size, :size] = J.reshape(size, size)
        full[:size, size:] = slopes.reshape(size, 2)
        full[size, n : 2 * n] = full[size + 1, (H + 1) * n : (H + 2) * n] = weight
        ends = weight @ x[:, 1] - amplitude, weight @ x[:, H + 1]
        return np.append(r.ravel(), ends), full

    r, J = missing(y)
    size = omega**2 * amplitude * np.linalg.norm(M @ shape)
    for _ in range(MOST_STEPS):
        if np.abs(r[:-2]).max() <= RESIDUAL * size and np.abs(r[-2:]).max() <= 1e-9 * amplitude:
            break
        step = scipy.linalg.solve(J, r)
        share = 1.0
        while True:
            trial = missing(y - share * step)
            if np.linalg.norm(trial[0]) < np.linalg.norm(r) or share < 0.02:
                break
            share *= 0.5
        y = y - share * step
        r, J = trial
    else:
        raise NotBalancedError(f"nonlinear mode: residual {np.abs(r[:-2]).max() / size:.1e}")
    omega, turn = y[-2:]
    X = to_complex(y[:-2].reshape(2 * H + 1, n).T)
    left = np.linalg.norm(residuals(system, omega, X, np.zeros(n), turn * N)) / size
    return NonlinearMode(float(omega), float(turn / (2.0 * omega)), X, float(left))
