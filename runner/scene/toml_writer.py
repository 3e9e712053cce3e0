"""Parsed TOML back as text."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(content: Mapping[str, Any]) -> str:
    """A document that reads as `content`: strings, numbers, booleans, lists and tables."""
    return "\n".join(_lines(content, "")).strip() + "\n"


def _lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    """Values first, for what follows a header belongs to it."""
    below = []
    for key, value in table.items():
        name = key if _BARE.fullmatch(key) else json.dumps(key)
        if isinstance(value, Mapping) or _is_array_of_tables(value):
            below.append((f"{path}{name}", value))
        else:
            yield f"{name} = {_value(value)}"
    for name, value in below:
        tables = [value] if isinstance(value, Mapping) else value
        for each in tables:
            yield f"\n[{name}]" if isinstance(value, Mapping) else f"\n[[{name}]]"
            yield from _lines(each, f"{name}.")


def _is_array_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value) if isinstance(value, float) else json.dumps(value, default=str)
