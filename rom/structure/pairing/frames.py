"""Local frames of contacts: two tangents and the normal, orthonormal and right-handed."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats

_ALONG = 0.1  # of a direction, what must lie across a normal to give a tangent


def local_frames(normals: Floats, tangent: Floats | None = None) -> Floats:
    """Rows t_1, t_2, n of each contact, (contacts, 3, 3), of unit normals (contacts, 3).

    t_1 is the direction `tangent`, (3,) or one per contact, as it lies across the normal. Without,
    it is that of one global axis for all contacts: x, unless y or z is at least twice as far from
    every normal. Where a normal is along that direction, the global axis farthest from it.
    """
    axes = np.eye(3)
    across = np.sqrt(np.maximum(1.0 - normals**2, 0.0))  # of each global axis, at each contact
    if tangent is None:
        least = across.min(axis=0)
        tangent = axes[np.argmax(least >= 0.5 * least.max())]
    t_1 = (
        tangent
        - np.einsum("kx,kx->k", normals, np.broadcast_to(tangent, normals.shape))[:, np.newaxis]
        * normals
    )
    along = np.linalg.norm(t_1, axis=1) < _ALONG * np.linalg.norm(tangent, axis=-1)
    if along.any():
        other, n = axes[np.argmax(across[along], axis=1)], normals[along]
        t_1[along] = other - np.einsum("kx,kx->k", other, n)[:, np.newaxis] * n
    t_1 /= np.linalg.norm(t_1, axis=1)[:, np.newaxis]
    return np.stack((t_1, np.cross(normals, t_1), normals), axis=1)
