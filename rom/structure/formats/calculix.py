"""CalculiX: job.sti, job.mas and job.dof of *FREQUENCY, SOLVER=MATRIXSTORAGE."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.formats.triplets import Named, by_index
from slipmode.rom.structure.formats.triplets import read_numbers as rows_of
from slipmode.rom.structure.labels import Labels


def read(path: Path) -> Named:
    """One matrix; its labels are in the .dof file beside it."""
    numbers = rows_of(path, (3,), "CalculiX matrix file")
    beside = path.with_suffix(".dof")
    labels = _labels(beside) if beside.is_file() else None
    size = 0 if labels is None else labels.node.size
    matrix = by_index(numbers[:, 0], numbers[:, 1], numbers[:, 2], size)
    if labels is not None and matrix.shape[0] != size:
        raise SlipmodeError(f"{path}: has {matrix.shape[0]} DOFs, {beside.name} names {size}")
    return Named(matrix, labels)


def _labels(path: Path) -> Labels:
    """Lines NODE.DIRECTION."""
    words = path.read_text(encoding="ascii").split()
    try:
        pairs = np.array([word.split(".") for word in words], dtype=np.int64)
    except ValueError as error:
        raise SlipmodeError(f"{path}: is damaged: lines must be NODE.DIRECTION") from error
    return Labels(pairs[:, 0], pairs[:, 1])
