"""Structural matrices on disk: one .npz file, or a folder of Matrix Market files."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.files import replacing
from slipmode.rom.storage.stored_arrays import memory_limit
from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.external import read_external
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.readers.abaqus import abaqus_mass_file, read_matrix_market
from slipmode.rom.structure.readers.workspace import CSR_PARTS, read_npz

_NAMES = ("mass", "stiffness", "contact", "damping")


def read_matrices(
    path: Path,
    mass: Path | None = None,
    names: Mapping[str, str] | None = None,
    given: Collection[str] = (),
) -> dict[str, Any]:
    """Read mass, stiffness and, if stored, contact, damping and labels of a file or folder.

    `mass` is the file of the mass, if it is separate, `names` name the matrices in it.
    Parts that are `given` otherwise need not be there. Refusals name the file and the part.
    """
    if path.is_dir() and names:
        raise SlipmodeError(f"names: the files in {path} have fixed names; leave names out")
    if path.is_dir():
        return _read_folder(path, given)
    if not path.exists():
        raise SlipmodeError(f"{path}: no such .npz file or folder of Matrix Market files")
    if path.suffix.lower() == ".npz" and not (mass or names):
        stored = read_npz(path)
        if isinstance(stored, dict) and "mass" in stored and "stiffness" in stored:
            return _own(stored, path)
    return read_external(path, mass, names or {}, given)


def write_npz(path: Path, matrices: Mapping[str, Any]) -> None:
    """Write dense arrays as they are and sparse matrices as CSR parts."""
    if path.suffix != ".npz":
        raise SlipmodeError(f"{path}: the name of a structure file must end in .npz")
    arrays: dict[str, Any] = {}
    for name, matrix in matrices.items():
        if isinstance(matrix, np.ndarray | float):
            arrays[name] = matrix
        else:
            rows = scipy.sparse.csr_array(matrix)
            arrays |= {f"{name}_{part}": getattr(rows, part) for part in CSR_PARTS}
    try:
        with replacing(path) as file:
            np.savez_compressed(file, **arrays)
            size = sum(np.asarray(each).nbytes for each in arrays.values())
            if size > memory_limit(file.tell()):
                file.seek(0)
                file.truncate()
                np.savez(file, **arrays)  # dense matrices of zeros, which would not be read
    except OSError as error:
        raise SlipmodeError(f"{path}: cannot be written: {error.strerror}") from error


def source_files(path: Path) -> list[Path]:
    """Return the existing files that `load_structure` may read for a path, sorted.

    These are the file, of matrices or of a mass, and the other files of the same job; or the
    matrix files of a folder.
    """
    if path.is_dir():
        candidates = {path / f"{name}{ending}" for name in _NAMES for ending in (".mtx", ".txt")}
    else:
        candidates = {path, abaqus_mass_file(path)}
        if path.suffix.lower() in (".sti", ".mas"):
            candidates |= {path.with_suffix(ending) for ending in (".mas", ".dof")}
    return sorted(file for file in candidates if file.is_file())


def _own(stored: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Return the matrices that `write_npz` wrote."""
    matrices = {name: stored[name] for name in _NAMES if name in stored}
    for name, matrix in matrices.items():
        if matrix is None:
            raise SlipmodeError(f"{path}: {name} is damaged or not a plain array")
    if "labels" in stored:
        table = stored["labels"]
        if np.ndim(table) != 2 or table.shape[1] != 2 or table.dtype.kind not in "iu":
            raise SlipmodeError(f"{path}: labels must be (n, 2) integers: node, direction")
        matrices["labels"] = Labels(*table.T.astype(np.int64))
    return matrices


def _read_folder(folder: Path, given: Collection[str]) -> dict[str, Any]:
    matrices = {}
    for name in _NAMES:
        endings = (".mtx", ".txt") if name == "contact" else (".mtx",)
        files = [folder / f"{name}{ending}" for ending in endings]
        present = [file for file in files if file.is_file()]
        if len(present) > 1:
            raise SlipmodeError(f"{folder}: give one of contact.mtx and contact.txt, not both")
        if present:
            matrices[name] = _read_part(present[0])
        elif name != "damping" and name not in given:
            names = " or ".join(file.name for file in files)
            raise SlipmodeError(f"{folder}: {names} is missing")
    return matrices


def _read_part(file: Path) -> Any:
    """Return a Matrix Market matrix, or the integers of a text file."""
    try:
        if file.suffix == ".txt":
            return np.loadtxt(StringIO(read_text(file)), dtype=np.intp, ndmin=1)
        return read_matrix_market(file)
    except Exception as error:
        wanted = "integers" if file.suffix == ".txt" else "a matrix of Matrix Market"
        raise SlipmodeError(f"{file}: cannot be read; must have {wanted}") from error
