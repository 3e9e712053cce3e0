"""Kinds of values in TOML files: what is allowed, and the message that refuses anything else."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.representable import ALLOWED, LARGEST, SMALLEST
from slipmode.rom.slow.units import parse_unit
from slipmode.rom.storage.text import checked_line
from slipmode.runner.scene.script import Script

OneOrEach = float | tuple[float, ...]  # a number, or one per contact
OneOrMore = int | tuple[int, ...]
Schema = dict[str, Any]


@dataclass(frozen=True)
class Rule:
    """What a number must satisfy, in words and in JSON Schema."""

    text: str
    schema: Schema

    def holds(self, value: float) -> bool:
        """Return whether a finite number satisfies the rule."""
        least, most = self.schema.get("minimum", -math.inf), self.schema.get("maximum", math.inf)
        excluded = value == least and "exclusiveMinimum" in self.schema
        return bool(least <= value <= most and not excluded)


FINITE = Rule("finite", {})
POSITIVE = Rule("> 0", {"minimum": 0, "exclusiveMinimum": True})
NON_NEGATIVE = Rule(">= 0", {"minimum": 0})


def at_least(low: float) -> Rule:
    """Return the rule value >= low."""
    return Rule(f">= {low:.15g}", {"minimum": low})


def between(low: float, high: float) -> Rule:
    """Return the rule low <= value <= high."""
    return Rule(f"{low:.15g} to {high:.15g}", {"minimum": low, "maximum": high})


@dataclass(frozen=True)
class Kind:
    """A kind of value."""

    words: str  # The kind as documentation names it
    # The values that are allowed, as a refusal states them; empty if `words` says it all
    allowed: str
    # `read(name, value)` returns the checked value. It raises a SlipmodeError that begins with the
    # full name of the key.
    read: Callable[[str, Any], Any] = field(repr=False)
    schema: Schema  # The kind in JSON Schema


def choice(*allowed: str, instead: Mapping[str, str] | None = None) -> Kind:
    """Return the kind of a string out of a few; `instead` has messages for other strings."""
    listed = ", ".join(f'"{each}"' for each in allowed)

    def read(name: str, value: Any) -> str:
        if value in allowed:
            return str(value)
        usual = f"must be one of {listed}; got {shown(value)}"
        raise SlipmodeError(f"{name}: {(instead or {}).get(str(value), usual)}")

    return Kind("string", listed, read, {"enum": list(allowed)})


def unit_choice(*allowed: str) -> Kind:
    """Return the kind of a unit out of a few, in any spelling."""
    usual = choice(*allowed)

    def read(name: str, value: Any) -> Any:
        found = parse_unit(value) if isinstance(value, str) else None
        return usual.read(name, found.name if found else value)

    return replace(usual, read=read, schema={"type": "string", "examples": list(allowed)})


def anything() -> Kind:
    """Return the kind of a value that its reader checks."""
    return Kind("any value", "", lambda name, value: value, {})


def text() -> Kind:
    """Return the kind of a line of text."""

    def read(name: str, value: Any) -> str:
        if not isinstance(value, str):
            raise SlipmodeError(f"{name}: must be a string, got {shown(value)}")
        return checked_line(name, value)

    return Kind("string", "", read, {"type": "string"})


def boolean() -> Kind:
    """Return the kind of true or false."""

    def read(name: str, value: Any) -> bool:
        if not isinstance(value, bool):
            raise SlipmodeError(f"{name}: must be true or false, got {shown(value)}")
        return value

    return Kind("boolean", "", read, {"type": "boolean"})


def number(rule: Rule = FINITE) -> Kind:
    """Return the kind of a finite number."""

    def read(name: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SlipmodeError(f"{name}: must be a number ({rule.text}), got {shown(value)}")
        try:
            found = float(value)
        except OverflowError:
            found = math.inf
        allowed = rule.text
        if math.isfinite(found) and rule.holds(found):
            if found == 0.0 or SMALLEST <= abs(found) <= LARGEST:
                return found
            allowed = ALLOWED
        raise SlipmodeError(f"{name}: must be {allowed}, got {shown(value)}")

    return Kind("number", rule.text, read, {"type": "number"} | rule.schema)


def integer(rule: Rule = NON_NEGATIVE) -> Kind:
    """Return the kind of a whole number."""

    def read(name: str, value: Any) -> int:
        fits = type(value) is int and abs(value) < 2**63  # TOML 1.0 guarantees 64 bits
        if not (fits and rule.holds(value)):
            raise SlipmodeError(f"{name}: must be an integer ({rule.text}), got {shown(value)}")
        return int(value)

    return Kind("integer", rule.text, read, {"type": "integer"} | rule.schema)


def integers(rule: Rule = NON_NEGATIVE) -> Kind:
    """Return the kind of a list of whole numbers, from 0 by default."""
    return _list_of(integer(rule), "list of integers")


def numbers(rule: Rule = FINITE, length: int | None = None, of: str = "numbers") -> Kind:
    """Return the kind of a list of numbers: `length` of them, or at least one."""
    words = f"list of {of}" if length is None else f"list of {length} numbers"
    return _list_of(number(rule), words, length, least=1)


def complex_number() -> Kind:
    """Return the kind of a complex number [re, im]."""
    pair = numbers(length=2)
    return replace(pair, read=lambda name, value: complex(*pair.read(name, value)))


def one_or_each(rule: Rule = FINITE, of: str = "contact") -> Kind:
    """Return the kind of a number, or a list of one number per contact."""
    return either(number(rule), numbers(rule), f"number, or list of one per {of}")


def script(rule: Rule = FINITE) -> Kind:
    """Return the kind of a number, or breakpoints [[t, value], ...], read as a `Script`."""
    one, pair = number(rule), numbers(length=2)

    def read(name: str, value: Any) -> Script:
        if not isinstance(value, list):
            return Script.constant(one.read(name, value))
        points = [pair.read(f"{name}[{i}]", point) for i, point in enumerate(value)]
        for i, (_, reached) in enumerate(points):
            one.read(f"{name}[{i}]", reached)
        with naming(name):
            return Script.through(points)

    points = {"type": "array", "minItems": 1, "items": pair.schema}
    words = "number, or breakpoints [[t, value], ...]"
    return Kind(words, rule.text, read, {"anyOf": [one.schema, points]})


def rows(words: str, *types: tuple[type, ...], of: Callable[..., Any] = lambda *row: row) -> Kind:
    """Return the kind of a list of rows such as [node, direction], whose entries have types.

    `of` makes the value of a row from its entries.
    """

    def read(name: str, row: Any) -> Any:
        if not (isinstance(row, list) and tuple(map(type, row)) in types):
            raise SlipmodeError(f"{name.rpartition('[')[0]}: must be {words}, got {shown(row)}")
        return of(*row)

    lengths = [len(each) for each in types]
    schema = {"type": "array", "minItems": min(lengths), "maxItems": max(lengths)}
    return _list_of(Kind(words, "", read, schema), f"list of {words}")


def either(single: Kind, several: Kind, words: str) -> Kind:
    """Return the kind that reads a list as `several` and anything else as `single`."""

    def read(name: str, value: Any) -> Any:
        return (several if isinstance(value, list) else single).read(name, value)

    return Kind(words, single.allowed, read, {"anyOf": [single.schema, several.schema]})


def _list_of(item: Kind, words: str, length: int | None = None, least: int = 0) -> Kind:
    """Return the kind of a list of items, read as a tuple: `length` of them, or at least some."""

    def read(name: str, value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise SlipmodeError(f"{name}: must be a {words}, got {shown(value)}")
        if len(value) < least or length not in (None, len(value)):
            raise SlipmodeError(f"{name}: must be a {words}, got {len(value)}")
        return tuple(item.read(f"{name}[{i}]", each) for i, each in enumerate(value))

    bounds = {"minItems": least if length is None else length}
    bounds |= {} if length is None else {"maxItems": length}
    schema = {"type": "array", "items": item.schema} | bounds
    return Kind(words, item.allowed, read, schema)


# The kind of each type of field; a rule of the field is the argument.
KINDS: dict[Any, Callable[..., Kind]] = {
    Any: anything,
    str: text,
    bool: boolean,
    int: integer,
    float: number,
    complex: complex_number,
    Script: script,
    tuple[int, ...]: integers,
    tuple[float, ...]: numbers,
    tuple[float, float]: partial(numbers, length=2),
    OneOrEach: one_or_each,
    OneOrMore: lambda: either(integer(), integers(), "integer, or list of integers"),
}


def shown(value: Any) -> str:
    """Return a value as it may stand in a one-line message: short and escaped."""
    try:
        text = json.dumps(value, default=str)
    except ValueError:  # Python refuses to print integers of thousands of digits
        text = "a huge number"
    return text if len(text) <= 40 else f"{text[:37]}..."
