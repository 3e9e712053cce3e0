"""A table of a TOML file whose values are read by kind and refused by their full key."""

import difflib
import json
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import ALLOWED, LARGEST, SMALLEST
from slipmode.rom.text import checked_line
from slipmode.runner.scene.script import Script


@dataclass(frozen=True)
class Rule:
    """What a number must satisfy, and how that is said."""

    text: str
    holds: Callable[[float], bool]


FINITE = Rule("finite", lambda value: True)
POSITIVE = Rule("> 0", lambda value: value > 0)
NON_NEGATIVE = Rule(">= 0", lambda value: value >= 0)


def between(low: int, high: int) -> Rule:
    """The rule low <= value <= high."""
    return Rule(f"{low} to {high}", lambda value: low <= value <= high)


_LARGEST_INTEGER = 2**63 - 1  # what TOML guarantees


class Table:
    """One TOML table; a table that is absent reads as an empty one.

    Each reading method takes a key and returns its value checked. A key without a default
    is required. Every refusal is a SlipmodeError `full.key: what is allowed`.

    Parameters
    ----------
    content : Mapping
        The table as tomllib returns it.
    keys : collection of str
        The keys it may have; any other is refused at once.
    path : str
        Where the table is in the file, "forcing.A"; empty for the file itself.
    elsewhere : Mapping of str to str
        Keys of another table that could be meant, and what to say of them.
    """

    def __init__(
        self,
        content: Mapping[str, Any],
        keys: Collection[str],
        path: str = "",
        elsewhere: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._content = content
        self._path = path
        for key in content:
            if key not in keys:
                allowed = sorted(keys)
                hint = f"; {elsewhere[key]}" if key in elsewhere else _hint(key, allowed)
                raise self.error(key, f"unknown key; allowed: {', '.join(allowed)}{hint}")

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def error(self, key: str, message: str) -> SlipmodeError:
        """The refusal of a key of this table, to be raised."""
        return SlipmodeError(f"{self._full(key)}: {message}")

    def section(self, key: str, keys: Collection[str]) -> "Table":
        """The table [key], empty if absent."""
        return self._table(self._full(key), self._content.get(key, {}), keys)

    def below(self, refusal: SlipmodeError) -> SlipmodeError:
        """The refusal `key: message` of what was made from this table, with the full key."""
        return SlipmodeError(f"{self._path}.{refusal}")

    def sections(
        self, key: str, keys: Sequence[str], elsewhere: Mapping[str, str] = MappingProxyType({})
    ) -> list["Table"]:
        """The tables [[key]], in file order."""
        name = self._full(key)
        tables = _list(name, self._content.get(key, []), f"an array of tables, [[{name}]]")
        return [
            self._table(f"{name}[{i}]", table, keys, elsewhere) for i, table in enumerate(tables)
        ]

    def text(self, key: str, default: str | None = None) -> str:
        """A string of one line, without control characters."""
        value = self._get(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"must be a string, got {_shown(value)}")
        return checked_line(self._full(key), value)

    def choice(self, key: str, choices: Sequence[str], default: str | None = None) -> str:
        """One of a few strings."""
        value = self._get(key, default)
        if value not in choices:
            allowed = ", ".join(f'"{choice}"' for choice in choices)
            raise self.error(key, f"must be one of {allowed}; got {_shown(value)}")
        return str(value)

    def anything(self, key: str) -> Any:
        """A value of whatever kind."""
        return self._get(key)

    def is_text(self, key: str) -> bool:
        """Whether a value is a string."""
        return isinstance(self._content.get(key), str)

    def is_one_of(self, key: str, choices: Sequence[str]) -> bool:
        """Whether a value is one of a few strings."""
        return self._content.get(key) in choices

    def boolean(self, key: str, default: bool | None = None) -> bool:
        """True or false."""
        value = self._get(key, default)
        if not isinstance(value, bool):
            raise self.error(key, f"must be true or false, got {_shown(value)}")
        return value

    def integer(self, key: str, rule: Rule = NON_NEGATIVE, default: int | None = None) -> int:
        """A whole number."""
        return _integer(self._full(key), self._get(key, default), rule)

    def integers(self, key: str) -> tuple[int, ...]:
        """A list of whole numbers >= 0."""
        name = self._full(key)
        values = _list(name, self._get(key), "a list of integers")
        return tuple(
            _integer(f"{name}[{i}]", value, NON_NEGATIVE) for i, value in enumerate(values)
        )

    def integer_or_integers(self, key: str) -> int | tuple[int, ...]:
        """A whole number >= 0 or a list of them."""
        return self.integers(key) if self._is_list(key) else self.integer(key)

    def rows(self, key: str, wanted: str) -> tuple[tuple[Any, ...], ...]:
        """A list of lists, each `wanted`."""
        name = self._full(key)
        rows = _list(name, self._get(key), f"a list of {wanted}")
        return tuple(tuple(_list(f"{name}[{i}]", row, wanted)) for i, row in enumerate(rows))

    def number(self, key: str, rule: Rule = FINITE, default: float | None = None) -> float:
        """A finite number."""
        return _number(self._full(key), self._get(key, default), rule)

    def numbers(
        self, key: str, rule: Rule = FINITE, length: int | None = None
    ) -> tuple[float, ...]:
        """A list of finite numbers: `length` of them, or any number but none."""
        return _numbers(self._full(key), self._get(key), rule, length)

    def number_or_numbers(self, key: str, rule: Rule = FINITE) -> float | tuple[float, ...]:
        """A finite number or a list of them."""
        return self.numbers(key, rule) if self._is_list(key) else self.number(key, rule)

    def script(self, key: str, rule: Rule = FINITE, default: float | None = None) -> Script:
        """A number, or breakpoints [[t, value], ...] whose values obey the rule."""
        if not self._is_list(key):
            return Script.constant(self.number(key, rule, default))
        name = self._full(key)
        points = [
            _numbers(f"{name}[{i}]", point, FINITE, 2)
            for i, point in enumerate(self._content[key])
        ]
        for i, (_, value) in enumerate(points):
            _number(f"{name}[{i}]", value, rule)
        try:
            return Script.through(points)
        except SlipmodeError as error:
            raise self.error(key, str(error)) from error

    def _table(
        self,
        name: str,
        value: Any,
        keys: Collection[str],
        elsewhere: Mapping[str, str] = MappingProxyType({}),
    ) -> "Table":
        if not isinstance(value, dict):
            raise SlipmodeError(f"{name}: must be a table, got {_shown(value)}")
        return Table(value, keys, name, elsewhere)

    def _get(self, key: str, default: Any = None) -> Any:
        value = self._content.get(key, default)
        if value is None:
            raise self.error(key, "is missing")
        return value

    def _is_list(self, key: str) -> bool:
        return isinstance(self._content.get(key), list)

    def _full(self, key: str) -> str:
        """The dotted key, quoted where TOML would quote it."""
        return _dotted(self._path, key)


@lru_cache(maxsize=1024)  # scenes of a study have the same keys
def _dotted(path: str, key: str) -> str:
    quoted = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key)
    return f"{path}.{quoted}" if path else quoted


