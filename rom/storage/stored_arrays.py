"""Arrays of .npy and .npz files. Sizes are checked before anything is allocated."""

from __future__ import annotations

import os
import zipfile
from math import prod
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.lib.npyio import NpzFile

MIB = 1024 * 1024
# Memory that reading a file may take: so many times the size of the file, which archives that
# slipmode writes do not exceed, but at least this many bytes, for small files that compress well.
FILE_SIZES = 10
LEAST_MEMORY = 256 * MIB

_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def memory_limit(size: int) -> int:
    """Return the bytes that reading a file of so many bytes may allocate.

    The environment variable SLIPMODE_MEMORY_MIB overrides the default.
    """
    given = os.environ.get("SLIPMODE_MEMORY_MIB", "")
    return int(given) * MIB if given.isdecimal() else max(FILE_SIZES * size, LEAST_MEMORY)


def check_unpacked_size(archive: zipfile.ZipFile, size: int) -> None:
    """Raise ValueError if a zip archive of so many bytes unpacks to more than its limit."""
    unpacked, most = sum(entry.file_size for entry in archive.infolist()), memory_limit(size)
    if unpacked > most:
        raise ValueError(
            f"it unpacks to {unpacked / MIB:.0f} MiB, more than {most / MIB:.0f} MiB; if that is "
            f"right, set the environment variable SLIPMODE_MEMORY_MIB={-(-unpacked // MIB)}"
        )


def open_npz(path: Path) -> NpzFile:
    """Open an .npz file whose arrays fit into it, to be closed by the caller.

    Raises OSError or ValueError, or what zipfile raises for damaged files.
    """
    with path.open("rb") as file:
        if not zipfile.is_zipfile(file):
            raise ValueError("it is text, a single array, or damaged")
        with zipfile.ZipFile(file) as archive:
            check_unpacked_size(archive, path.stat().st_size)
            for entry in archive.infolist():
                if entry.filename.endswith(".npy"):
                    with archive.open(entry) as member:
                        _check_header(member, entry.file_size, f"{entry.filename}: ")
    stored: NpzFile = np.load(path, allow_pickle=False)
    return stored


def read_npy(file: IO[bytes], size: int) -> np.ndarray[Any, Any]:
    """Return the array of an .npy file of so many bytes.

    Raises OSError or ValueError for a damaged file.
    """
    _check_header(file, size)
    file.seek(0)
    return npy.read_array(file, allow_pickle=False)


def _check_header(file: IO[bytes], size: int, name: str = "") -> None:
    """Raise ValueError if an .npy file of so many bytes does not contain its array."""
    version = npy.read_magic(file)
    if version not in _HEADERS:
        raise ValueError(f"{name}the version {version} of .npy is not supported")
    shape, _, kind = _HEADERS[version](file)
    fits = kind.hasobject or prod(shape) * kind.itemsize <= size - file.tell()
    if min(shape, default=0) < 0 or not fits:
        raise ValueError(f"{name}an array of shape {shape} is not in {size} bytes")
