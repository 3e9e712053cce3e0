"""Text files of numbers as loggers, oscilloscopes and other programs write them.

The numbers are a block of lines. Its lines have as many cells of the same kinds: separated by tab,
semicolon, comma or blanks, with decimal points or commas, in quotes or not. Names and units stand
in the lines above the block, other lines above and below it are descriptions.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen
from slipmode.rom.identification.records.fields import Field, Group, name_and_unit
from slipmode.rom.slow import parse_unit
from slipmode.rom.storage import read_text

_SEPARATORS = ("\t", ";", ",", None)  # None: blanks. Among equally good ones the first is taken.
# Lines from the middle of a file in which the form of its numbers is found.
_SAMPLE = 2000
_DAY = 86400.0  # [s]
_DESCRIBED = 50  # first rows of a block, beside which some oscilloscopes write descriptions
_MISSING = ("", "n/a", "na", "#n/a")
_INFINITE = {"∞": np.inf, "+∞": np.inf, "-∞": -np.inf}
_CLOCK = re.compile(r"(?:[\d./-]+[ T])?(\d{1,2}):(\d\d):(\d\d(?:[.,]\d*)?)")
_MEASURED = re.compile(r"[-+]?\d*[.,]\d+(?:[eE][-+]?\d+)?|.*\d:\d\d.*")  # no names
_SEPARATED = re.compile(r"\d[;,\t]|[;,\t][-+.\d]|^[-+\d.eE]+(?:\s+[-+\d.eE]+)+$")
_DIGIT = re.compile(r"\d")
_DESCRIPTION = re.compile(r"[^:]*:(?:\s|$)|sep=|.*\*\*\*")  # lines that are no names
_COMMENT = re.compile(r"comment|remark|note|kommentar|bemerkung", re.IGNORECASE)
_UNIT_LABEL = re.compile(r"(?:y_?)?units?(?:_label)?|einheit(?:en)?", re.IGNORECASE)
# What lines beside the numbers may state, with decimal points or commas.
_STATED = {
    mark: {
        key: re.compile(
            rf"\W*(?:{words})\b(?P<unit>[^\d\t:=,;]*)[\t:=,;\s]+"
            rf"(?P<value>[-+]?[\d{mark}]*\d(?:[eE][-+]?\d+)?)\s*(?P<after>[^\d\s]*)",
            re.IGNORECASE,
        )
        for key, words in {
            "rate": r"(?:sampl\w*|scan|acquisition|abtast)[\s_]?(?:rate|freq\w*)|abtastrate|fs",
            "step": r"(?:sampl\w*|abtast)[\s_]?(?:interval\w*|period|time)|delta[\s_]?[xt]|dt",
            "length": r"(?:(?:number|no\.?)\sof\s)?(?:samples|points)|record\slength",
        }.items()
    }
    for mark in (".", ".,")
}


class Form(NamedTuple):
    """How numbers are written: separator of columns (None for blanks) and decimal mark."""

    separator: str | None
    mark: str

    def cells(self, text: str) -> list[str]:
        """Return the cells of a line."""
        if self.separator is None:
            return text.replace('"', " ").split() or [""]
        cells = text.split(self.separator)
        if '"' in text:
            with suppress(csv.Error):  # longer than its limit
                cells = next(csv.reader([text.lstrip()], delimiter=self.separator), [])
        return [cell.strip() for cell in cells]

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, NaN if it is empty, None for text."""
        clock = _CLOCK.fullmatch(cell) if ":" in cell else None
        if clock:
            seconds = float(clock[3].replace(",", "."))
            return 3600.0 * int(clock[1]) + 60.0 * int(clock[2]) + seconds
        if self.mark == ",":
            if "." in cell or cell.endswith(","):
                return None
            cell = cell.replace(",", ".")
        try:
            return None if "_" in cell else float(cell)
        except ValueError:
            pass
        if cell.lower() in _MISSING or cell.startswith("1.#"):
            return np.nan
        if re.fullmatch(r"[-+]?[\d.]+[dD][-+]?\d+", cell):
            return float(re.sub("[dD]", "e", cell))
        return _INFINITE.get(cell)

    def kinds(self, line: str) -> str:
        """Return the kind of each cell up to the last full one.

        It is n for a number or an empty cell, d for text with digits, such as a date, and t for
        other text. Nothing is returned if all are missing, or if a text has numbers between other
        separators.
        """
        cells = self.cells(line)
        while cells and not cells[-1]:
            cells.pop()
        texts = [cell if self.number(cell) is None else "" for cell in cells]
        if any(map(_SEPARATED.search, texts)) or all(cell.lower() in _MISSING for cell in cells):
            return ""
        return "".join("n" if not text else "d" if _DIGIT.search(text) else "t" for text in texts)

    def rounding(self, cells: Sequence[str], values: Floats) -> Floats:
        """Return half of the last printed digit of values, of which some are in `cells`."""
        decimals, digits = 0, 1
        for cell in cells:
            found = re.search(rf"(\d*)\{self.mark}?(\d*)(?:[eEdD]([-+]?\d+))?$", cell)
            if found and found[0]:
                decimals = max(decimals, len(found[2]) - int(found[3] or 0))
                digits = max(digits, len((found[1] + found[2]).lstrip("0")))
        if ":" in cells[0]:
            digits = 17
        with np.errstate(all="ignore"):
            last = np.floor(np.log10(np.abs(values))) + 1.0 - digits
        return np.asarray(0.5 * np.power(10.0, np.maximum(last, -decimals)))

    def longest_run(self, lines: Iterable[str]) -> tuple[int, int, int, list[str]]:
        """Return the most lines in a row of one kind, and how well they fit.

        These are their number, less their columns of text, and their columns of numbers.
        """
        best: tuple[int, int, int, list[str]] = (0, 0, 0, [])
        for kinds, group in groupby(lines, self.kinds):
            if "n" in kinds:
                run, numbers = list(group), kinds.count("n")
                found = (len(run), numbers - len(kinds), numbers, run)
                best = max(best, found, key=lambda each: each[:3])
        return best


