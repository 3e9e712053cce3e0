"""Lowest natural frequencies and modes, by what one factorisation of the stiffness can do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg

from slipmode.rom.arrays import Floats

_BLOCK = 8  # vectors at a time: so many equal frequencies are told apart
_SETTLED = 1e-9  # residual of a mode, relative to its 1 / lambda
_ROUNDING = 1e-20  # of a squared norm: what is left of a vector that is in the space already

Operator = Callable[[Floats], Floats]


def lowest_modes(
    solve: Operator,
    mass: Operator,
    size: int,
    at_least: int,
    highest: Callable[[Floats], float] = lambda squares: 0.0,
    at_most: int | None = None,
) -> tuple[Floats, Floats]:
    """Lowest eigenvalues (count,) and vectors (size, count) of A phi = lambda M phi.

    Block Lanczos with A^-1 and full reorthogonalisation: the space is extended until the modes
    that are wanted, and the next, have settled.

    Parameters
    ----------
    solve : callable
        A^-1 of vectors (size, m); A symmetric, positive definite.
    mass : callable
        M of vectors (size, m).
    at_least, at_most : int
        How many modes are wanted.
    highest : callable
        Between these, modes with eigenvalues below highest(eigenvalues (at least,)) are wanted.
    """
    most = size if at_most is None else max(at_most, at_least)
    start = np.random.default_rng(0).standard_normal((size, min(_BLOCK, size)))
    latest, _ = _orthonormal(mass, solve(mass(start)))
    space = [latest]
    projected = np.zeros((0, 0))  # V^T M A^-1 M V
    while True:
        moved, coefficients = _without(space, mass, solve(mass(latest)))
        following, norm = _orthonormal(mass, moved)
        projected = _bordered(projected, coefficients)
        theta, vectors = (each[..., ::-1] for each in scipy.linalg.eigh(projected))
        residual = np.linalg.norm(norm @ vectors[-latest.shape[1] :], axis=0)
        settled = residual <= _SETTLED * np.abs(theta)
        wanted = at_least
        if theta.size > at_least:
            below = np.count_nonzero(theta * highest(1.0 / theta[:at_least]) > 1.0)
            wanted = min(max(at_least, int(below)), most)
        whole = following.shape[1] == 0 or theta.size + following.shape[1] > size
        if whole or (wanted < theta.size and settled[: wanted + 1].all()):
            return 1.0 / theta[:wanted], turned(_combined(space, vectors[:, :wanted]))
        space.append(following)
        latest = following


def turned(shapes: Floats) -> Floats:
    """The shapes (n, count) with the sign that makes the largest component of each positive."""
    largest = np.argmax(np.abs(shapes), axis=0)
    return np.asarray(shapes * np.sign(shapes[largest, np.arange(shapes.shape[1])]))


def _without(space: list[Floats], mass: Operator, moved: Floats) -> tuple[Floats, Floats]:
    """Vectors less their part in the space, and the coefficients of that part, (k, m).

    Twice, for the first time leaves rounding of the larger part behind.
    """
    coefficients = np.zeros((sum(part.shape[1] for part in space), moved.shape[1]))
    for _ in range(2):
        heavy = mass(moved)
        again = np.vstack([part.T @ heavy for part in space])
        moved = moved - _combined(space, again)
        coefficients += again
    return moved, coefficients


def _orthonormal(mass: Operator, vectors: Floats) -> tuple[Floats, Floats]:
    """M-orthonormal vectors V (n, r) with vectors = V norm, norm (r, m); r < m if dependent."""
    scale = np.maximum(np.linalg.norm(vectors, axis=0), np.finfo(float).tiny)
    left, norm = vectors / scale, np.diag(scale)
    for _ in range(2):
        squares, axes = scipy.linalg.eigh(left.T @ mass(left))
        kept = squares > _ROUNDING * squares[-1]
        lengths = np.sqrt(squares[kept])
        left = left @ (axes[:, kept] / lengths)
        norm = (lengths[:, np.newaxis] * axes[:, kept].T) @ norm
    return left, norm


def _bordered(projected: Floats, coefficients: Floats) -> Floats:
    """A symmetric matrix with further columns (k, m), and rows."""
    count = len(projected)
    corner = coefficients[count:]
    return np.block(
        [
            [projected, coefficients[:count]],
            [coefficients[:count].T, 0.5 * (corner + corner.T)],
        ]
    )


def _combined(space: list[Floats], coefficients: Floats) -> Floats:
    """The vectors of the space with coefficients (k, m)."""
    sums = np.zeros((len(space[0]), coefficients.shape[1]))
    first = 0
    for part in space:
        sums += part @ coefficients[first : first + part.shape[1]]
        first += part.shape[1]
    return sums
