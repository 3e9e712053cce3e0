"""The files on disk that `load_structure` reads."""

from __future__ import annotations

from pathlib import Path

from slipmode.rom.structure.files import OPTIONAL, REQUIRED
from slipmode.rom.structure.formats import abaqus

_FOLDER_ENDINGS = (".mtx", ".txt")
_CALCULIX_ENDINGS = (".mas", ".dof")


def source_files(path: Path) -> list[Path]:
    """Return the existing files that `load_structure` may read for a path, sorted.

    Parameters
    ----------
    path : Path
        A file or folder of matrices, or the file of a mass.

    Returns
    -------
    list of Path
        The file, and the files of the same job beside it; of a folder, its matrix files.
    """
    if path.is_dir():
        names = (*REQUIRED, *OPTIONAL)
        candidates = {path / f"{name}{ending}" for name in names for ending in _FOLDER_ENDINGS}
    else:
        candidates = {path, abaqus.mass_beside(path)}
        if path.suffix in (".sti", ".mas"):
            candidates |= {path.with_suffix(ending) for ending in _CALCULIX_ENDINGS}
    return sorted(file for file in candidates if file.is_file())
