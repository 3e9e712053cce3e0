"""Drawn structures: chains, frames, beams and plates of at most 12 DOFs with 1 to 10 contacts.

A seed and a kind draw the body, its contacts, their law, and forces that make the contacts slip.
A mode A (and B) of the stuck structure is forced; the ratio of B to A is set where it is asked.
Rigid friction (tanh, Coulomb) acts on light contact masses on springs, which make up the share.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.optimize import brentq

from oracles.closed_forms import jenkins_first_harmonic
from oracles.system import Coulomb, Sliders, System, Tanh, Tone, jenkins

BODIES = ("chain", "frame", "beam", "plate")
LAWS = ("Jenkins", "Iwan", "tanh", "Coulomb")
RATIOS = (1.05, 2.0, 3.0, 5.0)
SHARES = 0.03, 0.3  # of the stiffness of A, due to contacts
SLIDERS = 8  # of an Iwan joint: uniform density of limits, each of equal stiffness


@dataclass(frozen=True)
class Case:
    """A system forced by one tone for each of its modes."""

    name: str
    law: str
    system: System
    modes: tuple[int, ...]  # of the stuck structure
    shapes: np.ndarray  # (n, modes), of modal mass 1
    tones: tuple[Tone, ...]
    amplitude: tuple[float, ...]  # expected |a_j| of x = 2 Re(shape a exp(i Omega t))

    def modal(self, X: np.ndarray, j: int) -> complex:
        """Return the amplitude a_j of displacements Re(X exp(i Omega_j t))."""
        return 0.5 * complex(self.shapes[:, j] @ self.system.M @ X)


def case(
    seed: int,
    modes: int = 1,
    laws: Sequence[str] = LAWS,
    ratio: float | None = None,
    distance: float | None = None,
    shares: tuple[float, float] = SHARES,
) -> Case:
    """Return the case of a seed.

    `ratio`: B / A, to a `distance` drawn up to 5 %. A given `distance` is from a multiple of the
    forcing frequency of A. `shares`: smallest and largest share of stiffness due to contacts.
    """
    rng = np.random.default_rng([50, seed, modes, *(ord(law[0]) for law in laws)])
    while True:
        drawn = _drawn(seed, rng, modes, str(rng.choice(laws)), ratio, distance, shares)
        if drawn is not None:
            return drawn


def close_modes(seed: int, distance: float, shares: tuple[float, float] = SHARES) -> Case:
    """Return a case of one tone on two modes at a relative distance of their frequencies."""
    rng = np.random.default_rng([53, seed])
    while True:
        drawn = _drawn_close(seed, rng, distance, shares)
        if drawn is not None:
            return drawn


def _chain(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, stiffness, and the directions that contacts and forces may have (n, choices)."""
    n = int(rng.integers(4, 8))
    K = np.zeros((n, n))
    for i in range(n + int(rng.random() < 0.5)):
        spring = np.zeros(n)
        if i < n:
            spring[i] = 1.0
        if i:
            spring[i - 1] = -1.0
        K += rng.uniform(5.0, 20.0) * np.outer(spring, spring)
    return np.diag(rng.uniform(0.5, 2.0, n)), K, np.eye(n)


