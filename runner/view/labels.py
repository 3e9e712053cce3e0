"""Numbers, units and scales of views, whatever program draws them."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from math import floor, log10

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.units import SI, Units
from slipmode.runner.recording.channels import Channel, Field

# A plot is about 110 pixels high. Rerun labels the multiples of a power of ten that are at least
# 25 pixels apart.
_LABELLED = 4.4
_MARGIN = 1.05  # of a scale, relative to the largest value


def readable(value: float, unit: str) -> str:
    """Return a value with its unit, to three digits: 174 µm for 0.000174 m, but 0.25 m."""
    size = abs(value)
    # a prefix of kg^0.5 m would be ambiguous
    if unit in ("m", "m/s", "N", "W", "J") and size > 0.0 and not 0.1 <= size < 1000.0:
        power = 3 * floor(log10(float(f"{size:.3g}")) / 3)
        power = min(max(power, -9), 9)
        prefix = ("n", "µ", "m", "", "k", "M", "G")[power // 3 + 3]
        return f"{value / 10.0**power:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def units_of(scene_text: str) -> Units:
    """Return the [units] of a scene; SI units if it has none, or if there is no scene."""
    try:
        return Units(**tomllib.loads(scene_text).get("units", {}))
    except (tomllib.TOMLDecodeError, TypeError, SlipmodeError):
        return SI  # a scene of another version, or another program


def in_units(channel: Channel, units: Units) -> tuple[Channel, Floats]:
    """Return a channel with the units in which views show it, and factors of its values."""
    shown = {
        "rad/s": (units.frequency, float(units.of_frequency(1.0))),
        "m": (units.displacement, float(units.of_displacement(1.0))),
    }
    found = [shown.get(field.unit, (field.unit, 1.0)) for field in channel.fields]
    fields = [Field(name, unit) for name, (unit, _) in zip(channel.names, found, strict=True)]
    return replace(channel, fields=tuple(fields)), np.array([factor for _, factor in found])


def readable_scale(low: float, high: float) -> tuple[float, float] | None:
    """Return the ends of a scale with at least two labels for values from `low` to `high`.

    None for values that are all of one sign and far from zero: a viewer fits these better.
    """
    if not np.isfinite((low, high)).all() or low == high == 0.0:
        return None
    if low > 0.8 * high or high < 0.8 * low:
        return None
    low, high = _MARGIN * min(low, 0.0), _MARGIN * max(high, 0.0)
    unit = 10.0 ** floor(log10(max(high, -low)))
    if high - low > _LABELLED * unit:  # zero would have the only label: as far as the next power
        largest = _MARGIN * 10.0 * unit
        low = -largest if -low > 0.6 * largest else low
        high = largest if low == 0.0 or high > 0.6 * largest else high
    return low, high


def with_room(start: int, end: int) -> tuple[int, int]:
    """Return the times [ns] of a plot whose legend stands to the right of its curves."""
    return start, end + (end - start) // 2
