"""Models of travelling waves kept on disk, in the cache of friction tables."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave.wave_motion import SectorWaves
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.laws.law_record import record_of
from slipmode.rom.storage.code_digest import code_digest
from slipmode.rom.table import disk_cache
from slipmode.rom.table.model import FORMAT, Model


def cached_waves(
    structure: CyclicStructure, sector: SectorWaves, amplitude: Sequence[float], tolerance: float
) -> tuple[Model, bool]:
    """Return the model of waves up to |a| (modes,), and whether the cache had it already."""
    name = f"{_key(structure, sector, amplitude, tolerance)}.rom"
    found = disk_cache.find(name, Model.load)
    if found is not None:
        return found, True
    model = wave_model(sector.carriers, sector.law, np.array(amplitude), tolerance)
    disk_cache.keep(name, model.save)
    return model, False


def _key(
    structure: CyclicStructure, sector: SectorWaves, amplitude: Sequence[float], tolerance: float
) -> str:
    """Return a hash of everything that the model depends on."""
    waves = [[c.wave.nodal_diameter, c.wave.mode, c.frequency] for c in sector.carriers]
    code = code_digest("slipmode.rom")
    named = [FORMAT, code, "waves", structure.sectors, record_of(sector.law)]
    digest = hashlib.sha256(json.dumps([*named, waves, list(amplitude), tolerance]).encode())
    force = [each.force for each in sector.carriers]
    matrices = (structure.mass, structure.stiffness, structure.damping)
    directions = (structure.own_directions, structure.next_directions)
    arrays: list[Any] = [structure.left, structure.right, *force]
    for matrix in map(scipy.sparse.csc_array, (*matrices, *directions)):
        arrays += [matrix.indptr, matrix.indices, matrix.data]
    for array in arrays:
        digest.update(f"{array.dtype} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()[:32]
