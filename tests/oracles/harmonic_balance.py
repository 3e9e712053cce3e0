"""Harmonic balance of elastic contacts under one tone, by alternating frequency and time.

x = Re(sum_h X_h exp(i h Omega t)), h = 0 .. H. Newton's method has the exact derivative of the
sliders' motion. More harmonics state the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oracles.system import Frictional, Law, System

HARMONICS, PER_HARMONIC = 15, 32  # samples per period of the last harmonic
MOST_STEPS, RESIDUAL = 60, 1e-9
SHARES = 0.5 ** np.arange(7)  # of a Newton step, the first that lowers the residual


class NotBalancedError(Exception):
    """Newton's method did not converge."""


@dataclass(frozen=True)
class NonlinearMode:
    """Damped nonlinear mode: frequency [rad/s], damping ratio [-], harmonics (H + 1, n)."""

    omega: float
    zeta: float
    X: np.ndarray


def _basis(H: int) -> tuple[np.ndarray, np.ndarray]:
    """Return samples of unknowns (samples, 2 H + 1) and their projection back."""
    samples = PER_HARMONIC * H
    theta = 2.0 * np.pi * np.arange(samples) / samples
    h = np.arange(1, H + 1)
    angles = np.outer(theta, h)
    basis = np.hstack((np.ones((samples, 1)), np.cos(angles), -np.sin(angles)))
    return basis, np.linalg.pinv(basis)


