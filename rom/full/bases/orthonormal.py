"""Modes and other shapes combined into a basis that is orthonormal in the mass."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats

_DEPENDENT = 1e-10  # squared part of a unit shape that is its own, below which it is rounding


def orthonormal(inertia: Floats, mass: Floats) -> Floats:
    """Combinations T of modes Phi, Phi^T M Phi = I, and shapes X: [Phi X] T is orthonormal.

    Parameters
    ----------
    inertia : (modes, shapes) ndarray
        Phi^T M X.
    mass : (shapes, shapes) ndarray
        X^T M X.

    Returns
    -------
    (modes + shapes, coordinates) ndarray
        The modes as they are, then what shapes have besides, where that is more than rounding.
    """
    modes, shapes = inertia.shape
    scale = np.sqrt(np.maximum(np.diag(mass), np.finfo(float).tiny))
    size, mixed = np.linalg.eigh((mass - inertia.T @ inertia) / np.outer(scale, scale))
    own = size > _DEPENDENT
    others = mixed[:, own] / np.sqrt(size[own]) / scale[:, np.newaxis]
    return np.block([[np.eye(modes), -inertia @ others], [np.zeros((shapes, modes)), others]])
