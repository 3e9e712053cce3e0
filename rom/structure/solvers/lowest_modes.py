"""Lowest natural frequencies and modes from one factorisation of the stiffness."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import Sparse

Operator = Callable[[Any], Any]  # real or complex vectors (size, m)


def lowest_modes(
    solve: Operator,
    mass: Operator,
    size: int,
    at_least: int,
    highest: Callable[[Floats], float] = lambda squares: 0.0,
    at_most: int | None = None,
) -> tuple[Floats, Floats]:
    """Return the lowest eigenvalues (count,) and vectors (size, count) of A phi = lambda M phi.

    A and M are symmetric or Hermitian.

    Block Lanczos with A^-1 and full reorthogonalisation: the space is extended until the modes to
    return, and the next one, have converged. `solve` and `mass` apply A^-1, A positive definite,
    and M to vectors (size, m). Between the bounds `at_least` and `at_most`, all modes are returned
    with eigenvalues below `highest` of all eigenvalues found.
    """
    most = size if at_most is None else max(at_most, at_least)
    # a block of eight vectors finds eight equal frequencies for certain
    start = np.random.default_rng(0).standard_normal((size, min(8, size)))
    latest, _ = _orthonormal(mass, solve(mass(start)))
    space = latest  # (size, k)
    projected = np.zeros((0, 0))  # V^T M A^-1 M V
    while True:
        # Less the part in the space, twice: the first time leaves rounding of the larger part.
        vectors = solve(mass(latest))
        coefficients = np.zeros((space.shape[1], latest.shape[1]), dtype=vectors.dtype)
        for _ in range(2):
            part = space.conj().T @ mass(vectors)
            vectors = vectors - space @ part
            coefficients += part
        following, norm = _orthonormal(mass, vectors)
        count = len(projected)
        own = coefficients[count:]
        corner = 0.5 * (own + own.conj().T)
        projected = np.block(
            [[projected, coefficients[:count]], [coefficients[:count].conj().T, corner]]
        )
        theta, ritz = (each[..., ::-1] for each in scipy.linalg.eigh(projected))
        residual = np.linalg.norm(norm @ ritz[-latest.shape[1] :], axis=0)
        converged = residual <= 1e-9 * np.abs(theta)
        wanted = at_least
        if theta.size > at_least:
            below = np.count_nonzero(theta * highest(1.0 / theta) > 1.0)
            wanted = min(max(at_least, int(below)), most)
        whole = following.shape[1] == 0 or theta.size + following.shape[1] > size
        if whole or (wanted < theta.size and converged[: wanted + 1].all()):
            return 1.0 / theta[:wanted], with_fixed_signs(space @ ritz[:, :wanted])
        space = np.hstack((space, following))
        latest = following


def dense_modes(
    stiffness: Floats, mass: Floats, massless: Sparse, count: int | None = None
) -> tuple[Floats, Floats]:
    """Return the lowest eigenvalues (count,) and modes (n, count) of K phi = lambda M phi, or all.

    Motions Z = `massless` (n, m), M Z = 0, follow the other motions B y statically, which is
    exact: x = B y - Z (Z^T K Z)^-1 Z^T K B y.
    """
    lowest = None if count is None else (0, count - 1)
    if not massless.shape[1]:
        squares, shapes = scipy.linalg.eigh(stiffness, mass, subset_by_index=lowest)
        return squares, shapes
    Z = massless.toarray()
    B = scipy.linalg.qr(Z)[0][:, Z.shape[1] :]
    forces = Z.T @ stiffness
    follow = B - Z @ scipy.linalg.solve(forces @ Z, forces @ B, assume_a="pos")
    condensed = follow.T @ stiffness @ follow
    condensed = 0.5 * (condensed + condensed.T)
    inertia = B.T @ mass @ B
    inertia = 0.5 * (inertia + inertia.T)
    squares, shapes = scipy.linalg.eigh(condensed, inertia, subset_by_index=lowest)
    return squares, follow @ shapes


def with_fixed_signs(shapes: Floats) -> Floats:
    """Return shapes (n, count) whose first large component is positive, also of complex ones.

    Large is more than 0.7 of the largest: of symmetric structures two are equal except for
    rounding, and rounding depends on the machine.
    """
    size = np.abs(shapes)
    first = np.argmax(size > 0.7 * size.max(axis=0), axis=0)
    large = shapes[first, np.arange(shapes.shape[1])]
    return np.asarray(shapes * (large / np.abs(large)).conj())


def _orthonormal(mass: Operator, vectors: Floats) -> tuple[Floats, Floats]:
    """Return M-orthonormal V (n, r) with vectors = V norm, norm (r, m); r < m if dependent."""
    scale = np.maximum(np.linalg.norm(vectors, axis=0), np.finfo(float).tiny)
    left, norm = vectors / scale, np.diag(scale)
    for _ in range(2):
        if left.shape[1] == 0:  # all vectors are 0
            break
        squares, axes = scipy.linalg.eigh(left.conj().T @ mass(left))
        # The others are in the space already
        kept = squares > 1e-20 * squares[-1]
        lengths = np.sqrt(squares[kept])
        left = left @ (axes[:, kept] / lengths)
        norm = (lengths[:, np.newaxis] * axes[:, kept].conj().T) @ norm
    return left, norm