def _padded(laws: Sequence[Law]) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffnesses and reaches limit / stiffness (contacts, most sliders)."""
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
            ds[moved != s] = row
            s = moved
            force[i] = (k * (x[i][:, np.newaxis] - s)).sum(axis=1)
            slope[i] = np.einsum("cs,csu->cu", k, row - ds)
    return (back @ force).T, np.einsum("us,scv->cuv", back, slope)


def frictional_forces(system: System, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the same of frictional contacts; a derivative of each force by all displacements."""
    basis, back = _basis(c.shape[1] // 2)
    names = ("mu", "preload", "tangential", "normal", "gap")
    mu, preload, k, stiffness, gap = np.array(
        [[getattr(law, name) for name in names] for law in system.laws]
    ).T
    x, x_n = (basis @ c.T).reshape(len(basis), -1, 2).transpose(2, 0, 1)
    N = np.maximum(preload + stiffness * (x_n - gap), 0.0)
    dN = np.where(N > 0.0, stiffness, 0.0)
    low, high, turn = x - mu * N / k, x + mu * N / k, mu * dN / k
    own = np.arange(len(mu))
    s, ds = np.zeros_like(mu), np.zeros((2, len(mu), c.shape[1]))  # by x_t and by x_n
    force, slope = np.zeros((len(x), *c.shape[:1])), np.zeros((len(x), len(c), *c.shape))
    for _ in range(2):
        for i, row in enumerate(basis):
            moved = np.clip(s, low[i], high[i])
            for sign, at in ((-1.0, moved > s), (1.0, moved < s)):
                ds[0, at], ds[1, at] = row, sign * np.outer(turn[i], row)[at]
            s = moved
            force[i, ::2], force[i, 1::2] = k * (x[i] - s), N[i] - preload
            slope[i, 2 * own, 2 * own] = k[:, np.newaxis] * (row - ds[0])
            slope[i, 2 * own, 2 * own + 1] = -k[:, np.newaxis] * ds[1]
            slope[i, 2 * own + 1, 2 * own + 1] = np.outer(dN[i], row)
    return (back @ force).T, np.einsum("us,scdv->cudv", back, slope)


def to_complex(c: np.ndarray) -> np.ndarray:
    """Return harmonics (H + 1, contacts) of unknowns (contacts, 2 H + 1)."""
    H = c.shape[1] // 2
    return np.vstack((c[:, :1].T, (c[:, 1 : H + 1] + 1j * c[:, H + 1 :]).T)).astype(complex)


def to_unknowns(C: np.ndarray) -> np.ndarray:
    """Return unknowns (contacts, 2 H + 1) of harmonics (H + 1, contacts)."""
    return np.hstack((C[:1].T.real, C[1:].T.real, C[1:].T.imag))


def _blocks(S: np.ndarray) -> np.ndarray:
    """Return matrices of harmonics (H + 1, n, n) for unknowns, (n, 2 H + 1, n, 2 H + 1)."""
    H, n = len(S) - 1, S.shape[1]
    found = np.zeros((n, 2 * H + 1, n, 2 * H + 1))
    for h, each in enumerate(S):
        found[:, h, :, h] = each.real
        if h:
            found[:, H + h, :, H + h] = each.real
            found[:, h, :, H + h] = -each.imag
            found[:, H + h, :, h] = each.imag
    return found


def _stiffnesses(system: System, omega: float, damping: np.ndarray) -> np.ndarray:
    """Return dynamic stiffnesses (H + 1, n, n) with a damping matrix of each harmonic."""
    h = np.arange(len(damping))[:, np.newaxis, np.newaxis]
    lossy = system.K + 1j * np.sign(h) * system.loss
    return lossy - (h * omega) ** 2 * system.M + 1j * h * omega * damping


def _equations(system: System, x: np.ndarray, S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return S X + W f of unknowns (n, 2 H + 1), and its derivative."""
    linear = _blocks(S)
    if isinstance(system.laws[0], Frictional):
        f, df = frictional_forces(system, system.W.T @ x)
        J = linear + np.einsum("ci,iajb,dj->cadb", system.W, df, system.W)
    else:
        f, df = contact_forces(system, system.W.T @ x)
        J = linear + np.einsum("ci,iab,di->cadb", system.W, df, system.W)
    return np.einsum("cadb,db->ca", linear, x) + system.W @ f, J


def _newton(missing, y: np.ndarray, size: float) -> np.ndarray:
    """Return y at which missing(y), a residual of a size and its derivative, is 0."""
    r, J = missing(y)
    for _ in range(MOST_STEPS):
        if np.abs(r).max() <= RESIDUAL * size:
            return y
        step = np.linalg.solve(J, r)
        for share in SHARES:
            trial = missing(y - share * step)
            if np.linalg.norm(trial[0]) < np.linalg.norm(r):
                break
        y, (r, J) = y - share * step, trial
    raise NotBalancedError(f"residual {np.abs(r).max() / size:.1e} of the forces")


def balance(system: System, Omega: float, F: np.ndarray, harmonics: int = HARMONICS) -> np.ndarray:
    """Return harmonics (H + 1, n) of the motion under Re(F exp(i Omega t)). NotBalancedError."""
    S = _stiffnesses(system, Omega, np.array((harmonics + 1) * [system.C]))
    X, force = np.zeros((2, harmonics + 1, len(F)), dtype=complex)
    force[1] = F
    X[1] = np.linalg.solve(S[1] + system.stuck() - system.K, F)
    x = to_unknowns(X)

    def missing(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, J = _equations(system, y.reshape(x.shape), S)
        return (r - to_unknowns(force)).ravel(), J.reshape(y.size, -1)

    return to_complex(_newton(missing, x.ravel(), np.abs(F).max()).reshape(x.shape))


def residuals(system: System, Omega: float, X: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return what harmonics X (H + 1, n) leave of the equations of motion, (H + 1, n)."""
    S = _stiffnesses(system, Omega, np.array(len(X) * [system.C]))
    left = to_complex(_equations(system, to_unknowns(X), S)[0])
    left[1] -= F
    return left


def nonlinear_mode(
    system: System,
    shape: np.ndarray,
    amplitude: float,
    start: NonlinearMode | None = None,
    harmonics: int = HARMONICS,
    alone: bool = False,
    static: np.ndarray | None = None,
) -> NonlinearMode:
    """Return the damped nonlinear mode near `shape` (n,), |shape^T M X_1| = amplitude.

    Extended periodic motion (Krack 2015): M x'' + (C - 2 zeta omega M) x' + K x + W f = 0.
    `shape` has a modal mass of 1. Unknowns are X and omega, zeta; the phase has Im = 0. `alone`:
    the negative damping acts on the first harmonic of this mode only; the two differ where modes
    respond at multiples of omega. The sliders
    march from 0 under a force `static` (n,) and the vibration.
    """
    F = np.zeros(len(shape)) if static is None else static
    M, H, n = system.M, harmonics, len(shape)
    weight = shape @ M
    N = np.array((H + 1) * [M])
    if alone:
        N = (np.arange(H + 1) == 1)[:, np.newaxis, np.newaxis] * np.outer(weight, weight)
    if start is None:
        omega = float(np.sqrt(shape @ system.stuck() @ shape))
        turn, X = float(shape @ system.C @ shape), np.zeros((H + 1, n), dtype=complex)
        X[0], X[1] = np.linalg.solve(system.stuck(), F), amplitude * shape
    else:
        omega, turn = start.omega, 2.0 * start.zeta * start.omega
        X = start.X * amplitude / abs(weight @ start.X[1])
    force = omega**2 * np.linalg.norm(weight)  # of a displacement 1, the scale of the last rows
    h = np.arange(H + 1)[:, np.newaxis, np.newaxis]

    def missing(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, (omega, turn) = y[:-2].reshape(n, -1), y[-2:]
        r, J = _equations(system, x, _stiffnesses(system, omega, system.C - turn * N))
        r[:, 0] -= F
        changes = (-2.0 * h**2 * omega * M + 1j * h * (system.C - turn * N), -1j * h * omega * N)
        slopes = [to_unknowns(np.einsum("hij,hj->hi", S, to_complex(x))) for S in changes]
        full = np.zeros((y.size, y.size))
        full[:-2, :-2] = J.reshape(y.size - 2, -1)
        full[:-2, -2:] = np.reshape(slopes, (2, -1)).T
        for row, column in ((-2, 1), (-1, H + 1)):  # real and imaginary part of X_1
            full[row, np.arange(n) * (2 * H + 1) + column] = force * weight
        ends = force * np.array([weight @ x[:, 1] - amplitude, weight @ x[:, H + 1]])
        return np.append(r, ends), full

    y = _newton(missing, np.append(to_unknowns(X), [omega, turn]), force * amplitude)
    omega, turn = y[-2:]
    X = to_complex(y[:-2].reshape(n, -1))
    return NonlinearMode(float(omega), float(turn / (2.0 * omega)), X)
