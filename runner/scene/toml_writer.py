"""Parsed TOML back as text."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from slipmode.runner.scene.toml_table import quoted


def toml_text(content: Mapping[str, Any]) -> str:
    """Return a document that reads as `content`: strings, numbers, booleans, lists and tables."""
    return "\n".join(_lines(content, "")).strip() + "\n"


def _lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    """Yield values first: all that follows a header belongs to its table."""
    below = []
    for key, value in table.items():
        if isinstance(value, Mapping) or _is_array_of_tables(value):
            below.append((f"{path}{quoted(key)}", value))
        else:
            yield f"{quoted(key)} = {_value(value)}"
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
