"""Ansys: the assembled matrices of a .full file, by PyMAPDL Reader."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.structure.formats.triplets import Named, mirrored
from slipmode.rom.structure.labels import Labels

_WORD = 4  # bytes
_ENDS = slice(127, 129)  # words that say where the file ends, low one first (Ansys' fdfull.inc)


def read_full(path: Path) -> dict[str, Any]:
    """Stiffness and, where the analysis has one, mass, without the DOFs that are held.

    Raises
    ------
    SlipmodeError
        If the file is shorter than it says: the reader would go on past its end.
    """
    reader = extra("ansys.mapdl.reader.full", "ansys")
    ends = np.fromfile(path, "<u4", _ENDS.stop)[_ENDS]
    if ends.size < 2 or path.stat().st_size < _WORD * (int(ends[0]) + (int(ends[1]) << 32)):
        raise SlipmodeError(f"{path}: is damaged, or no .full file of Ansys: it ends too early")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a missing matrix: said by who asked for it
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
