"""What takes long about a large structure, kept on disk: its static state, its reduction.

Kept where friction tables are, under a hash of all that it depends on.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.static_preload import Preload, preload
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.files import replacing
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.law_record import law_of, record_of
from slipmode.rom.reduction.reduction import (
    SMALLEST_RESPONSE,
    Formulation,
    Reduced,
    reduce,
)
from slipmode.rom.structure.structure import Structure
from slipmode.rom.table import disk_cache
from slipmode.rom.table.model import OPTIONAL_ARRAYS, REDUCED_ARRAYS

LARGE = 10_000  # DOFs, from which the work takes longer than finding it again

_STATE = ("displacement", "contact_force", "state", "normal_force", "gap", "tangential_share")
_LAW = "law"
_DAMAGED = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, SlipmodeError)

Arrays = Mapping[str, np.ndarray]
Result = TypeVar("Result")


def kept_preload(structure: Structure, law: Elastic, force: Floats) -> Preload:
    """`rom.preload` without warnings; of large structures it is looked for on disk first."""

    def made() -> Preload:
        return preload(structure, law, force, warned=False)

    def arrays(found: Preload) -> Arrays:
        record = np.array(json.dumps(record_of(found.law)))
        return {_LAW: record} | {name: getattr(found, name) for name in _STATE}

    def read(stored: Arrays) -> Preload:
        loaded: Any = law_of(json.loads(str(stored[_LAW])))
        return Preload(loaded, **{name: stored[name] for name in _STATE})

    if structure.n_dofs < LARGE:
        return made()
    return _kept(_key(structure, "preload", record_of(law), force), made, arrays, read)


def kept_reduction(
    structure: Structure,
    modes: Sequence[int],
    formulation: Formulation,
    law: Elastic | None,
    aerodynamics: Sequence[complex] | None,
    smallest_response: float = SMALLEST_RESPONSE,
    *,
    progress: bool = False,
) -> Reduced:
    """`rom.reduce` without warnings; of large structures it is looked for on disk first."""
    elements = None if law is None else law.elements(structure.n_contacts)

    def made() -> Reduced:
        return reduce(
            *(structure, modes, formulation),
            law=law,
            aerodynamics=aerodynamics,
            smallest_response=smallest_response,
            warned=False,
            progress=progress,
        )

    def arrays(found: Reduced) -> Arrays:
        values = {name: getattr(found, name) for name in (*REDUCED_ARRAYS, *OPTIONAL_ARRAYS)}
        return {name: value for name, value in values.items() if value is not None}

    def read(stored: Arrays) -> Reduced:
        chosen = tuple(int(mode) for mode in modes)
        return Reduced(formulation=formulation, modes=chosen, contacts=elements, **stored)

    if structure.n_dofs < LARGE:
        return made()
    record = None if law is None else record_of(law)
    forces = None if aerodynamics is None else [[c.real, c.imag] for c in aerodynamics]
    said = ["reduction", list(modes), formulation, record, forces, smallest_response]
    return _kept(_key(structure, *said), made, arrays, read)


def _kept(
    key: str,
    made: Callable[[], Result],
    arrays: Callable[[Result], Arrays],
    read: Callable[[Arrays], Result],
) -> Result:
    """What is kept under a key, or else made, and kept; the same to the last bit either way."""
    name = f"{key}.npz"

    def load(path: Path) -> Result:
        try:
            with np.load(path, allow_pickle=False) as stored:
                return read({each: stored[each] for each in stored.files})
        except _DAMAGED as error:
            raise SlipmodeError(f"{path}: is damaged: {error}") from error

    def save(path: Path) -> None:
        with replacing(path) as file:
            np.savez(file, **content)  # type: ignore[arg-type]  # of names like arrays

    found = disk_cache.find(name, load)
    if found is not None:
        return found
    # in the order of files: sums over other layouts are rounded differently
    content = {each: np.asarray(array, order="C") for each, array in arrays(made()).items()}
    disk_cache.keep(name, save)
    return read(content)


def _key(structure: Structure, *said: Any) -> str:
    """Hash of a structure and of what is asked of it: plain values and arrays."""
    digest = hashlib.sha256(version("slipmode").encode())
    matrices = (structure.mass, structure.stiffness, structure.damping, structure.directions)
    for each in (*matrices, *said):
        parts: list[Any] = [each]
        if scipy.sparse.issparse(each):
            whole: Any = each
            parts = [whole.indptr, whole.indices, whole.data]
        for part in parts:
            if isinstance(part, np.ndarray):
                digest.update(f"{part.dtype} {part.shape}".encode())
                digest.update(np.ascontiguousarray(part).data)
            else:
                digest.update(json.dumps(part).encode())
    return digest.hexdigest()[:32]
