"""Ansys: the assembled matrices of a .full file, by PyMAPDL Reader."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.extras import extra
from slipmode.rom.structure.formats.triplets import Named, mirrored
from slipmode.rom.structure.labels import Labels


def read_full(path: Path) -> dict[str, Any]:
    """Stiffness and, where the analysis has one, mass, without the DOFs that are held."""
    reader = extra("ansys.mapdl.reader.full", "ansys")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a missing matrix: said by who asked for it
        pairs, *matrices = reader.FullFile(str(path)).load_km()
    found = {}
    for name, half in zip(("stiffness", "mass"), matrices, strict=True):
        if half is not None:
            whole = mirrored(half)
            free = np.flatnonzero(matrices[0].diagonal())
            node, direction = pairs[free].astype(np.int64).T
            labels = Labels(node, direction + 1)  # x is 0 there
            found[name] = Named(whole[free][:, free], labels)
    return found