@frozen
class Block:
    """Lines of a file that are rows of numbers.

    Attributes
    ----------
    form : Form
    columns : sequence of int
        Columns with numbers; others have text, or nothing.
    dated : mapping of int to set of str
        Columns of texts with digits, such as dates, and their shapes.
    width : int
        Number of all columns.
    """

    form: Form
    columns: Sequence[int]
    dated: Mapping[int, set[str]]
    width: int

    @classmethod
    def of(cls, form: Form, run: Sequence[str]) -> Block:
        """Return the block that some of its lines in a row belong to."""
        rows = [form.cells(line) for line in run]
        width = max(map(len, rows))
        columns, dated = [], {}
        for k in range(width):
            cells = [row[k] for row in rows if row[k:] and row[k]]
            if cells and all(form.number(cell) is not None for cell in cells):
                columns.append(k)
            elif cells and all(_DIGIT.search(cell) for cell in cells):
                dated[k] = {_shape(cell) for cell in cells}
        return cls(form, columns, dated, width)

    def row(self, line: str) -> list[float] | None:
        """Return the numbers of a line, None if it is no row."""
        cells = self.form.cells(line)
        if len(cells) <= self.columns[-1]:
            return None
        if all(cells[k].lower() in _MISSING for k in self.columns):
            return None
        if any(cell and self.form.number(cell) is not None for cell in cells[self.width :]):
            return None
        if not all(_shape(cells[k]) in own for k, own in self.dated.items() if any(cells[k:])):
            return None
        row = [self.form.number(cells[k]) for k in self.columns]
        return None if None in row else [each for each in row if each is not None]

    def starts(self, line: str) -> bool:
        """Return whether a line begins as a row."""
        first = self.form.cells(line)[0]
        return bool(_DIGIT.search(first)) and (
            0 in self.dated or self.form.number(first) is not None
        )

    def header(self, line: str) -> list[str] | None:
        """Return the cells of a line above the block, None if they are not as many as columns."""
        plain = re.sub(r"^[#%!*/]+\s*", "", line.strip())
        ways = [self.form.cells(plain)]
        if self.form.separator is None:
            with_brackets = r'"[^"]*"|[^\s"\[({]*\s*[\[({][^\])}]*[\])}]|[^\s"]+'
            ways += [re.findall(with_brackets, plain), re.split(r"\s{2,}", plain)]
            others = "\t;," if self.form.mark == "." else "\t;"
            ways += [Form(separator, ".").cells(plain) for separator in others]
        stated = _stated(self.form, line) or _DESCRIPTION.match(plain)
        for cells in ways:
            while cells and not cells[-1]:
                cells.pop()
            fits = self.columns[-1] < len(cells) <= self.width or (
                len(cells) > self.width and all(map(_COMMENT.match, cells[self.width :]))
            )
            values = any(_MEASURED.fullmatch(c) or _SEPARATED.search(c) for c in cells)
            if fits and not stated and not values:
                return [cells[k].strip('"') for k in self.columns]
        return None

    def names_and_units(self, above: Sequence[str]) -> list[tuple[str, str]]:
        """Return name and unit of each column from the lines above the block."""
        labels: list[list[str]] = []  # nearest line first
        for line in reversed(above):
            cells = self.header(line)
            if cells is None:
                break
            labels.append(cells)
        of_row = next((k for k, cells in enumerate(labels[:2]) if _are_units(cells)), None)
        texts = next((cells for k, cells in enumerate(labels) if k != of_row), [""] * self.width)
        found = [name_and_unit(text) for text in texts[: len(self.columns)]]
        units = labels[of_row] if of_row is not None else [""] * len(found)
        for line in above:  # a line of units of all columns but the times
            first, *others = self.form.cells(line)
            if _UNIT_LABEL.fullmatch(first) and len(others) >= len(found) - 1 > 0:
                units = ["", *others]
        return [
            (name, _unit_name(text) or own)
            for (name, own), text in zip(found, units, strict=False)
        ]


