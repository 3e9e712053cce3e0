"""Describing functions: complex stiffness of contacts under harmonic motion.

A Jenkins element of stiffness k that slips at the displacement phi = limit / k has, under
x = X cos(nu t) with c = phi / X < 1 and cos(theta) = 1 - 2 c, the force Re(N x exp(i nu t)) with

    N = k (theta - sin(2 theta) / 2 + 4 i c (1 - c)) / pi,

and N = k in stick. Elements in parallel add up.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.common import Complexes, Floats


def describing_function(
    limit: Floats, stiffness: Floats, amplitude: Floats
) -> tuple[Complexes, Complexes]:
    """Return the stiffness N of parallel Jenkins elements and dN / d(log X), both (...).

    `limit` [N] and `stiffness` [N/m] are (..., sliders), `amplitude` X > 0 (...) [m].
    """
    c = np.minimum((limit / stiffness) / amplitude[..., np.newaxis], 1.0)
    square = c * (1.0 - c)
    half_sine = np.sqrt(square)
    spring = 2.0 * np.arcsin(np.sqrt(c)) - 2.0 * half_sine * (1.0 - 2.0 * c)
    # Derivatives by log c; in stick both terms are constant.
    slips = c < 1.0
    of_spring, of_loss = 8.0 * c * half_sine, 4.0 * c * (1.0 - 2.0 * c) * slips
    k = stiffness / np.pi
    N = np.sum(k * spring, axis=-1) + 4j * np.sum(k * square, axis=-1)
    return N, -np.sum(k * of_spring, axis=-1) - 1j * np.sum(k * of_loss, axis=-1)
