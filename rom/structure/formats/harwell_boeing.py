"""Harwell-Boeing files, as Ansys writes them (HBMAT)."""

from __future__ import annotations

from pathlib import Path

from slipmode.rom.structure.formats.triplets import Named, mirrored


def read(path: Path) -> Named:
    """One matrix; files of symmetric ones have one triangle."""
    from scipy.io import hb_read

    return Named(mirrored(hb_read(path, spmatrix=False)))
