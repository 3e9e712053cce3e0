"""The reader of each suffix, and refusals of what it cannot read."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.readers.abaqus import read_calculix, read_mtx
from slipmode.rom.structure.readers.dmig import read_dmig
from slipmode.rom.structure.readers.harwell_boeing import read_harwell_boeing
from slipmode.rom.structure.readers.named import Named, mirrored
from slipmode.rom.structure.readers.op4 import read_op4
from slipmode.rom.structure.readers.text import DamagedError
from slipmode.rom.structure.readers.workspace import read_mat, read_npy, read_npz

Found = Named | dict[str, Any]


def read_matrix_file(path: Path) -> Found:
    """Return one matrix, or several by the names that the file gives them."""
    reader, kind = READERS.get(path.suffix.lower(), (None, ""))
    if reader is None:
        raise SlipmodeError(f"{path}: must end in {', '.join(READERS)}, or be a folder")
    if not path.is_file():
        raise SlipmodeError(f"{path}: no such file")
    try:
        return reader(path)
    except SlipmodeError:
        raise
    except Exception as error:  # damaged files make parsers raise nearly anything
        reason = f" ({error})" if isinstance(error, DamagedError) else ""
        raise SlipmodeError(
            f"{path}: is damaged or not a {kind}{reason}; write the file again"
        ) from error


def _read_full(path: Path) -> dict[str, Any]:
    """Stiffness and mass of an Ansys .full file without its held DOFs, by PyMAPDL Reader."""
    reader = extra("ansys.mapdl.reader.full", "ansys")
    # Words 127 and 128 are the length of the file in words of 4 bytes, low word first (Ansys'
    # fdfull.inc). The reader would read past the end of a shorter file.
    ends = np.fromfile(path, "<u4", 129)[127:]
    if ends.size < 2 or path.stat().st_size < 4 * (int(ends[0]) + (int(ends[1]) << 32)):
        raise SlipmodeError(f"{path}: is incomplete, or not a .full file of Ansys")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a missing matrix: read_external refuses it
        pairs, stiffness, mass = reader.FullFile(str(path)).load_km()
    if stiffness is None:
        return {}
    free = np.flatnonzero(stiffness.diagonal())
    node, direction = pairs[free].astype(np.int64).T
    labels = Labels(node, direction + 1)  # x is 0 there
    return {
        name: Named(mirrored(half)[free][:, free], labels)
        for name, half in (("stiffness", stiffness), ("mass", mass))
        if half is not None
    }


READERS: dict[str, tuple[Callable[[Path], Found], str]] = {
    ".mtx": (read_mtx, "Matrix Market or Abaqus file"),
    ".sti": (read_calculix, "CalculiX matrix file"),
    ".mas": (read_calculix, "CalculiX matrix file"),
    ".hb": (read_harwell_boeing, "Harwell-Boeing file"),
    ".rsa": (read_harwell_boeing, "Harwell-Boeing file"),
    ".rua": (read_harwell_boeing, "Harwell-Boeing file"),
    ".matrix": (read_harwell_boeing, "Harwell-Boeing file"),
    ".npy": (read_npy, ".npy file"),
    ".npz": (read_npz, ".npz file"),
    ".mat": (read_mat, "MATLAB file"),
    ".op4": (read_op4, "Nastran OUTPUT4 file"),
    ".pch": (read_dmig, "Nastran punch file with DMIG cards"),
    ".full": (_read_full, ".full file of Ansys"),
}
