"""Models of travelling waves kept on disk, in the cache of friction tables."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Complexes
from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave, tabulate_waves
from slipmode.rom.laws.law_record import record_of
from slipmode.rom.table import disk_cache
from slipmode.rom.table.model import FORMAT, Model


def cached_waves(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Complexes],
    tolerance: float,
) -> tuple[Model, bool]:
    """Return the model of one or two waves, and whether the cache had it already.

    Parameters are those of `tabulate_waves`.
    """
    name = f"{_key(waves, amplitude, force, tolerance)}.rom"
    found = disk_cache.find(name, Model.load)
    if found is not None:
        return found, True
    if len(waves) == 1:
        model = waves[0].tabulate(amplitude[0], force[0], tolerance)
    else:
        model = tabulate_waves(waves, amplitude, force, tolerance)
    disk_cache.keep(name, model.save)
    return model, False


def _key(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Complexes],
    tolerance: float,
) -> str:
    """Return a hash of everything that the model depends on."""
    structure = waves[0].structure
    numbers = [[each.nodal_diameter, each.wave.mode] for each in waves]
    named = [FORMAT, version("slipmode"), "waves", structure.sectors, record_of(waves[0].law)]
    digest = hashlib.sha256(json.dumps([*named, numbers, list(amplitude), tolerance]).encode())
    matrices = (structure.mass, structure.stiffness, structure.damping)
    directions = (structure.own_directions, structure.next_directions)
    arrays: list[Any] = [structure.left, structure.right, *force]
    for matrix in map(scipy.sparse.csc_array, (*matrices, *directions)):
        arrays += [matrix.indptr, matrix.indices, matrix.data]
    for array in arrays:
        digest.update(f"{array.dtype} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()[:32]
