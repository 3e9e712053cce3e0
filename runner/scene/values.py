"""Kinds of values in TOML files: what is allowed, and the message that refuses anything else."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import ALLOWED, LARGEST, SMALLEST
from slipmode.rom.text import checked_line
from slipmode.runner.scene.script import Script


@dataclass(frozen=True)
class Rule:
    """What a number must satisfy, in words and as a predicate."""

    text: str
    holds: Callable[[float], bool]


FINITE = Rule("finite", lambda value: True)
POSITIVE = Rule("> 0", lambda value: value > 0)
NON_NEGATIVE = Rule(">= 0", lambda value: value >= 0)


def between(low: float, high: float) -> Rule:
    """Return the rule low <= value <= high."""
    return Rule(f"{low:.15g} to {high:.15g}", lambda value: low <= value <= high)


@dataclass(frozen=True)
class Kind:
    """A kind of value."""

    words: str  # The kind as documentation names it
    # The values that are allowed, as a refusal states them; empty if `words` says it all
    allowed: str
    # `read(name, value)` returns the checked value. It raises a SlipmodeError that begins with the
    # full name of the key.
    read: Callable[[str, Any], Any] = field(repr=False)


def choice(*allowed: str) -> Kind:
    """Return the kind of a string out of a few."""
    listed = ", ".join(f'"{each}"' for each in allowed)

    def read(name: str, value: Any) -> str:
        if value not in allowed:
            raise SlipmodeError(f"{name}: must be one of {listed}; got {shown(value)}")
        return str(value)

    return Kind("string", listed, read)


def anything() -> Kind:
    """Return the kind of a value that its reader checks."""
    return Kind("any value", "", lambda name, value: value)


def text() -> Kind:
    """Return the kind of a line of text."""

    def read(name: str, value: Any) -> str:
        if not isinstance(value, str):
            raise SlipmodeError(f"{name}: must be a string, got {shown(value)}")
        return checked_line(name, value)

    return Kind("string", "", read)


def boolean() -> Kind:
    """Return the kind of true or false."""

    def read(name: str, value: Any) -> bool:
        if not isinstance(value, bool):
            raise SlipmodeError(f"{name}: must be true or false, got {shown(value)}")
        return value

    return Kind("boolean", "", read)


def number(rule: Rule = FINITE) -> Kind:
    """Return the kind of a finite number."""
    return Kind("number", rule.text, partial(_number, rule))


def integer(rule: Rule = NON_NEGATIVE) -> Kind:
    """Return the kind of a whole number."""
    return Kind("integer", rule.text, partial(_integer, rule))


def integers() -> Kind:
    """Return the kind of a list of whole numbers from 0."""

    def read(name: str, value: Any) -> tuple[int, ...]:
        found = enumerate(_list(name, value, "a list of integers"))
        return tuple(_integer(NON_NEGATIVE, f"{name}[{i}]", each) for i, each in found)

    return Kind("list of integers", NON_NEGATIVE.text, read)


def numbers(rule: Rule = FINITE, length: int | None = None) -> Kind:
    """Return the kind of a list of numbers: `length` of them, or at least one."""
    words = "list of numbers" if length is None else f"list of {length} numbers"
    return Kind(words, rule.text, partial(_numbers, rule, length))


def one_or_each(rule: Rule, of: str = "contact") -> Kind:
    """Return the kind of a number, or a list of one number per contact."""
    return either(number(rule), numbers(rule), f"number, or list of one per {of}")


def script(rule: Rule = FINITE) -> Kind:
    """Return the kind of a number, or breakpoints [[t, value], ...], read as a `Script`."""
    constant = Kind("", rule.text, lambda name, value: Script.constant(_number(rule, name, value)))
    breakpoints = Kind("", rule.text, partial(_breakpoints, rule))
    return either(constant, breakpoints, "number, or breakpoints [[t, value], ...]")


def node_dofs(forms: str, lengths: Collection[int]) -> Kind:
    """Return the kind of a list of DOFs, each a list of nodes that ends with a direction."""

    def read(name: str, value: Any) -> tuple[tuple[int | str, ...], ...]:
        rows = _list(name, value, f"a list of {forms}")
        for row in rows:
            valid = isinstance(row, list) and len(row) in lengths and isinstance(row[-1], str)
            if not (valid and all(_is_integer(node) for node in row[:-1])):
                raise SlipmodeError(f"{name}: must be {forms}, got {shown(row)}")
        return tuple(map(tuple, rows))

    return Kind(f"list of {forms}", "", read)


def either(single: Kind, several: Kind, words: str) -> Kind:
    """Return the kind that reads a list as `several` and anything else as `single`."""

    def read(name: str, value: Any) -> Any:
        return (several if isinstance(value, list) else single).read(name, value)

    return Kind(words, single.allowed, read)


def _number(rule: Rule, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SlipmodeError(f"{name}: must be a number ({rule.text}), got {shown(value)}")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not (math.isfinite(found) and rule.holds(found)):
        raise SlipmodeError(f"{name}: must be {rule.text}, got {shown(value)}")
    if not (found == 0.0 or SMALLEST <= abs(found) <= LARGEST):
        raise SlipmodeError(f"{name}: must be {ALLOWED}, got {shown(value)}")
    return found


def _is_integer(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _integer(rule: Rule, name: str, value: Any) -> int:
    fits = _is_integer(value) and abs(value) < 2**63  # TOML 1.0 guarantees 64 bits
    if not (fits and rule.holds(value)):
        raise SlipmodeError(f"{name}: must be an integer ({rule.text}), got {shown(value)}")
    return int(value)


def _numbers(rule: Rule, length: int | None, name: str, value: Any) -> tuple[float, ...]:
    wanted = "a list of numbers" if length is None else f"a list of {length} numbers"
    found = _list(name, value, wanted)
    if not found or (length is not None and len(found) != length):
        raise SlipmodeError(f"{name}: must be {wanted}, got {len(found)}")
    return tuple(_number(rule, f"{name}[{i}]", each) for i, each in enumerate(found))


def _breakpoints(rule: Rule, name: str, value: list[Any]) -> Script:
    points = [_numbers(FINITE, 2, f"{name}[{i}]", point) for i, point in enumerate(value)]
    for i, (_, reached) in enumerate(points):
        _number(rule, f"{name}[{i}]", reached)
    try:
        return Script.through(points)
    except SlipmodeError as error:
        raise SlipmodeError(f"{name}: {error}") from error


def _list(name: str, value: Any, wanted: str) -> list[Any]:
    if not isinstance(value, list):
        raise SlipmodeError(f"{name}: must be {wanted}, got {shown(value)}")
    return value


def shown(value: Any) -> str:
    """Return a value as it may stand in a one-line message: short and escaped."""
    try:
        text = json.dumps(value, default=str)
    except ValueError:  # Python refuses to print integers of thousands of digits
        text = "a huge number"
    return text if len(text) <= 40 else f"{text[:37]}..."
