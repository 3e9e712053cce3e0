"""Packages that only some commands need: imported when they are wanted."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from slipmode.rom.errors import SlipmodeError


def extra(module: str, name: str) -> Any:
    """Import a module of a package that comes with an extra of slipmode.

    Parameters
    ----------
    module : str
        Like "fmpy" or "matplotlib.figure".
    name : str
        Of the extra.

    Raises
    ------
    SlipmodeError
        If the package is not installed: what to install.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise SlipmodeError(
            f"{(error.name or module).partition('.')[0]} is not installed: "
            f"pip install 'slipmode[{name}]'"
        ) from error


def dataframe(columns: Mapping[str, object]) -> Any:
    """A pandas DataFrame of columns by name."""
    return extra("pandas", "pandas").DataFrame(columns)
