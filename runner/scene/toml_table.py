"""Tables of a TOML file: declared as sections of keys, read by these declarations, and written."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Literal

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.scene.values import Kind, shown


@dataclass(frozen=True)
class Key:
    """The declaration of a key."""

    name: str
    kind: Kind  # How its value is read
    unit: str  # "-" if it has none
    # The value of a key that is left out, as in TOML; None if there is none, `dataclasses.MISSING`
    # if the key is required
    default: Any
    meaning: str  # What it does, in a sentence
    # "load" for a quantity that a friction table does not depend on, "limit" for a friction limit
    # or preload, by which a friction table scales
    role: Literal["", "load", "limit"] = ""

    @property
    def shown_default(self) -> str:
        """The default as in TOML; "required", or "-" if there is none."""
        if self.default is MISSING:
            return "required"
        if isinstance(self.default, float):
            return f"{self.default:g}"
        return "-" if self.default in (None, []) else json.dumps(self.default)


@dataclass(frozen=True)
class Section:
    """The declaration of a table: its keys, and the tables below it."""

    name: str  # Empty for the file itself
    meaning: str
    parts: tuple[Key | Section, ...]
    is_array: bool = False  # Whether the file has any number of these tables, [[name]]
    # Advice for keys that belong to another section
    hints: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def by_name(self) -> dict[str, Key | Section]:
        """Keys and tables by name."""
        return {part.name: part for part in self.parts}

    @property
    def keys(self) -> tuple[Key, ...]:
        """The keys, without the tables below."""
        return tuple(part for part in self.parts if isinstance(part, Key))

    @property
    def sections(self) -> tuple[Section, ...]:
        """The tables below."""
        return tuple(part for part in self.parts if isinstance(part, Section))


class Table:
    """A TOML table at a path such as "forcing.A"; a table that is absent reads as an empty one.

    `table[name]` is the checked value of a key or its default; for a section it is the `Table`, or
    the list of tables of an array. Every refusal is a SlipmodeError `full.key: what is allowed`;
    keys that the section does not declare are refused at once.
    """

    def __init__(self, content: Mapping[str, Any], section: Section, path: str = "") -> None:
        if not isinstance(content, Mapping):
            raise SlipmodeError(f"{path}: must be a table, got {shown(content)}")
        self._content = content
        self._section = section
        self._path = path
        for name in content:
            if name not in section.by_name:
                allowed = sorted(section.by_name)
                hint = section.hints.get(name) or did_you_mean(name, allowed)
                hint = f"; {hint}" if hint else ""
                raise self.error(name, f"unknown key; allowed: {', '.join(allowed)}{hint}")

    def __contains__(self, name: str) -> bool:
        return name in self._content

    def __getitem__(self, name: str) -> Any:
        part = self._section.by_name[name]
        if isinstance(part, Key):
            return self.read(name)
        path, found = self._full(name), self._content.get(name, [] if part.is_array else {})
        if not part.is_array:
            return Table(found, part, path)
        if not isinstance(found, list):
            raise SlipmodeError(
                f"{path}: must be an array of tables, [[{path}]], got {shown(found)}"
            )
        return [Table(each, part, f"{path}[{i}]") for i, each in enumerate(found)]

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def read(self, name: str, kind: Kind | None = None) -> Any:
        """Return the checked value of a key; `kind` overrides the declared kind."""
        key = self._section.by_name[name]
        assert isinstance(key, Key)
        if name in self._content:
            return (kind or key.kind).read(self._full(name), self._content[name])
        if key.default is MISSING:
            raise self.error(name, "is missing")
        return None if key.default is None else key.kind.read(name, key.default)

    def values(self) -> dict[str, Any]:
        """Return the values of all keys by name."""
        return {key.name: self[key.name] for key in self._section.keys}

    def given(self, name: str) -> Any:
        """Return a value as it stands in the file, unchecked; None if it is absent."""
        return self._content.get(name)

    def required(self, name: str) -> Any:
        """Return the value of a key that must be there in this case."""
        if name not in self:
            raise self.error(name, "is missing")
        return self[name]

    def exactly_one(self, names: Iterable[str], at: str, message: str) -> None:
        """Refuse the table unless it has exactly one of several keys; the message names `at`."""
        if sum(name in self for name in names) != 1:
            raise self.error(at, message)

    def error(self, name: str, message: str) -> SlipmodeError:
        """Return the refusal of a key, to be raised."""
        return SlipmodeError(f"{self._full(name)}: {message}")

    def below(self, refusal: SlipmodeError) -> SlipmodeError:
        """Return a refusal `key: message` with the full key."""
        return SlipmodeError(f"{self._path}.{refusal}")

    def _full(self, name: str) -> str:
        return _dotted(self._path, name)


@lru_cache(maxsize=1024)  # a study reads the same keys of many scenes
def _dotted(path: str, name: str) -> str:
    return f"{path}.{quoted(name)}" if path else quoted(name)


def quoted(name: str) -> str:
    """Return a key as TOML writes it."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """Return a question that names the allowed word closest to another one, or nothing."""
    close = difflib.get_close_matches(name, list(allowed), n=1)
    return f"did you mean {close[0]}?" if close else ""


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
