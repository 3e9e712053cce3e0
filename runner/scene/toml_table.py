"""Tables of a TOML file: declared as dataclasses, read by these declarations, and written.

A field declares a key: `step: Annotated[float, POSITIVE, "s"] = 1.0` is a number > 0 in seconds,
1 if it is left out. The docstring of the class has the meanings. The reader is our own: messages
of msgspec have neither the value nor names of tables in a mapping and it takes infinity; cattrs
takes true and "3" for numbers and loses the key that breaks a rule. Their import takes 15 to 23
and 56 to 65 ms.
"""

from __future__ import annotations

import difflib
import inspect
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from functools import cache, cached_property, lru_cache, reduce
from operator import or_
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.values import KINDS, Kind, Rule, Schema, choice, shown

Content = dict[str, Any]
_T = TypeVar("_T")


class Role(Enum):
    """What a key is to friction tables."""

    NONE = 0
    LOAD = 1  # a quantity that a table does not depend on
    LIMIT = 2  # a friction limit or preload, by which a table scales


@dataclass(frozen=True)
class Key:
    """The declaration of a key."""

    name: str
    kind: Kind  # How its value is read
    unit: str  # "-" if it has none
    # The value of a key that is left out; None if there is none, `dataclasses.MISSING` if the key
    # is required
    default: Any
    meaning: str  # What it does, in a sentence
    role: Role

    @property
    def shown_default(self) -> str:
        """The default as in TOML; "required", or "-" if there is none."""
        if self.default is MISSING:
            return "required"
        default = self.default.values[0] if isinstance(self.default, Script) else self.default
        if isinstance(default, float):
            return f"{default:g}"
        return "-" if default in (None, ()) else json.dumps(default)

    def read(self, given: Any, path: str, root: object) -> Any:
        """Return the checked value of the key; None is none. Refusals begin with the path."""
        return self.kind.read(path, required(path, given))

    @property
    def schema(self) -> Schema:
        """The key in JSON Schema."""
        known = self.shown_default not in ("required", "-")
        default = {"default": json.loads(self.shown_default)} if known else {}
        unit = "" if self.unit == "-" else f" [{self.unit}]"
        return self.kind.schema | {"description": f"{self.meaning}{unit}"} | default


@dataclass(frozen=True)
class Section:
    """The declaration of a table: its keys, and the tables below it."""

    name: str  # Empty for the file itself
    declared: type[Any]  # The dataclass of its keys
    default: Any  # `dataclasses.MISSING` if an absent table is read as an empty one
    is_array: bool  # Whether the file has any number of these tables, [[name]]

    @cached_property
    def parts(self) -> tuple[Key | Section, ...]:
        """Keys and tables below, in the order of the file."""
        hints = get_type_hints(self.declared, include_extras=True)
        return tuple(
            _part(field.name.rstrip("_"), hints[field.name], field.default, self._meanings)
            for field in fields(self.declared)
        )

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

    @property
    def meaning(self) -> str:
        """What the table is for."""
        summary = (inspect.getdoc(self.declared) or "").partition("\nAttributes\n")[0]
        return " ".join(summary.split())

    @cached_property
    def _meanings(self) -> dict[str, str]:
        """The meanings of keys, from the attributes that docstrings list."""
        found: dict[str, str] = {}
        for each in reversed(self.declared.__mro__):
            listed = re.findall(r"^(\w+)\n((?:    .+\n?)+)", inspect.getdoc(each) or "", re.M)
            found |= {name: " ".join(text.split()) for name, text in listed}
        return found

    @property
    def schema(self) -> Schema:
        """The table in JSON Schema, of draft 4, which editors of TOML read."""
        table: Schema = {
            "type": "object",
            "description": self.meaning,
            "properties": {part.name: part.schema for part in self.parts},
            "additionalProperties": False,
        }
        if required := [key.name for key in self.keys if key.default is MISSING]:
            table["required"] = required  # draft 4 refuses an empty list
        return {"type": "array", "items": table} if self.is_array else table

    def read(self, given: Any, path: str = "", root: Section | None = None) -> Any:
        """Return the checked values of a table as its dataclass, or of each table of an array.

        Every refusal is a SlipmodeError `full.key: what is allowed`.
        """
        if not self.is_array:
            return self._table({} if given is None else given, path, root or self)
        if not isinstance(given, list):
            allowed = f"must be an array of tables, [[{path}]]"
            raise SlipmodeError(f"{path}: {allowed}, got {shown(given)}")
        return tuple(
            self._table(each, f"{path}[{i}]", root or self) for i, each in enumerate(given)
        )

    def _table(self, content: Any, path: str, root: Section) -> Any:
        if not isinstance(content, Mapping):
            raise SlipmodeError(f"{path}: must be a table, got {shown(content)}")
        for name in content:
            if name not in self.by_name:
                raise SlipmodeError(f"{_dotted(path, name)}: {self._unknown(name, root)}")
        values = {}
        for field, part in zip(fields(self.declared), self.parts, strict=True):
            given = content.get(part.name)
            if given is not None or part.default is MISSING:
                values[field.name] = part.read(given, _dotted(path, part.name), root)
        return self.declared(**values)

    def _unknown(self, name: str, root: Section) -> str:
        allowed = sorted(self.by_name)
        others = [each.header for each in root.sections if name in each.by_name]
        elsewhere = f"{name} is a key of {' and '.join(others)}" if others else ""
        hints = filter(None, (did_you_mean(name, allowed), elsewhere))
        return "; ".join((f"unknown key; allowed: {', '.join(allowed)}", *hints))

    @property
    def header(self) -> str:
        """The name as a header in TOML."""
        return f"[[{self.name}]]" if self.is_array else f"[{self.name}]"


