"""Structural matrices on disk: one .npz file, or a folder of Matrix Market files."""

from __future__ import annotations

from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.formats import abaqus_mass_file, read_matrix_market
from slipmode.rom.structure.labels import Labels
from slipmode.rom.text import read_text

_REQUIRED = ("mass", "stiffness", "contact")
_NAMES = (*_REQUIRED, "damping")

#: A sparse matrix `mass` is stored in compressed sparse rows as mass_data, mass_indices, ...
_CSR_PARTS = ("data", "indices", "indptr", "shape")


def read_matrices(path: Path) -> dict[str, Any]:
    """Read mass, stiffness, contact and, if stored, damping and labels of a file or folder.

    Damaged files make zipfile, zlib, numpy and scipy raise nearly anything; refusals name the file
    and the part.
    """
    if path.is_dir():
        return _read_folder(path)
    if path.is_file():
        return _read_npz(path)
    raise SlipmodeError(f"{path}: no such .npz file or folder of Matrix Market files")


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
            arrays |= {f"{name}_{part}": getattr(rows, part) for part in _CSR_PARTS}
    try:
        np.savez_compressed(path, **arrays)
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
        if path.suffix in (".sti", ".mas"):
            candidates |= {path.with_suffix(ending) for ending in (".mas", ".dof")}
    return sorted(file for file in candidates if file.is_file())


def _read_npz(path: Path) -> dict[str, Any]:
    try:
        stored = np.load(path, allow_pickle=False)
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable .npz file") from error
    if not isinstance(stored, np.lib.npyio.NpzFile):
        raise SlipmodeError(f"{path}: holds a single array; must be a .npz file")
    with stored:
        matrices = {}
        for name in _NAMES:
            try:
                matrix = _read_npz_matrix(stored, name)
            except Exception as error:
                raise SlipmodeError(f"{path}: {name} is damaged or not a plain array") from error
            if matrix is not None:
                matrices[name] = matrix
            elif name in _REQUIRED:
                raise SlipmodeError(f"{path}: key {name} is missing (sparse: {name}_data, ...)")
        if "labels" in stored:
            table = stored["labels"]
            if table.ndim != 2 or table.shape[1] != 2 or table.dtype.kind not in "iu":
                raise SlipmodeError(f"{path}: labels must be (n, 2) integers: node, direction")
            matrices["labels"] = Labels(*table.T.astype(np.int64))
        return matrices


def _read_npz_matrix(stored: Mapping[str, Any], name: str) -> Any:
    """Return a stored matrix or number; None if there is none."""
    if name in stored:
        array = stored[name]
        return array if array.ndim else array.item()
    parts = [f"{name}_{part}" for part in _CSR_PARTS]
    if not all(part in stored for part in parts):
        return None
    data, indices, indptr, shape = (stored[part] for part in parts)
    matrix: Any = scipy.sparse.csr_array((data, indices, indptr), shape=tuple(shape))
    matrix.check_format(full_check=True)  # indices out of range would read foreign memory
    return matrix


def _read_folder(folder: Path) -> dict[str, Any]:
    matrices = {}
    for name in _NAMES:
        endings = (".mtx", ".txt") if name == "contact" else (".mtx",)
        files = [folder / f"{name}{ending}" for ending in endings]
        present = [file for file in files if file.is_file()]
        if len(present) > 1:
            raise SlipmodeError(f"{folder}: give one of contact.mtx and contact.txt, not both")
        if present:
            matrices[name] = _read_part(present[0])
        elif name in _REQUIRED:
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
        raise SlipmodeError(f"{file}: cannot be read: {' '.join(str(error).split())}") from error
