"""Files with sine tests: text, .npz, .mat and universal files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from math import pi
from pathlib import Path
from typing import Final

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import in_one_line, naming, short_list
from slipmode.rom.identification.models.sensor_units import QUANTITIES
from slipmode.rom.identification.records.fields import Field, Group, renamed, signals
from slipmode.rom.identification.records.files import (
    UNIVERSAL,
    distinct_names,
    found_files,
    read_groups,
)
from slipmode.rom.identification.records.units import FORCE, AllowedUnits, override_note
from slipmode.rom.identification.sine.responses import ORDERS, SineTest, SineTests, checked
from slipmode.rom.identification.sine.signals import demodulate_sine_test
from slipmode.rom.slow import Unit

COLUMNS: Final = ("frequency", "force", "amplitude", "phase")
_RESPONSE: Final = AllowedUnits(
    "unit", QUANTITIES, "m, m/s, m/s^2 (also with prefix m, u or n) or g"
)
_ALLOWED: Final = {"force": FORCE, "response": _RESPONSE}
# Largest phase without a unit that may be in radians: two turns.
_LARGEST_PHASE = 4.0 * pi


def read_sine_tests(
    files: str | Path | Sequence[str | Path],
    *,
    unit: str | None = None,
    force_unit: str | None = None,
    sample_rate: float | None = None,
    channels: Sequence[str] | None = None,
) -> SineTests:
    """Return sine sweeps or stepped sine tests from files.

    Parameters
    ----------
    files : str, Path, or sequence of these
        Names of files, also with wildcards ("level*.csv"):

        - A text file or .npz file is one test. Time signals are the columns or arrays `force` and
          `response`, with `time` [s] or `sample_rate` [Hz]. Steady responses are `frequency` [Hz],
          `force`, `amplitude` and `phase` relative to the force [rad]. A unit may follow the name,
          as in `force [kN]`, or stand in a line of its own. Text is read as by
          `rom.read_measurement`.
        - A .mat file has these arrays, or any number of structures with these fields.
        - A universal file (.uff, .unv; needs `slipmode[uff]`) has time signals in data sets 58. A
          channel that repeats starts a new test.
    unit : str, optional
        Unit of the response, such as "m/s^2", "mm/s" or "g". It overrides the files. Required
        unless the files state it.
    force_unit : str, optional
        Unit of the force, such as "N" or "kN". It overrides the files. Required unless the files
        state it.
    sample_rate : float, optional
        Sampling rate of time signals [Hz]. It overrides the files. Required if the files have
        neither a rate nor times.
    channels : sequence of two str, optional
        Names of the time signals of force and response. Default: "force" and "response", or the
        only force, by its unit or kind of channel, and the only other signal.

    Returns
    -------
    SineTests
        All tests in N and m, m/s or m/s^2; time signals are demodulated by
        `rom.demodulate_sine_test`.

    Raises
    ------
    SlipmodeError
        If a file does not exist or cannot be read, or has no force. If a unit or the sampling rate
        is missing or not allowed, or signals are no sine tests.
    """
    if channels is not None and (isinstance(channels, str) or len(channels) != 2):
        raise SlipmodeError(
            f"channels = {in_one_line(channels)}: must be the names of force and response"
        )
    given = {"force": force_unit, "response": unit}
    found = []
    for path in found_files(files):
        groups = read_groups(path)
        chosen = [(g, columns) for g in groups if (columns := _columns(path, g, channels))]
        if not chosen:
            raise _missing(path, groups[0], channels)
        found += [(path, *each) for each in chosen]
    names = distinct_names([(path, group.name) for path, group, _ in found])
    tests, quantities = [], {}
    for name, (path, group, columns) in zip(names, found, strict=True):
        units = {
            key: _ALLOWED[key].unit(path, key, columns[key], each) for key, each in given.items()
        }
        quantities[units["response"].quantity] = path
        test = _test(path, name, group, columns, units, sample_rate)
        overridden = (override_note(columns[key], unit) for key, unit in units.items())
        tests.append(replace(test, notes=(*test.notes, *chain(*overridden))))
    if len(quantities) > 1:
        one = " and ".join(f"{path} has a {key}" for key, path in quantities.items())
        raise SlipmodeError(f"files: must have responses of one quantity, but {one}")
    (quantity,) = quantities
    return SineTests(tests, list(ORDERS)[QUANTITIES.index(quantity)])


def _columns(path: Path, group: Group, channels: Sequence[str] | None) -> dict[str, Field]:
    """Return frequency, force, response and phase, or force and response; empty for others."""
    fields = {each.name.lower(): each for each in renamed(group.fields)}
    if channels is not None:
        missing = [name for name in channels if name.lower() not in fields]
        if missing and path.suffix.lower() in UNIVERSAL:
            raise SlipmodeError(f"channels: {path} has {short_list(fields)}, not {missing[0]!r}")
        chosen = zip(_ALLOWED, channels, strict=True)
        return {} if missing else {key: fields[name.lower()] for key, name in chosen}
    by_kind = {each.kind: each for each in reversed(group.fields)} | fields
    if all(key in by_kind for key in COLUMNS):
        return {"response" if key == "amplitude" else key: by_kind[key] for key in COLUMNS}
    if "force" in fields and "response" in fields:
        return {key: fields[key] for key in _ALLOWED}
    forces, others = _by_force(group)
    return {"force": forces[0], "response": others[0]} if len(forces) == len(others) == 1 else {}


def _by_force(group: Group) -> tuple[list[Field], list[Field]]:
    """Return the forces of a group, and its other signals."""
    fields = renamed(group.fields)
    return [e for e in fields if e.kind == "force"], [e for e in fields if e.kind == ""]


def _missing(path: Path, group: Group, channels: Sequence[str] | None) -> SlipmodeError:
    """Return the refusal of a file without the columns of a sine test."""
    if path.suffix.lower() in UNIVERSAL:
        forces, others = (short_list(e.name for e in each) for each in _by_force(group))
        return SlipmodeError(
            f"{path}: {group.name or path.stem} has the forces {forces or 'none'} and the "
            f"responses {others or 'none'}; choose one of each by channels="
        )
    allowed = [COLUMNS, tuple(_ALLOWED)] if channels is None else [channels]
    needed = ", or the time signals ".join(", ".join(each) for each in allowed)
    names = short_list(each.name for each in renamed(group.fields))
    return SlipmodeError(f"{path}: must have {needed}, got {names}; the force must be measured")


def _test(
    path: Path,
    name: str,
    group: Group,
    columns: Mapping[str, Field],
    units: Mapping[str, Unit],
    sample_rate: float | None,
) -> SineTest:
    """Return a test of columns, with force and response in units of size 1."""
    if len({each.values.size for each in columns.values()}) > 1:
        names = ", ".join(each.name for each in columns.values())
        raise SlipmodeError(f"{path}: {names} must have one length")
    force, response = (units[key].size * np.ravel(columns[key].values) for key in _ALLOWED)
    if "frequency" not in columns:
        _, rate, notes = signals(path, group, sample_rate)
        return replace(demodulate_sine_test(name, force, response, rate), notes=notes)
    with naming(path):
        frequency = np.ravel(columns["frequency"].converted("frequency", 2.0 * pi).values)
        phase = np.ravel(columns["phase"].converted("angle").values)
    if not columns["phase"].unit and np.abs(phase).max() > _LARGEST_PHASE:
        raise SlipmodeError(
            f"{path}: phase reaches {np.abs(phase).max():.4g} and has no unit; write phase [deg] "
            "or phase [rad]"
        )
    response = response * np.exp(1j * phase)
    return checked(SineTest(name, frequency, force.astype(complex), response, notes=group.notes))
