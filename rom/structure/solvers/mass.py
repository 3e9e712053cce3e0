"""Definiteness of symmetric matrices, and the mobility of contacts, W^T M^-1 W.

A large mass matrix is not factorised. Scaled by its diagonal, a mass matrix of finite elements has
eigenvalues of about 1 (A. J. Wathen, 1987): Lanczos steps and conjugate gradients converge fast.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import TOLERANCE, Matrix, as_csc, as_dense, largest_entry
from slipmode.rom.structure.solvers.factorisation import SMALL, NotPositiveDefiniteError, factorise

_RESIDUAL = 1e-8  # of conjugate gradients, relative; the error of W^T M^-1 W is of second order


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
    """Return whether a mass matrix is positive definite.

    A large one is factorised only if Lanczos steps do not find its smallest eigenvalue.
    """
    diagonal = mass.diagonal()
    if isinstance(mass, np.ndarray) or mass.shape[0] <= SMALL or not (diagonal > 0).all():
        return is_positive_definite(mass, "mass")
    if mass.nnz == mass.shape[0]:
        return True
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

    unit = 1.0 / np.sqrt(diagonal)

    def scaled(x: Floats) -> Floats:
        return np.asarray(unit * (mass @ (unit * x.ravel())))

    try:
        lowest = eigsh(
            LinearOperator(mass.shape, matvec=scaled, dtype=np.float64),
            k=1,
            which="SA",
            v0=np.random.default_rng(0).standard_normal(mass.shape[0]),
            ncv=20,
            maxiter=50,
            tol=0.1,  # only the sign matters
            return_eigenvectors=False,
        )
    except ArpackNoConvergence:
        return is_positive_definite(mass, "mass")
    return bool(lowest[0] > TOLERANCE)


def mobility(mass: Matrix, directions: Matrix) -> Floats:
    """Return W^T M^-1 W (N_c, N_c) [1/kg]: contact velocity per impulse on the contacts.

    A large mass matrix is factorised only if conjugate gradients do not converge.
    """
    W: Any = as_dense(directions)
    if isinstance(mass, np.ndarray) or mass.shape[0] <= SMALL:
        return np.asarray(W.T @ factorise(mass, "mass").solve(W))
    from scipy.sparse.linalg import cg

    velocity = np.empty_like(W)
    preconditioner = scipy.sparse.diags_array(1.0 / mass.diagonal())
    for column in range(W.shape[1]):
        velocity[:, column], status = cg(mass, W[:, column], rtol=_RESIDUAL, M=preconditioner)
        if status != 0:
            return np.asarray(W.T @ factorise(mass, "mass").solve(W))
    return np.asarray(directions.T @ velocity)