def _shape(text: str) -> str:
    """Return a text with 9 for each number and a for each word."""
    return re.sub(r"[^\W\d_]+", "a", re.sub(r"\d+", "9", text))


def read_text_table(path: Path) -> Group:
    """Return the columns of a text file by name; refuse, naming a line, what is ambiguous."""
    lines = read_text(path).split("\n")
    full = [k for k, line in enumerate(lines) if line.strip(" \t,;")]
    form, run, at = _form(path, lines, full)
    block = Block.of(form, run)
    table = np.empty((len(full), len(block.columns)))
    start = end = at
    for step in (1, -1):
        k = at if step == 1 else at - 1
        while 0 <= k < len(full) and (row := block.row(lines[full[k]])) is not None:
            table[k] = row
            start, end = min(start, k), max(end, k + 1)
            k += step
    notes = _check_lines(path, block, lines, full[:start], full[end:])
    above = [lines[k] for k in full[:start]]
    stated = [
        _stated(form, line)
        for line in (*above, *(lines[k] for k in full[start : start + _DESCRIBED]))
    ]
    rate, length = (next((e[k] for e in stated if e.get(k)), None) for k in ("rate", "length"))
    if length and length > end - start:
        notes.append(f"it states {length:.0f} samples and has {end - start}")
    seen = [form.cells(lines[k]) for k in full[start : end : (end - start) // _SAMPLE + 1]]
    fields = []
    labels = block.names_and_units(above)
    for k, column, (name, unit) in zip(block.columns, table[start:end].T, labels, strict=True):
        cells, values = [row[k] for row in seen], column
        if ":" in cells[0]:  # times of day
            nights = np.cumsum(np.diff(column, prepend=column[0]) < -0.5 * _DAY)
            unit, values = "s", column + _DAY * nights
        fields.append(Field(name, values, unit, form.rounding(cells, values)))
    return Group("", fields, rate, tuple(notes))


def _form(path: Path, lines: Sequence[str], full: Sequence[int]) -> tuple[Form, list[str], int]:
    """Return the form of the numbers, lines in a row that have it, and where these begin.

    `full` has the positions of lines that are not blank. Doubtful commas are refused.
    """
    first = max(len(full) - _SAMPLE, 0) // 2
    sample = [lines[k] for k in full[first : first + _SAMPLE]]
    forms = [Form(separator, mark) for mark in ".," for separator in _SEPARATORS]
    runs = [form.longest_run(sample) for form in forms]
    best = max(range(len(forms)), key=lambda k: runs[k][:3])
    form, (*_, columns, run) = forms[best], runs[best]
    if not run:
        raise SlipmodeError(f"{path}: has no columns of numbers")
    at = first + next(k for k in range(len(sample)) if sample[k] is run[0])
    if form != Form(",", ".") or columns < 2 or any("." in line for line in run):
        return form, run, at
    # Integers between commas are columns, or whole and decimal parts: of two cells for each name.
    halves = at > 0 and 2 * len(form.cells(lines[full[at - 1]])) == columns
    padded = any(re.search(r"(?<![\d.])0\d", line) for line in run)
    column = Form("\t", ",")
    is_column = columns == 2 and column.longest_run(run)[0] == len(run)
    if is_column and (halves or padded):
        return column, run, at
    if halves or padded or (is_column and at == 0):
        raise SlipmodeError(
            f"{path}: line {full[at] + 1}: commas may be decimal marks or separate columns; "
            "write decimal points, or semicolons between columns"
        )
    return form, run, at


def _check_lines(
    path: Path, block: Block, lines: Sequence[str], above: Sequence[int], below: Sequence[int]
) -> list[str]:
    """Return notes of the lines around a block; refuse damaged rows."""
    notes, wrong = [], None
    for places in (above[::-1], below):
        if any(block.row(lines[k]) for k in places):
            wrong = places[0]
    if wrong is None and below and block.starts(lines[below[0]]):
        *whole, last = block.form.cells(lines[below[0]])
        cut = re.fullmatch(r"[-+\d.,eE]*", last) and None not in map(block.form.number, whole)
        if len(below) == 1 and cut:
            notes.append(f"its last line, {below[0] + 1}, is incomplete and was left out")
        else:
            wrong = below[0]
    elif wrong is None and above and block.width > 1:
        line = lines[above[-1]]
        has_width = len(block.form.cells(line)) >= block.width
        if has_width and block.starts(line) and block.header(line) is None:
            wrong = above[-1]
    if wrong is not None:
        raise SlipmodeError(
            f"{path}: line {wrong + 1} must have one number a column, as other lines have in "
            f"{len(block.columns)} columns; a file must have one table"
        )
    return notes


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether the cells of a line are units, as "s", "[m/s^2]" or "(EU)"."""
    given = [cell for cell in cells if cell.strip("-")]
    units = [parse_unit(cell) is not None for cell in given]
    return (any(units) or not given) and all(
        u or cell[0] in "[({" for u, cell in zip(units, given, strict=True)
    )


def _unit_name(text: str) -> str:
    unit = parse_unit(text)
    return unit.name if unit else text.strip("[](){}- ")


def _stated(form: Form, line: str) -> dict[str, float]:
    """Return the rate [Hz] or number of samples that a line states."""
    text = line.replace('"', "")
    for key, pattern in _STATED["." if form.mark == "." else ".,"].items():
        found = pattern.match(text)
        value = Form(None, ".").number(found["value"].replace(",", ".")) if found else None
        if not found or not value:
            continue
        if key == "length":
            return {"length": value}
        unit = parse_unit(found["unit"]) or parse_unit(found["after"])
        measured = unit.quantity if unit else ""
        if key == "rate":
            return {
                "rate": value
                * (unit.size / (2.0 * np.pi) if unit and measured == "frequency" else 1.0)
            }
        return {"rate": 1.0 / (value * (unit.size if unit and measured == "time" else 1.0))}
    return {}
