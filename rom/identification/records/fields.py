"""Named arrays of a file, and the sampling rate that they or the file state."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen, in_one_line, naming
from slipmode.rom.slow import parse_unit

_NAMES = {
    "time": ("times", "t", "x_value", "zeit", "temps", "tiempo", "tempo", "elapsed time"),
    "frequency": ("freq", "frequenz", "excitation frequency"),
    "force": ("kraft", "hammer", "impact"),
    "phase": (),
    "amplitude": (),
    "sample_rate": ("sampling_rate", "fs", "samplerate", "sampling_frequency"),
    "time_step": ("dt", "delta_t"),
    "index": ("sample", "samples", "point", "no.", "no", "nr", "n", "#"),
}
_USUAL = {name: key for key, names in _NAMES.items() for name in (key, *names)}
# Largest distance of times from an even grid besides rounding, and of two rates that are one,
# relative to a step and to a rate.
UNEVEN = 1e-3
_COUNTS = ([0.0, 1.0], [1.0, 2.0])  # first numbers of samples
_FEWEST = 8  # values of a first column without name that rises evenly: no signal does


@frozen
class Field:
    """A named array.

    Attributes
    ----------
    name : str
        Empty if the file has no name.
    values : ndarray
        Numbers.
    unit : str
        As in `parse_unit` if that knows it; empty if the file states none.
    rounding : float or ndarray
        Largest error of printed values.
    """

    name: str
    values: Floats
    unit: str = ""
    rounding: Floats | float = 0.0

    @property
    def kind(self) -> str:
        """What the name or the unit says it is: "time", "force", "frequency", ..., or ""."""
        name = self.name.lower()
        found = "force" if name.startswith("force ") else _USUAL.get(name, "")
        unit = parse_unit(self.unit)
        measured = unit.quantity if unit else ""
        if measured in ("time", "force") and found not in ("sample_rate", "time_step"):
            return measured
        return "" if found == "time" and measured else found

    def converted(self, quantity: str, size: float = 1.0) -> Field:
        """Return the array in a unit of a quantity with a size in SI, by default 1.

        An array without unit stays. A SlipmodeError names a unit of another quantity.
        """
        if not self.unit:
            return self
        unit = parse_unit(self.unit)
        if unit is None or unit.quantity != quantity:
            raise SlipmodeError(f"{self.name} is in {self.unit!r}: must be a unit of {quantity}")
        scale = unit.size / size
        return replace(self, values=scale * self.values, rounding=scale * self.rounding, unit="")


@frozen
class Group:
    """Arrays that belong together: all arrays of a file, a structure or a blow.

    Attributes
    ----------
    name : str
        Empty for all arrays of a file.
    fields : sequence of Field
    sample_rate : float or None
        Sampling rate that is stated beside the arrays [Hz].
    notes : tuple of str
        What was found, a line each.
    arrays : bool
        Whether the arrays may be several records.
    """

    name: str
    fields: Sequence[Field]
    sample_rate: float | None = None
    notes: tuple[str, ...] = ()
    arrays: bool = False


def name_and_unit(text: str) -> tuple[str, str]:
    """Return the parts of "force [N]", "t/s", "Zeit in ms" or "time_us"; the unit may be empty."""
    text = text.strip().strip("\"'").strip()
    for inside in (r".*", r"[^\[({]*"):  # of the first bracket that ends the text, of the last
        bracket = re.fullmatch(rf"(.*?)[\s/_]*([\[({{])({inside})[\])}}]", text)
        unit = parse_unit(bracket[3]) if bracket else None
        if bracket and unit:
            return bracket[1], unit.name
    if bracket and bracket[1] and bracket[2] == "[" and not bracket[3].isdecimal():
        return bracket[1], bracket[3].strip()
    whole = parse_unit(text)
    if whole and whole.quantity and "/" in text:
        return "", whole.name
    for pattern in (r"(.+?)(?:\s+in\s+|\s*,\s*|\s*/\s*)(.+)", r"(.+)[_\s](\S+)"):
        split = re.fullmatch(pattern, text)
        unit = parse_unit(split[2]) if split else None
        clear = split and (pattern[3] == "?" or "/" in split[2] or split[1].lower() in _USUAL)
        if split and unit and unit.quantity and clear:
            return split[1], unit.name
    return text, ""


def signals(path: Path, group: Group, given: Any) -> tuple[list[Field], float, tuple[str, ...]]:
    """Return the arrays that are signals, their sampling rate [Hz], and notes.

    The rate is `given`, or follows from times or from a stated rate. A SlipmodeError names what is
    missing or uneven.
    """
    if given is not None and not (np.ndim(given) == 0 and 0 < given < np.inf):
        raise SlipmodeError(f"sample_rate = {in_one_line(given)}: must be > 0 [Hz]")
    notes = list(group.notes)
    fields, stated = _without_rates(path, group)
    times = [each for each in fields if each.kind == "time"]
    if len(fields) > 1 and _is_even(fields[0]) and fields[0].values[:2].tolist() in _COUNTS:
        first = fields.pop(0)
        notes.append(f"its first column, {first.name or 'without name'}, numbers the samples")
    if not times and len(fields) > 1 and _is_even(fields[0]):
        times = fields[:1]
        if times[0].name:
            notes.append(f"its first column, {times[0].name}, is taken as the time [s]")
    fields = [each for each in fields if each not in times]
    try:
        rate, coarse = rate_of_times(path, times) if times else (stated, False)
    except SlipmodeError:
        if given is None:
            raise
        rate, coarse = stated, False
    if given is not None:
        if rate is not None and abs(given / rate - 1.0) > UNEVEN:
            notes.append(f"the sampling rate is {given:g} Hz as given; the file has {rate:g} Hz")
        return fields, float(given), tuple(notes)
    if rate is None:
        raise SlipmodeError(
            f"sample_rate: {path} has neither a sampling rate nor times; give sample_rate= [Hz]"
        )
    if stated is not None and abs(rate / stated - 1.0) > UNEVEN:
        notes.append(f"its times have {rate:g} Hz, which is used; it states {stated:g} Hz")
    if coarse:
        notes.append(
            f"its times are too coarse to show a lost sample; their mean rate is {rate:.6g} Hz"
        )
    return fields, rate, tuple(notes)


def _without_rates(path: Path, group: Group) -> tuple[list[Field], float | None]:
    """Return the arrays of a group, and the sampling rate [Hz] that a number in it states."""
    rate = group.sample_rate
    for field in group.fields:
        if field.values.ndim == 0 and field.kind in ("sample_rate", "time_step"):
            is_rate = field.kind == "sample_rate"
            with naming(path):
                scaled = field.converted(*(("frequency", 2.0 * pi) if is_rate else ("time",)))
            size = float(scaled.values)
            if not 0.0 < size < np.inf:
                raise SlipmodeError(f"{path}: {field.name} = {size:g}: must be > 0")
            rate = size if is_rate else 1.0 / size
    return [field for field in group.fields if field.values.ndim], rate


def _is_even(field: Field) -> bool:
    if field.kind not in ("", "index") or field.unit or field.values.size < _FEWEST:
        return False
    grid = _Grid.of(field)
    return grid is not None and grid.worst is None


@frozen
class _Grid:
    """The even grid nearest to times.

    Attributes
    ----------
    rate : float
        [Hz]
    coarse : bool
        Whether times are rounded to more than half a step, so that lost samples do not show.
    worst : tuple of (int, float) or None
        A time that is farther from the grid than allowed: its number from 0 and distance [s].
    """

    rate: float
    coarse: bool
    worst: tuple[int, float] | None

    @classmethod
    def of(cls, times: Field) -> _Grid | None:
        """Return the grid, None if the times do not rise."""
        t = times.values
        if t.ndim != 1 or t.size < 2 or not np.isfinite(t).all():
            return None
        k = np.arange(t.size) - 0.5 * (t.size - 1)
        t = t - t.mean()
        step = float(k @ t / (k @ k))
        if step <= 0.0:
            return None
        allowed = times.rounding + UNEVEN * step
        distance = np.abs(t - step * k)
        coarse = bool(distance.max() > UNEVEN * step and np.max(allowed) > 0.5 * step)
        if (distance <= allowed).all():
            return cls(1.0 / step, coarse, None)

        def excess(slope: float) -> float:  # convex; at most 0 if a grid is near all times
            away = t - slope * k
            return float((away - allowed).max() - (away + allowed).min())

        reach = 4.0 * float(distance.max()) / t.size
        best = scipy.optimize.minimize_scalar(
            excess,
            bounds=(step - reach, step + reach),
            method="bounded",
            options={"xatol": 1e-4 * UNEVEN * step / t.size},
        )
        if best.fun <= 0.0:
            return cls(1.0 / float(best.x), coarse, None)
        farthest = int(np.argmax(distance - allowed))
        return cls(1.0 / step, coarse, (farthest, float(distance[farthest])))


def rate_of_times(path: Path, times: Sequence[Field]) -> tuple[float, bool]:
    """Return the sampling rate [Hz] of times in equal steps; refuse others.

    The second value is whether the times are too coarse to show a lost sample.
    """
    with naming(path):
        first, *others = (each.converted("time") for each in times)
    for other in others:
        if not np.array_equal(other.values, first.values):
            raise SlipmodeError(
                f"{path}: has the times {first.name} and {other.name}, which differ; resample the "
                "signals to common times, or give sample_rate= [Hz] to ignore both"
            )
    grid = _Grid.of(first)
    if grid is not None and grid.worst is None:
        return grid.rate, grid.coarse
    reason = "they do not rise"
    if grid is not None and grid.worst is not None:
        number, distance = grid.worst
        reason = f"time {number + 1} is {distance:.3g} s off an even grid of {grid.rate:.6g} Hz"
    raise SlipmodeError(
        f"{path}: times must rise in equal steps, but {reason}; resample the signal to a constant "
        "rate, or give sample_rate= [Hz] if only the times are wrong"
    )


def renamed(fields: Sequence[Field]) -> list[Field]:
    """Return fields with names: channel 0, channel 1, ... for those without, each once."""
    found: list[Field] = []
    for k, each in enumerate(fields):
        name = each.name or f"channel {k}"
        count = sum(other.name.partition("#")[0] == name for other in found)
        found.append(replace(each, name=f"{name}#{count + 1}" if count else name))
    return found
