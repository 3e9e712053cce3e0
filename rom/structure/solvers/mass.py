"""Definiteness of symmetric matrices, and the mobility of contacts, W^T M^-1 W.

A large mass matrix is not factorised. Scaled by its diagonal, a mass matrix of finite elements has
eigenvalues of about 1 (A. J. Wathen, 1987): Lanczos steps and conjugate gradients converge fast.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.structure.matrices import (
    BLOCK,
    TOLERANCE,
    Matrix,
    as_csc,
    as_dense,
    largest_entry,
)
from slipmode.rom.structure.solvers.factorisation import SMALL, NotPositiveDefiniteError, factorise


def is_positive_definite(matrix: Matrix, name: str) -> bool:
    """Return whether a symmetric matrix, which messages call `name`, can be factorised."""
    try:
        factorise(matrix, name)
    except NotPositiveDefiniteError:
        return False
    return True


def is_positive_semidefinite(matrix: Matrix, name: str) -> bool:
    """Return whether no eigenvalue of a symmetric matrix is negative beyond rounding.

    The rounding allowance is added to the diagonal, so that a singular matrix can be factorised.
    """
    shift = TOLERANCE * (largest_entry(matrix) or 1.0)
    size = matrix.shape[0]
    if isinstance(matrix, np.ndarray):
        return is_positive_definite(matrix + shift * np.eye(size), name)
    return is_positive_definite(as_csc(matrix + shift * scipy.sparse.eye_array(size)), name)


def is_positive_mass(mass: Matrix) -> bool:
    """Return whether a mass matrix is positive definite, except for rows of zeros.

    A large one is factorised only if Lanczos steps do not find its smallest eigenvalue.
    """
    heavy = ~massless(mass)
    if not heavy.all():
        if not heavy.any() or largest_entry(mass[~heavy]) > 0.0:
            return False
        mass = mass[heavy][:, heavy]
    diagonal = mass.diagonal()
    if isinstance(mass, np.ndarray) or mass.shape[0] <= SMALL or not (diagonal > 0).all():
        return is_positive_definite(mass, "mass")
    if mass.nnz == mass.shape[0]:
        return True

    unit = 1.0 / np.sqrt(diagonal)

    def scaled(x: Floats) -> Floats:
        return np.asarray(unit * (mass @ (unit * x.ravel())))

    try:
        lowest = scipy.sparse.linalg.eigsh(
            scipy.sparse.linalg.LinearOperator(mass.shape, matvec=scaled, dtype=np.float64),
            k=1,
            which="SA",
            v0=np.random.default_rng(0).standard_normal(mass.shape[0]),
            ncv=20,
            maxiter=50,
            tol=0.1,  # only the sign matters
            return_eigenvectors=False,
        )
    except scipy.sparse.linalg.ArpackNoConvergence:
        return is_positive_definite(mass, "mass")
    return bool(lowest[0] > TOLERANCE)


def massless(mass: Matrix) -> Flags:
    """Return which DOFs of a positive semidefinite mass matrix have no mass, (n,)."""
    return np.asarray(mass.diagonal() == 0.0)


def mobility(mass: Matrix, directions: Matrix) -> Floats:
    """Return W^T M^-1 W (N_c, N_c) [1/kg]: contact velocity per impulse on the contacts.

    The contacts act on DOFs with mass. A large mass matrix is factorised only if conjugate
    gradients do not converge.
    """
    heavy = ~massless(mass)
    W: Any = directions
    if not heavy.all():
        mass, W = mass[heavy][:, heavy], W[heavy]
    if not isinstance(mass, np.ndarray) and mass.shape[0] > SMALL:
        found = np.empty((W.shape[1], W.shape[1]))
        for start in range(0, W.shape[1], BLOCK):
            block = slice(start, start + BLOCK)
            velocity = _conjugate_gradients(mass, as_dense(W[:, block]))
            if velocity is None:
                break
            found[:, block] = W.T @ velocity
        else:
            return found
    return np.asarray(W.T @ factorise(mass, "mass").solve(as_dense(W)))


def _conjugate_gradients(mass: Matrix, impulse: Floats) -> Floats | None:
    """Return M^-1 impulse (n, columns), preconditioned by the diagonal; None if not converged.

    The energy impulse^T M^-1 impulse / 2 grows from pass to pass. The error of the energy is about
    the gain of the last pass.
    """
    inverse = 1.0 / mass.diagonal()[:, np.newaxis]
    velocity, residual = np.zeros_like(impulse), impulse.copy()
    direction = inverse * residual
    power = np.einsum("nk,nk->k", residual, direction)
    gained = np.zeros_like(power)
    for _ in range(500):
        moved = as_dense(mass @ direction)
        scale = power / np.maximum(np.einsum("nk,nk->k", direction, moved), np.finfo(float).tiny)
        velocity += scale * direction
        residual -= scale * moved
        gained += scale * power
        if np.all(scale * power <= 1e-15 * gained):
            return velocity
        conditioned = inverse * residual
        before, power = power, np.einsum("nk,nk->k", residual, conditioned)
        ratio = np.divide(power, before, out=np.zeros_like(power), where=before > 0)
        direction = conditioned + ratio * direction
    return None
