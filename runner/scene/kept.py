"""Static state and reduction of large structures, stored on disk because they take long.

They are in the cache of friction tables, under a hash of everything that they depend on.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast
from zipfile import BadZipFile

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.rest.static_preload import Preload, preload
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.law_record import law_of, record_of
from slipmode.rom.reduction.reduced import REDUCED_ARRAYS
from slipmode.rom.reduction.reduction import Formulation, Reduced, reduce
from slipmode.rom.storage.code_digest import code_digest
from slipmode.rom.storage.files import replacing
from slipmode.rom.structure.structure import Structure
from slipmode.rom.table import disk_cache
from slipmode.rom.table.model import OPTIONAL_ARRAYS

LARGE = 10_000  # DOFs from which the work takes longer than to read its result from disk

_STATE = ("displacement", "contact_force", "state", "normal_force", "gap", "tangential_share")

Arrays = Mapping[str, np.ndarray]
Result = TypeVar("Result")


def kept_preload(structure: Structure, law: Elastic, force: Floats) -> Preload:
    """Return `rom.preload` without its warnings, from disk if the structure is large."""
    if structure.n_dofs < LARGE:
        return preload(structure, law, force, warned=False)

    def compute() -> Arrays:
        found = preload(structure, law, force, warned=False)
        record = np.array(json.dumps(record_of(found.law)))
        return {"law": record} | {name: getattr(found, name) for name in _STATE}

    def read(stored: Arrays) -> Preload:
        loaded: Any = law_of(json.loads(str(stored["law"])))
        return Preload(loaded, **{name: stored[name] for name in _STATE})

    return _kept(_key(structure, "preload", record_of(law), force), compute, read)


def kept_reduction(
    structure: Structure,
    modes: Sequence[int],
    formulation: Formulation,
    law: Elastic | None,
    aerodynamics: Sequence[complex] | None,
    *,
    tones: tuple[int, ...] = (),
    progress: bool = False,
) -> Reduced:
    """Return `rom.reduce` without its warnings, from disk if the structure is large."""
    options: dict[str, Any] = {"law": law, "aerodynamics": aerodynamics, "progress": progress}
    options["tones"] = tones or None
    if structure.n_dofs < LARGE:
        return reduce(structure, modes, formulation, warned=False, **options)
    elements = None if law is None else law.elements(structure.n_contacts)

    def compute() -> Arrays:
        found = reduce(structure, modes, formulation, warned=False, **options)
        values = {name: getattr(found, name) for name in (*REDUCED_ARRAYS, *OPTIONAL_ARRAYS)}
        return {name: value for name, value in values.items() if value is not None}

    def read(stored: Arrays) -> Reduced:
        chosen = tuple(int(mode) for mode in modes)
        return Reduced(
            formulation=formulation,
            modes=chosen,
            contacts=elements,
            structure=structure,
            tone_numbers=tones,
            **cast(Any, stored),
        )

    record = None if law is None else record_of(law)
    coefficients = None if aerodynamics is None else [[c.real, c.imag] for c in aerodynamics]
    key = _key(structure, "reduction", list(modes), formulation, record, coefficients, tones)
    return _kept(key, compute, read)


def _kept(key: str, compute: Callable[[], Arrays], read: Callable[[Arrays], Result]) -> Result:
    """Return the result stored under a key, or compute and store it; the same bits either way."""
    name = f"{key}.npz"

    damaged = (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile, SlipmodeError)

    def load(path: Path) -> Result:
        try:
            with np.load(path, allow_pickle=False) as stored:
                return read({each: stored[each] for each in stored.files})
        except damaged as error:
            raise SlipmodeError(f"{path}: is damaged: {error}") from error

    def save(path: Path) -> None:
        with replacing(path) as file:
            np.savez(file, **content)  # type: ignore[arg-type]  # names are arrays only

    found = disk_cache.find(name, load)
    if found is not None:
        return found
    # files have C order, and sums over another layout would be rounded differently
    content = {each: np.asarray(array, order="C") for each, array in compute().items()}
    disk_cache.keep(name, save)
    return read(content)


def _key(structure: Structure, *others: Any) -> str:
    """Return a hash of a structure and of plain values and arrays."""
    digest = hashlib.sha256(code_digest("slipmode.rom").encode())
    matrices = (structure.mass, structure.stiffness, structure.damping, structure.directions)
    for each in (*matrices, structure.loss, *others):
        sparse = scipy.sparse.issparse(each)
        for part in (each.indptr, each.indices, each.data) if sparse else (each,):
            if isinstance(part, np.ndarray):
                digest.update(f"{part.dtype} {part.shape}".encode())
                digest.update(np.ascontiguousarray(part).data)
            else:
                digest.update(json.dumps(part).encode())
    return digest.hexdigest()[:32]
