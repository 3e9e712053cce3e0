"""Contacts divided into patches of about the same area."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.pairing.facets import Indices


def patch_of(patches: int | ArrayLike, position: Floats, area: Floats) -> Indices:
    """The patch of each contact, (contacts,), numbered from 0; as given, or by bisection."""
    given: Any = np.asarray(patches)
    if given.dtype.kind not in "iu" or given.ndim > 1:
        raise SlipmodeError("patches: must be a number of patches, or an integer per contact")
    if given.ndim == 0:
        if not 1 <= given <= len(area):
            raise SlipmodeError(
                f"patches: must be 1 to {len(area)}, the number of contacts, got {given}"
            )
        return _bisected(int(given), position, area)
    if given.size != len(area):
        raise SlipmodeError(
            f"patches: needs an integer for each of {len(area)} contacts, got {given.size}"
        )
    return np.asarray(np.unique(given, return_inverse=True)[1], dtype=np.intp)


def _bisected(count: int, position: Floats, area: Floats) -> Indices:
    """Halved across the longest global axis, again and again."""
    patch = np.zeros(len(area), dtype=np.intp)
    parts = [(np.arange(len(area)), 0, count)]
    while parts:
        own, first, wanted = parts.pop()
        patch[own] = first
        if wanted == 1:
            continue
        half = wanted // 2
        axis = np.argmax(np.ptp(position[own], axis=0))
        own = own[np.argsort(position[own, axis], kind="stable")]
        filled = np.cumsum(area[own])
        middle = 1 + int(np.argmin(np.abs(filled - half / wanted * filled[-1])))
        middle = min(max(middle, half), len(own) - (wanted - half))
        parts += [(own[:middle], first, half), (own[middle:], first + half, wanted - half)]
    return patch