@cache
def section_of(declared: type[Any], name: str = "") -> Section:
    """Return the declaration of a table by its dataclass."""
    return Section(name, declared, MISSING, False)


def _part(name: str, hint: Any, default: Any, meanings: Mapping[str, str]) -> Key | Section:
    """Return the declaration of a field."""
    kind, rules, unit, role = None, [], "-", Role.NONE
    notes = getattr(hint, "__metadata__", ())
    for note in notes:
        match note:
            case Kind():
                kind = note
            case Rule():
                rules.append(note)
            case str():
                unit = note
            case Role():
                role = note
    value = hint.__origin__ if notes else hint
    if NoneType in get_args(value):
        value = reduce(or_, (each for each in get_args(value) if each is not NoneType))
    if kind is None and value in KINDS:
        kind = KINDS[value](*rules)
    elif kind is None and get_origin(value) is Literal:
        kind = choice(*get_args(value))
    if kind is not None:
        return Key(name, kind, unit, default, meanings.get(name, ""), role)
    is_array = get_origin(value) is tuple
    return Section(name, get_args(value)[0] if is_array else value, default, is_array)


def get(content: Content, path: str) -> Any:
    """Return the value at a dotted path as it stands in the file; None if it is absent."""
    found: Any = content
    for part in path.split("."):
        if isinstance(found, list):
            found = found[int(part)] if int(part) < len(found) else None
        else:
            found = found.get(part) if isinstance(found, dict) else None
    return found


def refuse_if(refused: bool, message: str) -> None:
    """Raise a SlipmodeError with a message if a condition holds."""
    if refused:
        raise SlipmodeError(message)


def required(key: str, value: _T | None) -> _T:
    """Return a value that must be given in this case."""
    if value is None:
        raise SlipmodeError(f"{key}: is missing")
    return value


def refuse_given(content: Content, table: str, names: Iterable[str], message: str) -> None:
    """Refuse the first of some keys that a table of the file has; "" is the file itself."""
    for name in names:
        path = f"{table}.{name}" if table else name
        refuse_if(get(content, path) is not None, f"{path}: {message}")


def exactly_one(key: str, values: Iterable[Any], message: str) -> None:
    """Refuse a key unless exactly one of several values is given."""
    refuse_if(sum(value is not None for value in values) != 1, f"{key}: {message}")


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
