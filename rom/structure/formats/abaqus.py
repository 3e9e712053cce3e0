"""Abaqus: matrices of *MATRIX GENERATE, in any of the formats of *MATRIX OUTPUT.

FORMAT=MATRIX INPUT and FORMAT=LABELS name nodes and degrees of freedom, FORMAT=COORDINATE has
rows and columns. DOFs that boundary conditions hold have 1E36 on the diagonal.
"""

from __future__ import annotations

from pathlib import Path

from slipmode.rom.structure.formats.triplets import Named, by_index, by_label, read_numbers


def read(path: Path) -> Named:
    """One matrix."""
    numbers = read_numbers(path, (3, 5), "Abaqus matrix file")
    if numbers.shape[1] == 5:
        return by_label(numbers)
    return Named(by_index(numbers[:, 0], numbers[:, 1], numbers[:, 2]))


def mass_beside(path: Path) -> Path:
    """JOB_MASS1.mtx of JOB_STIF2.mtx: what the same job wrote; the file itself if none."""
    stem, separator, _ = path.stem.rpartition("_STIF")
    found = sorted(path.parent.glob(f"{stem}_MASS*.mtx")) if separator else []
    return found[0] if len(found) == 1 else path