def _frame(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    masses = int(rng.integers(2, 4))
    K = np.zeros((2 * masses, 2 * masses))
    for i in range(masses):
        for size, angle in (
            (rng.uniform(20.0, 60.0), rng.uniform(-0.6, 0.6)),
            (rng.uniform(5.0, 40.0), rng.uniform(0.8, 2.2)),
        ):
            spring = np.zeros(2 * masses)
            spring[2 * i : 2 * i + 2] = np.cos(angle), np.sin(angle)
            if i:
                spring[2 * i - 2 : 2 * i] = -np.cos(angle), -np.sin(angle)
            K += size * np.outer(spring, spring)
    angles = rng.uniform(0.0, np.pi, masses)
    inclined = [
        np.kron(row, [np.cos(a), np.sin(a)]) for row, a in zip(np.eye(masses), angles, strict=True)
    ]
    return np.diag(np.repeat(rng.uniform(0.5, 2.0, masses), 2)), K, np.array(inclined).T


def _beam(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cantilever of 12 equal elements on its 7 lowest modes."""
    elements, h = 12, 1.0 / 12
    K, M = np.zeros((26, 26)), np.zeros((26, 26))
    k = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2],
                  [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]]) / h**3  # fmt: skip
    m = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2],
                  [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]]) * h / 420  # fmt: skip
    for e in range(elements):
        at = np.ix_(range(2 * e, 2 * e + 4), range(2 * e, 2 * e + 4))
        K[at] += k + np.triu(k, 1).T
        M[at] += m + np.triu(m, 1).T
    free = slice(2, None)
    squares, shapes = scipy.linalg.eigh(K[free, free], M[free, free], subset_by_index=(0, 6))
    return np.eye(7), np.diag(squares), shapes[::2].T[:, int(rng.integers(1, 4)) :]


def _plate(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simply supported plate on 7 modes, with 12 random points."""
    aspect = rng.uniform(0.5, 0.9)
    m, n = np.meshgrid(np.arange(1, 6), np.arange(1, 6))
    squares = ((m.ravel() ** 2 + (n.ravel() / aspect) ** 2) ** 2).astype(float)
    first = np.argsort(squares)[:7]
    x, y = rng.uniform(0.1, 0.9, (2, 12))
    rows = np.sin(np.pi * np.outer(m.ravel()[first], x)) * np.sin(
        np.pi * np.outer(n.ravel()[first], y)
    )
    return np.eye(7), np.diag(squares[first]), 2.0 * rows


def _softening(laws: Sequence[Sliders], shape: np.ndarray, a: float) -> complex:
    """Return what slip changes of omega^2 if the contacts move by 2 a shape cos(theta)."""
    change = 0.0j
    for w, joint in zip(shape, laws, strict=True):
        X = max(2.0 * a * abs(w), 1e-12)
        for limit, stiffness in zip(joint.limits, joint.stiffnesses, strict=True):
            change += w**2 * (jenkins_first_harmonic(X, limit, stiffness) / X - stiffness)
    return change


def _body(rng: np.random.Generator) -> tuple[str, np.ndarray, np.ndarray, np.ndarray]:
    body = str(rng.choice(BODIES))
    make = {"chain": _chain, "frame": _frame, "beam": _beam, "plate": _plate}[body]
    return body, *make(rng)


def _joints(law: str, limits: np.ndarray, k: np.ndarray) -> list[Sliders]:
    joints = [jenkins(*pair) for pair in zip(limits.tolist(), k.tolist(), strict=True)]
    if law == "Iwan":
        spread = np.linspace(0.2, 1.8, SLIDERS) / SLIDERS
        joints = [Sliders(tuple(spread * joint.limits), (joint.stuck / SLIDERS,) * SLIDERS)
                  for joint in joints]  # fmt: skip
    return joints


def _with_share(M, K, W, k, A, share):
    """Return stiffnesses with a share of that of mode A, squares and shapes; None: too weak."""

    def stuck(size):
        return scipy.linalg.eigh(K + size * (W * k) @ W.T, M)

    def excess(size):
        squares, shapes = stuck(size)
        return size * k @ (W.T @ shapes[:, A]) ** 2 / squares[A] - share

    if excess(np.trace(K)) < 0.0:
        return None
    size = brentq(excess, 0.0, np.trace(K))
    return k * size, *stuck(size)


def _drawn_close(seed, rng, distance, shares):
    body, M, K, choices = _body(rng)
    A, B = (0, 1) if rng.random() < 0.5 else (1, 2)
    count = int(rng.integers(1, min(choices.shape[1], len(M)) + 1))
    W = choices[:, rng.choice(choices.shape[1], count, replace=False)]
    k = rng.uniform(0.5, 1.5, count)
    share = float(np.exp(rng.uniform(*np.log(shares))))

    found = _with_share(M, K, W, k, A, share)
    if found is None:
        return None
    k, squares, shapes = found
    omega = np.sqrt(squares)
    omega[B] = (1.0 + distance) * omega[A]
    apart = np.abs(np.delete(omega, [A, B])[:, np.newaxis] / omega[[A, B]] - 1.0)
    K = M @ (shapes * omega**2) @ shapes.T @ M - (W * k) @ W.T
    moved, point = np.abs(W.T @ shapes), choices[:, rng.integers(choices.shape[1])]
    driven = np.abs(point @ shapes)
    if (apart.min() < 0.15 or np.linalg.eigvalsh(K)[0] < 0.0
            or moved[:, [A, B]].max(axis=0).min() < 0.1 * moved.max()
            or driven[[A, B]].min() < 0.1 * driven.max()):  # fmt: skip
        return None
    zeta, level = rng.uniform(0.002, 0.005), float(np.exp(rng.uniform(np.log(0.9), np.log(5.0))))
    law, a = str(rng.choice(["Jenkins", "Iwan"])), 0.5 / moved[:, A].max()
    laws = _joints(law, k / level, k)
    soft = _softening(laws, W.T @ shapes[:, A], a)
    Omega = float(np.sqrt(omega[A] ** 2 + soft.real) * (1.0 + rng.uniform(-0.01, 0.01)))
    size = 2.0 * a * abs(omega[A] ** 2 - Omega**2 + 2j * zeta * omega[A] * Omega + soft)
    C = M @ (shapes * 2.0 * zeta * omega) @ shapes.T @ M
    name = f"{seed}: {body}, {count} {law}, share {share:.2g}, level {level:.2g}"
    order = tuple(int(np.sum(omega < omega[j] * (1.0 - 1e-9))) for j in (A, B))
    chosen = (order[0], order[0] + 1)
    system = System(M, 0.5 * (C + C.T), 0.5 * (K + K.T), W, laws)
    tone = Tone(Omega, (size / driven[A] * point).astype(complex))
    return Case(name, law, system, chosen, shapes[:, [A, B]], (tone,), (a,))


def _drawn(seed, rng, modes, law, ratio, distance, shares):
    body, M, K, choices = _body(rng)
    rigid = law in ("tanh", "Coulomb")
    most = min(10, choices.shape[1], 12 - len(M) if rigid else len(M))
    count = int(rng.integers(1, most + 1))
    W = choices[:, rng.choice(choices.shape[1], count, replace=False)]
    k = rng.uniform(0.5, 1.5, count)
    share = float(np.exp(rng.uniform(*np.log(shares))))
    A = int(rng.integers(0, 2))

    found = _with_share(M, K, W, k, A, share)
    if found is None:
        return None
    k, squares, shapes = found
    omega = np.sqrt(squares)
    moved = np.abs(W.T @ shapes)
    B = A + 1
    if ratio is not None:
        above = np.where(squares > squares[A], np.abs(omega / omega[A] - ratio), np.inf)
        B = int(np.argmin(above))
    chosen = [A, B][:modes]
    if min(moved[:, j].max() for j in chosen) < 0.1 * moved[:, :4].max():
        return None

    # amplitudes at which the largest contact motion is `level` times the slip distance
    amplitudes = [float((1.0 if modes == 1 else 0.5) / (2.0 * moved[:, j].max())) for j in chosen]
    level = float(np.exp(rng.uniform(np.log(0.9), np.log(5.0))))
    reach = max((2.0 * a * moved[:, j]).max() for a, j in zip(amplitudes, chosen, strict=True))
    limits = k * reach / level
    laws = _joints(law, limits, k)
    softened = {
        j: _softening(laws, W.T @ shapes[:, j], a) for a, j in zip(amplitudes, chosen, strict=True)
    }
    resonance = float(np.sqrt(squares[A] + softened[A].real))
    if ratio is not None:
        off = rng.uniform(1e-3, 0.05) * (1.0 if ratio < 1.5 else rng.choice((-1.0, 1.0)))
        omega[B] = resonance * ratio * (1.0 + (off if distance is None else distance))
        squares = omega**2
        K = M @ (shapes * squares) @ shapes.T @ M - (W * k) @ W.T
        if np.linalg.eigvalsh(K)[0] < 0.02 * squares[A] * np.linalg.eigvalsh(M)[0]:
            return None
    apart = np.abs(omega[:, np.newaxis] / omega[[A, B]] - 1.0)
    apart[[A, B], [0, 1]] = 1.0
    apart = np.delete(apart, [A, B], axis=0) if ratio is not None else apart[:, :modes]
    if apart.min() < 0.12 or (ratio is not None and omega[B] < 1.01 * omega[A]):
        return None
    zeta = rng.uniform(0.002, 0.005)
    C = M @ (shapes * 2.0 * zeta * omega) @ shapes.T @ M
    point = choices[:, rng.integers(choices.shape[1])]
    forces, frequencies = [], []
    for a, j in zip(amplitudes, chosen, strict=True):
        if abs(point @ shapes[:, j]) < 0.1 * np.abs(choices.T @ shapes[:, j]).max():
            return None
        off = rng.uniform(-0.01, 0.01) if distance is None or j != A else 0.0
        Omega = float(np.sqrt(squares[j] + softened[j].real) * (1.0 + off))
        stiff = squares[j] - Omega**2 + 2j * zeta * omega[j] * Omega + softened[j]
        forces.append(2.0 * a * abs(stiff) / (point @ shapes[:, j]) * point)
        frequencies.append(Omega)
    name = f"{seed}: {body}, {count} {law}, share {share:.2g}, level {level:.2g}, zeta {zeta:.2g}"
    name += f", B/A {omega[B] / omega[A]:.4g}, modes {chosen}"
    sorted_modes = tuple(int(np.sum(squares < squares[j])) for j in chosen)
    phi = shapes[:, chosen]
    if rigid:
        light = 0.02 * np.trace(M) / len(M)
        alpha = 0.02 * frequencies[0] * float(np.median(limits / k))
        laws = [Tanh(float(L), alpha) if law == "tanh" else Coulomb(float(L)) for L in limits]
        n = len(M)
        edge = np.zeros((n, count))
        K = np.block([[K + (W * k) @ W.T, -W * k], [-(W * k).T, np.diag(k)]])
        M = scipy.linalg.block_diag(M, light * np.eye(count))
        C = scipy.linalg.block_diag(C, 2 * zeta * np.diag(np.sqrt(k * light)))
        W = np.vstack((edge, np.eye(count)))
        phi = np.vstack((phi, np.zeros((count, modes))))
        forces = [np.append(f, np.zeros(count)) for f in forces]
    tones = tuple(
        Tone(Omega, f.astype(complex)) for Omega, f in zip(frequencies, forces, strict=True)
    )
    system = System(M, 0.5 * (C + C.T), K, W, laws)
    return Case(name, law, system, sorted_modes, phi, tones, tuple(amplitudes))
