"""Nastran: OUTPUT4 (.op4) and DMIG cards in a punch file (.pch), by pyYeti."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.extras import extra
from slipmode.rom.structure.formats.triplets import Named
from slipmode.rom.structure.labels import Labels

_EXTRA = "nastran"


def read_op4(path: Path) -> dict[str, Any]:
    """Matrices by their names, sparse."""
    op4 = extra("pyyeti.nastran.op4", _EXTRA)
    loaded = op4.OP4().load(str(path), sparse=True)
    return {name: entry[0] for name, entry in loaded.items()}


def read_dmig(path: Path) -> dict[str, Any]:
    """Matrices by their names, with the labels of their rows."""
    bulk = extra("pyyeti.nastran.bulk", _EXTRA)
    found = {}
    for name, frame in bulk.rddmig(str(path), square=True).items():
        pairs = np.array(frame.index.to_list(), dtype=np.int64)
        # Scalar points have component 0: one direction of their own.
        found[name] = Named(frame.to_numpy(), Labels(pairs[:, 0], pairs[:, 1]))
    return found
