"""What a blow does to the contacts before anything else moves: W^T M^-1 W."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import Matrix, as_dense
from slipmode.rom.structure.solvers.factorisation import factorise

_SMALL = 500  # up to here a dense factorisation is the faster one
_BLOCK = 16  # contacts at a time
_ACCURACY = 1e-15  # of the energy that a blow leaves
_PASSES = 500


def mobility(mass: Matrix, directions: Matrix) -> Floats:
    """W^T M^-1 W (N_c, N_c) [1/kg], without factorising a large mass matrix.

    By conjugate gradients with the diagonal as preconditioner: scaled by it, mass matrices of
    elements are near the identity. Where they do not settle, the matrix is factorised after all.
    """
    if isinstance(mass, np.ndarray) or mass.shape[0] <= _SMALL:
        return np.asarray(directions.T @ factorise(mass, "mass").solve(as_dense(directions)))
    W: Any = directions
    found = np.empty((W.shape[1], W.shape[1]))
    for start in range(0, W.shape[1], _BLOCK):
        block = slice(start, start + _BLOCK)
        impulse = as_dense(W[:, block])
        velocity = _conjugate_gradients(mass, impulse)
        if velocity is None:
            return np.asarray(W.T @ factorise(mass, "mass").solve(as_dense(W)))
        found[:, block] = W.T @ velocity
    return found


def _conjugate_gradients(mass: Matrix, impulse: Floats) -> Floats | None:
    """M^-1 impulse (n, columns), all columns at once; None if they do not settle.

    The energy impulse^T M^-1 impulse / 2 grows from pass to pass; what is still to come is about
    what the last pass added.
    """
    inverse = 1.0 / mass.diagonal()[:, np.newaxis]
    velocity, residual = np.zeros_like(impulse), impulse.copy()
    direction = inverse * residual
    power = np.einsum("nk,nk->k", residual, direction)
    gained = np.zeros_like(power)
    for _ in range(_PASSES):
        moved = as_dense(mass @ direction)
        scale = power / np.maximum(np.einsum("nk,nk->k", direction, moved), np.finfo(float).tiny)
        velocity += scale * direction
        residual -= scale * moved
        gained += scale * power
        if np.all(scale * power <= _ACCURACY * gained):
            return velocity
        conditioned = inverse * residual
        before, power = power, np.einsum("nk,nk->k", residual, conditioned)
        ratio = np.divide(power, before, out=np.zeros_like(power), where=before > 0)
        direction = conditioned + ratio * direction
    return None
