"""MATLAB .mat files (not those of -v7.3)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from slipmode.rom.errors import SlipmodeError


def read(path: Path) -> dict[str, Any]:
    """Variables by their names."""
    from scipy.io import loadmat

    try:
        return {name: value for name, value in loadmat(path).items() if name[:2] != "__"}
    except NotImplementedError as error:
        raise SlipmodeError(f"{path}: is of MATLAB's -v7.3; save it with -v7") from error
