"""Numbers, units and scales of views, whatever program draws them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil, log10
from typing import NamedTuple

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.units import SI, Units
from slipmode.runner.recording.channels import BAND, OTHER, Channel, Field, Moved
from slipmode.runner.recording.record import Header
from slipmode.runner.view.plots import DISPLACEMENT


class Shown(NamedTuple):
    """A channel as views show it, and how its values follow from a recorded channel."""

    channel: Channel
    source: Channel
    columns: tuple[int, ...]  # Of the source
    factors: Floats  # Of their values


def shown_channels(channels: Sequence[Channel], header: Header) -> list[Shown]:
    """Return the channels of a recording in the units of its views.

    The units are [units] of the scene; those that it leaves out are Hz, and um, mm or m. After the
    modal amplitudes come the displacements of the DOFs that the modes move most, if the header
    has them.
    """
    modes = [channel for channel in channels if channel.topic == "/modes"]
    names = [name.removesuffix("_abs") for each in modes for name in each.names]
    found = {name: Moved.parse(header.run.get(f"mode_{name}", "")) for name in names}
    moved = {name: each for name, each in found.items() if each}
    shown = []
    for channel in channels:
        sizes = [m.shape if channel.topic == "/elastic" else m.contacts for m in moved.values()]
        reach = 2.0 * sum(m.amplitude * x for m, x in zip(moved.values(), sizes, strict=True))
        shown.append(_in_units(channel, units_of(header.scene_text, reach)))
        if channel.topic == "/modes" and moved:
            shown.append(_displacement(channel, moved, header.scene_text))
    return shown


def units_of(scene_text: str, reach: float) -> Units:
    """Return the units of a scene's views; those that [units] leaves out suit displacements.

    `reach` is the largest expected displacement [m], or 0 if it is not known.
    """
    length = "um" if 0.0 < reach < 1e-4 else "mm" if reach < 1.0 else "m"
    usual = {"frequency": "Hz", "displacement": length}
    try:
        return Units(**usual | tomllib.loads(scene_text).get("units", {}))
    except (tomllib.TOMLDecodeError, TypeError, SlipmodeError):
        return SI  # a scene of another version, or another program


def _in_units(channel: Channel, units: Units) -> Shown:
    per = {
        "rad/s": (units.frequency, float(units.of_frequency(1.0))),
        "m": (units.displacement, float(units.of_displacement(1.0))),
    }
    if channel.topic.startswith(OTHER):
        per = {}
    found = [per.get(field.unit, (field.unit, 1.0)) for field in channel.fields]
    fields = [Field(name, unit) for name, (unit, _) in zip(channel.names, found, strict=True)]
    factors = np.array([factor for _, factor in found])
    return Shown(replace(channel, fields=tuple(fields)), channel, (*range(len(found)),), factors)


def _displacement(modes: Channel, moved: Mapping[str, Moved], scene_text: str) -> Shown:
    """Return the amplitudes of displacements, 2 |phi a|."""
    columns, fields, factors = [], [], []
    for mode, each in moved.items():
        on_tone = [m.shape * m.amplitude for name, m in moved.items() if name[0] == mode[0]]
        units = units_of(scene_text, 2.0 * max(on_tone))
        parts = {f"{mode}_abs_{percent}": f", {percent} % of the samples" for percent in BAND}
        for name, words in ({f"{mode}_abs": ""} | parts).items():
            if name in modes.names:
                columns.append(modes.names.index(name))
                fields.append(Field(f"{mode} at DOF {each.dof}{words}", units.displacement))
                factors.append(2.0 * float(units.of_displacement(each.shape)))
    words = "Displacement amplitude of each mode at the DOF that it moves most"
    channel = Channel(DISPLACEMENT, tuple(fields), words)
    return Shown(channel, modes, tuple(columns), np.array(factors))


def readable_scale(low: float, high: float) -> tuple[float, float] | None:
    """Return the ends of a scale with zero for values from `low` to `high`.

    None for values that are all of one sign and far from zero: a viewer fits these better.
    """
    if low >= 0.8 * high or high <= 0.8 * low:
        return None
    return _end(min(low, 0.0)), _end(max(high, 0.0))


def _end(value: float) -> float:
    """Return the end of a scale; the next power of ten, if near, is on it for its label."""
    power = 10.0 ** ceil(log10(abs(value) or 1.0))
    return 1.05 * float(np.sign(value)) * (power if abs(value) > 0.7 * power else abs(value))