def _number(name: str, value: Any, rule: Rule) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SlipmodeError(f"{name}: must be a number ({rule.text}), got {_shown(value)}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and rule.holds(number)):
        raise SlipmodeError(f"{name}: must be {rule.text}, got {_shown(value)}")
    if not (number == 0.0 or SMALLEST <= abs(number) <= LARGEST):
        raise SlipmodeError(f"{name}: must be {ALLOWED}, got {_shown(value)}")
    return number


def _integer(name: str, value: Any, rule: Rule) -> int:
    is_integer = isinstance(value, int) and not isinstance(value, bool)
    if not (is_integer and abs(value) <= _LARGEST_INTEGER and rule.holds(value)):
        raise SlipmodeError(f"{name}: must be an integer ({rule.text}), got {_shown(value)}")
    return int(value)


def _numbers(name: str, value: Any, rule: Rule, length: int | None) -> tuple[float, ...]:
    wanted = "a list of numbers" if length is None else f"a list of {length} numbers"
    values = _list(name, value, wanted)
    if not values or (length is not None and len(values) != length):
        raise SlipmodeError(f"{name}: must be {wanted}, got {len(values)}")
    return tuple(_number(f"{name}[{i}]", value, rule) for i, value in enumerate(values))


def _list(name: str, value: Any, wanted: str) -> list[Any]:
    if not isinstance(value, list):
        raise SlipmodeError(f"{name}: must be {wanted}, got {_shown(value)}")
    return value


def _hint(key: str, allowed: Sequence[str]) -> str:
    close = difflib.get_close_matches(key, allowed, n=1)
    return f"; did you mean {close[0]}?" if close else ""


def _shown(value: Any) -> str:
    """A value as it may stand in a one-line message: short, escaped."""
    try:
        shown = json.dumps(value, default=str)
    except ValueError:  # Python does not print integers of thousands of digits
        shown = "a huge number"
    return shown if len(shown) <= 40 else f"{shown[:37]}..."
