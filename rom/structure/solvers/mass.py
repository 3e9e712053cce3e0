"""Definiteness of symmetric matrices, motions without inertia, and the mass of contacts.

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
    Sparse,
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


def massless_motions(mass: Matrix) -> Sparse | None:
    """Return an orthonormal basis Z (n, m) of the motions without inertia, M Z = 0.

    None if the mass matrix is not positive semidefinite. Most are unit motions of DOFs with rows
    of zeros. Others are computed for each group of coupled DOFs. A large group of a sparse matrix
    is taken for indefinite.
    """
    n = mass.shape[0]
    empty = mass.diagonal() == 0.0
    zeros, heavy = np.flatnonzero(empty), np.flatnonzero(~empty)
    is_dense = isinstance(mass, np.ndarray)
    if not heavy.size or mass.diagonal().min() < 0.0:
        return None
    if zeros.size and largest_entry(mass[zeros]) > 0.0:
        return None
    unit = scipy.sparse.eye_array(n, format="csc")
    found = [unit[:, zeros]]
    rest: Any = mass[heavy][:, heavy] if zeros.size else mass
    if not _is_positive_mass(rest):
        _, group = scipy.sparse.csgraph.connected_components(as_csc(rest), directed=False)
        order = np.argsort(group, kind="stable")
        for dofs in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
            motions = None
            if is_dense or dofs.size <= SMALL:
                motions = _null_space(as_dense(rest[dofs][:, dofs]))
            if motions is None:
                return None
            found.append(unit[:, heavy[dofs]] @ as_csc(motions))
    return as_csc(scipy.sparse.hstack(found))


def _null_space(mass: Floats) -> Floats | None:
    """Return an orthonormal basis of M z = 0 up to rounding; None if M is indefinite."""
    unit = 1.0 / np.sqrt(mass.diagonal())
    sizes, motions = scipy.linalg.eigh(unit[:, np.newaxis] * mass * unit)
    if sizes[0] < -TOLERANCE:
        return None
    basis, _ = np.linalg.qr(unit[:, np.newaxis] * motions[:, sizes <= TOLERANCE])
    return np.asarray(basis)


def _is_positive_mass(mass: Matrix) -> bool:
    """Return whether a mass matrix with a positive diagonal is positive definite.

    A large one is factorised only if Lanczos steps do not find its smallest eigenvalue.
    """
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


def contacts_moved(massless: Sparse, directions: Matrix) -> tuple[Floats, Flags]:
    """Return contact displacements (N_c, k) of the motions without inertia that have some.

    Also return which of the motions (n, m) these are, (m,).
    """
    W = as_csc(directions)
    moved = as_csc(W.T @ massless)
    lengths = np.sqrt(as_csc(W.multiply(W)).sum(axis=0))
    moved.data[np.abs(moved.data) <= TOLERANCE * lengths[moved.indices]] = 0.0  # rounding
    moved.eliminate_zeros()
    columns = np.diff(moved.indptr) > 0
    return as_dense(moved[:, columns]), columns


def contact_mass(mass: Matrix, massless: Sparse, directions: Matrix) -> Floats:
    """Return (W^T M^-1 W)^-1 (N_c, N_c) [kg]: impulse on the contacts per contact velocity.

    Contact motions that motions without inertia allow have no mass. A large mass matrix is
    factorised only if conjugate gradients do not converge.
    """
    W: Any = directions
    if massless.shape[1]:  # W^T Z = 0 in the directions below: mass along Z does not matter
        along: Any = mass.diagonal().max() * (massless @ massless.T)
        mass = mass + along.toarray() if isinstance(mass, np.ndarray) else as_csc(mass + along)
    moved, _ = contacts_moved(massless, directions)
    if not moved.size:
        return np.asarray(scipy.linalg.inv(_mobility(mass, W)))
    inertial = scipy.linalg.null_space(moved.T, rcond=TOLERANCE)
    if not inertial.shape[1]:
        return np.zeros((W.shape[1], W.shape[1]))
    inertia = scipy.linalg.inv(_mobility(mass, as_csc(W @ inertial)))
    return np.asarray(inertial @ inertia @ inertial.T)


def _mobility(mass: Matrix, W: Any) -> Floats:
    """Return W^T M^-1 W: contact velocity per impulse on the contacts [1/kg]."""
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
