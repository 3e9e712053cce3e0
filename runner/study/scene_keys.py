"""Keys of a scene by dotted paths, "forcing.A.amplitude" or "contacts.0.preload"."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Any, cast

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.channels import MODES
from slipmode.runner.scene.contacts import CONTACTS
from slipmode.runner.scene.reference import scene_reference
from slipmode.runner.scene.scene import FORCING, SECTIONS, WINDOW

Content = dict[str, Any]

_ARRAYS = {"contacts": CONTACTS, "contact": WINDOW, "elastic": WINDOW}
_OF_LOADS = ("amplitude", "frequency", "phase")


def check_key(name: str, key: str, content: Content) -> None:
    """Refuse a key that scenes do not have, or of a group that this one does not have.

    Parameters
    ----------
    name : str
        What the refusal is of: "vary[0].key".
    key : str
    content : dict
        The scene, as parsed.

    Raises
    ------
    SlipmodeError
        With the names that are allowed where it goes wrong.
    """
    parts = key.split(".")
    first, rest = parts[0], list(parts[1:])
    _one_of(name, key, first, ["title", *_ARRAYS, *SECTIONS])
    if first == "title":
        _end(name, key, rest)
        return
    if first in _ARRAYS:
        count = len(content.get(first, []))
        rest = _element(name, key, rest, count, f"[[{first}]]")
    elif first == "forcing":
        _one_of(name, key, rest[0] if rest else "", MODES)
        rest = rest[1:]
    names = _ARRAYS.get(first) or (FORCING if first == "forcing" else SECTIONS[first])
    _one_of(name, key, rest[0] if rest else "", names)
    if rest[1:]:
        values = get(content, key.rpartition(".")[0])
        count = len(values) if isinstance(values, list) else 0
        _end(name, key, _element(name, key, rest[1:], count, "values of the scene"))


def get(content: Content, key: str) -> Any:
    """The value of a key; None if the scene leaves it out."""
    found: Any = content
    for part in key.split("."):
        if isinstance(found, list):
            found = found[int(part)] if int(part) < len(found) else None
        else:
            found = found.get(part) if isinstance(found, dict) else None
    return found


def with_value(content: Content, key: str, value: Any) -> Content:
    """The scene with another value of a key; tables that it leaves out are made.

    What is beside the key is the same object in both: a study has many scenes.
    """
    return cast(Content, _with(content, key.split("."), value))


def _with(table: Any, parts: Sequence[str], value: Any) -> Any:
    first, rest = parts[0], parts[1:]
    if isinstance(table, list):
        copy, place = list(table), int(first)
        copy[place] = _with(copy[place], rest, value) if rest else value
        return copy
    return table | {first: _with(table.get(first, {}), rest, value) if rest else value}


def unit(key: str) -> str:
    """The unit of a key of scenes, "-" where it has none."""
    parts = [part for part in key.split(".") if not part.isdigit() and part not in MODES]
    names = {"forcing": "[forcing.A]"} | {name: f"[[{name}]]" for name in _ARRAYS}
    header = names.get(parts[0], f"[{parts[0]}]")
    keys = {s.header: {k.name: k.unit for k in s.keys} for s in scene_reference()}
    return keys.get(header, {}).get(key.split(".")[-1] if len(parts) < 2 else parts[1], "-")


def is_load(key: str) -> bool:
    """Whether it is of the loads alone: samples that differ in it share a friction table."""
    parts = key.split(".")
    if parts[0] == "forcing":
        return len(parts) == 3 and parts[2] in _OF_LOADS
    return key == "limits.scale"


def _one_of(name: str, key: str, part: str, allowed: Sequence[str]) -> None:
    if part not in allowed:
        close = difflib.get_close_matches(part, allowed, n=1)
        hint = f"; did you mean {close[0]}?" if close else ""
        raise SlipmodeError(
            f"{name}: no such key of a scene, {key!r}: {part!r} must be one of "
            f"{', '.join(allowed)}{hint}"
        )


def _element(name: str, key: str, parts: Sequence[str], count: int, of: str) -> list[str]:
    if not parts or not parts[0].isdecimal() or int(parts[0]) >= count:
        there = f"there are {count}, numbered from 0" if count else "there are none"
        raise SlipmodeError(f"{name}: no such key of the scene, {key!r}: of {of} {there}")
    return list(parts[1:])


def _end(name: str, key: str, parts: Sequence[str]) -> None:
    if parts:
        raise SlipmodeError(f"{name}: no such key of a scene, {key!r}: nothing is below a value")
