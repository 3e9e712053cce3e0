"""Files with measured records: text, .npz, .mat and universal files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import frozen, short_list
from slipmode.rom.identification.records.fields import Field, Group, renamed, signals
from slipmode.rom.identification.records.files import distinct_names, found_files, read_groups
from slipmode.rom.identification.records.measurement import Measurement, Record
from slipmode.rom.slow import parse_unit
from slipmode.rom.storage import checked_line


@frozen
class _Read:
    """A record as it is in a file: signals of (samples,) by channel."""

    path: Path
    name: str
    channels: Sequence[Field]
    sample_rate: float
    notes: tuple[str, ...]


def read_measurement(
    files: str | Path | Sequence[str | Path],
    *,
    quantity: str,
    unit: str | None = None,
    channels: Sequence[str | int] | None = None,
    sample_rate: float | None = None,
) -> Measurement:
    """Return measured decays from files.

    Parameters
    ----------
    files : str, Path, or sequence of these
        Names of files, also with wildcards ("hit*.csv"):

        - A text file (.csv, .txt, .tsv, .dat, .asc, .lvm, .prn) is one record, with a column per
          channel and an optional column of times, named `time` or `t` or in a unit of time.
          Separator, decimal mark, encoding, names, and units (in brackets or in a line of their
          own) are found, and lines above and below the numbers are allowed. A first column without
          name that rises in equal steps is the time.
        - A .npz or .mat file has arrays of (samples,) or (channels, samples), and `time` [s] or
          `sample_rate` [Hz]. If several files have the same names of arrays, or the names differ
          by more than numbers, a file is one record and its arrays are channels. Otherwise each
          array is a record. Structures are records.
        - In a universal file (.uff, .unv; needs `slipmode[uff]`) the time signals of data sets 58
          are read. Channels are distinguished by node, direction, entity, label and ID. A channel
          that repeats, or another time stamp, starts a new record.
    quantity : str
        Measured quantity, such as "velocity".
    unit : str, optional
        Unit of all signals, such as "m/s". It overrides units in the files. Default: as the files
        state.
    channels : sequence of str or int, optional
        Channels to keep, by name or by position from 0. Default: all but forces.
    sample_rate : float, optional
        Sampling rate [Hz]. It overrides times and rates in the files. Required if the files have
        neither.

    Returns
    -------
    Measurement
        Records of all files. Their notes say what was ambiguous, missing or overridden.

    Raises
    ------
    SlipmodeError
        If a file does not exist or cannot be read, the unit or the sampling rate is missing, or
        the records have different channels.
    """
    checked_line("quantity", quantity)
    groups = [(path, group) for path in found_files(files) for group in read_groups(path)]
    kept = [
        replace(each, channels=_chosen(each, channels))
        for path, group in records_of(groups, channels)
        for each in [_Read(path, group.name, *signals(path, group, sample_rate))]
    ]
    if not kept:
        raise SlipmodeError("files: contain no record")
    names = [field.name for field in kept[0].channels]
    for each in kept:
        own = [field.name for field in each.channels]
        if own != names:
            raise SlipmodeError(
                f"{each.path}: record {each.name} has channels {short_list(own)}, the first "
                f"record has {short_list(names)}; choose common ones by channels="
            )
        if len({field.values.size for field in each.channels}) > 1:
            raise SlipmodeError(f"{each.path}: channels of record {each.name} differ in length")
    common = _unit(kept, unit)
    records = [
        _record(each, name, common, unit)
        for each, name in zip(kept, distinct_names([(e.path, e.name) for e in kept]), strict=True)
    ]
    return Measurement(records, quantity, common, tuple(names))


def records_of(
    groups: Sequence[tuple[Path, Group]], channels: Sequence[str | int] | None
) -> Iterator[tuple[Path, Group]]:
    """Yield the records of files, each a group of (samples,) arrays."""
    names = [
        name for _, group in groups if group.arrays for name in {f.name for f in _data(group)}
    ]
    repeated = {name for name in names if names.count(name) > 1}
    for path, group in groups:
        if not group.arrays:
            yield path, group
            continue
        data = _data(group)
        own = [field.name for field in data]
        shared = any(name in repeated for name in own) or set(own) <= set(channels or ())
        others = [field for field in group.fields if field not in data]
        notes = group.notes
        alike = len({re.sub(r"\d+", "", name) for name in own}) < len(own)
        shapes = {field.values.shape for field in data}
        many = alike or len(shapes) > 1 or any(len(shape) > 1 for shape in shapes)
        if len(data) > 1 and not shared and len(shapes) == 1:
            means = "records" if many else "channels of one record"
            notes = (
                f"the arrays {short_list(own)} are {means}; if they are not, store an array "
                "(channels, samples) for each blow, or one file",
            )
        if shared or (len(data) > 1 and not many):
            rows = [row for field in data for row in _rows(field, others, len(data) > 1)]
            yield path, replace(group, fields=[*others, *rows], notes=notes)
            continue
        for field in data:
            rows = [replace(row, name="") for row in _rows(field, others, False)]
            yield path, replace(group, name=field.name, fields=[*others, *rows], notes=notes)
            notes = group.notes  # one record says it for all


def _data(group: Group) -> list[Field]:
    """Return the arrays of a group that are not times."""
    return [f for f in group.fields if f.values.ndim in (1, 2) and f.kind != "time"]


def _rows(field: Field, others: Sequence[Field], named: bool) -> list[Field]:
    """Return the channels of an array, of which the time vector says which axis is time."""
    if field.values.ndim == 1:
        return [field]
    samples = next((each.values.size for each in others if each.kind == "time"), None)
    rows = field.values
    size = rows.shape
    if size[0] > size[1] if samples is None else size[0] == samples != size[1]:
        rows = rows.T
    return [
        replace(field, name=f"{field.name} {k}" if named else "", values=row)
        for k, row in enumerate(rows)
    ]


def _chosen(read: _Read, channels: Sequence[str | int] | None) -> list[Field]:
    """Return the chosen channels, by default all but forces."""
    every = renamed(read.channels)
    if not every:
        raise SlipmodeError(f"{read.path}: has no signals besides the times")
    usual = [each for each in every if each.kind != "force"] or every
    if channels is None:
        return usual
    by_name: dict[str | int, Field] = {each.name: each for each in every}
    for k, each in enumerate(usual):
        by_name |= {k: each, k - len(usual): each}
    for key in channels:
        if key not in by_name:
            raise SlipmodeError(
                f"channels: {read.path} has {short_list(f.name for f in every)}, not {key!r}"
            )
    kept = [by_name[key] for key in channels]
    if not kept or len({each.name for each in kept}) < len(kept):
        raise SlipmodeError("channels: must name at least one channel, each once")
    return kept


def _unit(read: Sequence[_Read], given: str | None) -> str:
    """Return the unit of all records; refuse units that are missing or of several quantities."""
    if given is not None:
        unit = parse_unit(given)
        return unit.name if unit else checked_line("unit", given)
    first = read[0].channels[0].unit
    for each in read:
        for channel in each.channels:
            if not channel.unit:
                raise SlipmodeError(
                    f"unit: {each.path} does not state one; give unit=, such as 'm/s'"
                )
            units = parse_unit(first), parse_unit(channel.unit)
            same = units[0] and units[1] and units[0].quantity == units[1].quantity != ""
            if channel.unit != first and not same:
                raise SlipmodeError(
                    f"{each.path}: all signals must have one unit, got {first} and "
                    f"{channel.unit} for {channel.name}; choose channels of one quantity by "
                    "channels="
                )
    return checked_line("unit", first)


def _record(read: _Read, name: str, unit: str, given: str | None) -> Record:
    """Return a record in the unit of the measurement."""
    notes, rows = list(read.notes), []
    for channel in read.channels:
        own, common = parse_unit(channel.unit), parse_unit(unit)
        scale = own.size / common.size if own and common and given is None else 1.0
        rows.append(scale * channel.values)
        if given is not None and channel.unit not in ("", unit):
            notes.append(f"{channel.name} is in {unit} as given; the file states {channel.unit}")
    return Record(name, np.stack(rows), read.sample_rate, tuple(notes))
