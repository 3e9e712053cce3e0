"""Recordings in the units of their scene: files keep rad/s and m, views show what it asks for."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.units import SI, Units
from slipmode.runner.recording.channels import Channel, Field


def units_of(scene_text: str) -> Units:
    """What [units] of a scene asks for; SI where there is none, or no scene."""
    try:
        return Units(**tomllib.loads(scene_text).get("units", {}))
    except (tomllib.TOMLDecodeError, TypeError, SlipmodeError):
        return SI  # of another version, or another program


def in_units(channel: Channel, units: Units) -> Channel:
    """A channel as it is shown."""
    shown = {"rad/s": units.frequency, "m": units.displacement}
    fields = (Field(field.name, shown.get(field.unit, field.unit)) for field in channel.fields)
    return replace(channel, fields=tuple(fields))


def factors(channel: Channel, units: Units) -> Floats:
    """What recorded values of a channel are multiplied by to be shown, (n_fields,)."""
    per = {"rad/s": float(units.of_frequency(1.0)), "m": float(units.of_displacement(1.0))}
    return np.array([per.get(field.unit, 1.0) for field in channel.fields])
