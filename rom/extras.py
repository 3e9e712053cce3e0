"""Packages of extras, imported when a command needs them."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from slipmode.rom.errors import SlipmodeError


def extra(module: str, name: str) -> Any:
    """Return a module of a package in the extra `name`; refuse if it is not installed."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise SlipmodeError(
            f"{(error.name or module).partition('.')[0]} is not installed: "
            f"pip install 'slipmode[{name}]'"
        ) from error


def dataframe(columns: Mapping[str, object]) -> Any:
    """Return a pandas DataFrame of columns by name."""
    return extra("pandas", "pandas").DataFrame(columns)
