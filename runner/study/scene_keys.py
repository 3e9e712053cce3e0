"""Keys of a scene by dotted paths, "forcing.A.amplitude" or "contacts.0.preload"."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.scene.keys import SCENE
from slipmode.runner.scene.toml_table import Content, Key, Role, Section, did_you_mean


def check_key(name: str, path: str, content: Content) -> None:
    """Refuse a key that scenes do not have, or an element that this scene does not have.

    `name` is the key of the study that the refusal is about, "vary[0].key"; `content` is the
    scene, as parsed. The SlipmodeError lists the names that are allowed instead.
    """
    unknown = f"{name}: no such key of a scene, {path!r}"
    part: Key | Section = SCENE
    below: Any = content
    for word in path.split("."):
        if isinstance(part, Section) and not isinstance(below, list):
            if word not in part.by_name:
                hint = did_you_mean(word, part.by_name)
                allowed = f"{', '.join(part.by_name)}{'; ' if hint else ''}{hint}"
                raise SlipmodeError(f"{unknown}: {word!r} must be one of {allowed}")
            part = part.by_name[word]
            empty: Any = [] if isinstance(part, Section) and part.is_array else {}
            below = below.get(word, empty) if isinstance(below, dict) else empty
        elif isinstance(below, list):
            if not word.isdecimal() or int(word) >= len(below):
                of = f"[[{part.name}]]" if isinstance(part, Section) else "values of the scene"
                there = f"there are {len(below)}, numbered from 0" if below else "there are none"
                raise SlipmodeError(f"{name}: no such key of the scene, {path!r}: of {of} {there}")
            below = below[int(word)]
        else:
            raise SlipmodeError(f"{unknown}: a value has no keys")
    if isinstance(part, Section):
        raise SlipmodeError(f"{unknown}: give one of {', '.join(part.by_name)}")


def with_value(content: Content, path: str, value: Any) -> Content:
    """Return the scene with another value of a key; tables that it leaves out are made.

    Everything else is the same object in both, because a study has many scenes.
    """
    return cast(Content, _with(content, path.split("."), value))


def _with(table: Any, parts: Sequence[str], value: Any) -> Any:
    first, rest = parts[0], parts[1:]
    if isinstance(table, list):
        copy, place = list(table), int(first)
        copy[place] = _with(copy[place], rest, value) if rest else value
        return copy
    return table | {first: _with(table.get(first, {}), rest, value) if rest else value}


def declared(path: str) -> Key:
    """Return the declaration of a key that `check_key` accepts."""
    part: Key | Section = SCENE
    for word in path.split("."):
        if isinstance(part, Section) and word in part.by_name:
            part = part.by_name[word]
    assert isinstance(part, Key)
    return part


def is_load(path: str) -> bool:
    """Return whether samples that differ in this key share a friction table.

    A single breakpoint of a load is not such a key: it may move the range of frequencies.
    """
    key = declared(path)
    return key.role is Role.LOAD and path.endswith(key.name)


def is_limit(path: str) -> bool:
    """Return whether a key is a limit or preload of contacts, by which a table may scale."""
    return declared(path).role is Role.LIMIT
