"""Files with measured records: .csv, .npz, .mat and universal files (.uff, .unv)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.records.files import (
    TEXTS,
    UNIVERSAL,
    found_files,
    read_arrays,
    sampling_rate,
    stated_rate,
)
from slipmode.rom.identification.records.measurement import Measurement, Record
from slipmode.rom.identification.records.universal import read_universal
from slipmode.rom.short_repr import frozen, short_list
from slipmode.rom.text import checked_line


@frozen
class _Content:
    """Records of a file: signals by channel, each of (samples,)."""

    records: Mapping[str, Mapping[str, Floats]]
    sample_rate: float | None
    unit: str | None = None


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

        - A .csv file is one record: numbers separated by comma, semicolon or blank, with at most
          one header line. It has one column per channel and an optional column of times [s], named
          `time` or `t`. Without a header line, a first column that rises in equal steps is the
          time.
        - In a .npz or .mat file each (samples,) array is a record of one channel, and each
          (channels, samples) array is a record of several channels. `sample_rate` [Hz] or `time`
          [s] may be in the file.
        - In a universal file (.uff, .unv; needs `slipmode[uff]`) the time signals of data sets 58
          are read. A node and direction that repeats starts a new record.
    quantity : str
        Measured quantity, such as "velocity".
    unit : str, optional
        Unit of all signals, such as "m/s". Required unless the files state it.
    channels : sequence of str or int, optional
        Channels to keep, by name or by position from 0. Default: all.
    sample_rate : float, optional
        Sampling rate [Hz]. Required if the files have neither a rate nor times.

    Returns
    -------
    Measurement
        Records of all files.

    Raises
    ------
    SlipmodeError
        If a file does not exist or cannot be read, the unit or the sampling rate is missing or
        contradicts the file, or the records have different channels.
    """
    checked_line("quantity", quantity)
    records: list[Record] = []
    names: tuple[str, ...] | None = None
    for path in found_files(files):
        content = _read(path)
        if unit is not None and content.unit is not None and unit != content.unit:
            raise SlipmodeError(f"unit = {unit!r}: must be {content.unit!r}, as {path} states")
        unit = content.unit if unit is None else unit
        if unit is None:
            raise SlipmodeError(f"unit: {path} does not state one; give unit=, such as 'm/s'")
        rate = sampling_rate(path, content.sample_rate, sample_rate)
        for name, signals in content.records.items():
            kept = _chosen(path, tuple(signals), channels)
            if names is None:
                names = kept
            if kept != names:
                raise SlipmodeError(
                    f"{path}: record {name} has channels {short_list(kept)}, the first record "
                    f"has {short_list(names)}; choose common ones by channels="
                )
            lengths = {signals[channel].size for channel in kept}
            if len(lengths) > 1:
                raise SlipmodeError(f"{path}: channels of record {name} differ in length")
            signal = np.stack([signals[channel] for channel in kept])
            records.append(Record(name, signal, rate))
    if not records or names is None or unit is None:
        raise SlipmodeError("files: contain no record")
    repeated = sorted({r.name for r in records if sum(r.name == s.name for s in records) > 1})
    if repeated:
        raise SlipmodeError(f"files: records {short_list(repeated)} occur more than once")
    return Measurement(records, quantity, checked_line("unit", unit), names)


def _chosen(
    path: Path, names: tuple[str, ...], channels: Sequence[str | int] | None
) -> tuple[str, ...]:
    if channels is None:
        return names
    kept = []
    for channel in channels:
        if isinstance(channel, int) and -len(names) <= channel < len(names):
            kept.append(names[channel])
        elif channel in names:
            kept.append(str(channel))
        else:
            raise SlipmodeError(f"channels: {path} has {short_list(names)}, not {channel!r}")
    if not kept or len(set(kept)) < len(kept):
        raise SlipmodeError("channels: must name at least one channel, each once")
    return tuple(kept)


def _content(path: Path, arrays: Mapping[str, Any], one_record: bool = False) -> _Content:
    """Return the records among named arrays, and the rate that is with them."""
    rate: float | None = None
    records: dict[str, dict[str, Floats]] = {}
    columns: dict[str, Floats] = {}
    for name, given in arrays.items():
        array = np.asarray(given)
        if array.dtype.kind not in "fiu":
            continue
        array = np.squeeze(array).astype(float)
        stated = stated_rate(path, name, array)
        if stated is not None:
            rate = stated
        elif one_record:
            columns[name] = array
        elif array.ndim == 1 and array.size > 1:
            records[name] = {"channel 0": array}
        elif array.ndim == 2:
            records[name] = {f"channel {k}": row for k, row in enumerate(array)}
    if one_record:
        records = {path.stem: columns}
    if not any(records.values()):
        raise SlipmodeError(f"{path}: has no signals: arrays of (samples,) or (channels, samples)")
    return _Content(records, rate)


def _read(path: Path) -> _Content:
    if path.suffix.lower() in UNIVERSAL:
        return _read_universal(path)
    return _content(path, read_arrays(path), one_record=path.suffix.lower() in TEXTS)


def _read_universal(path: Path) -> _Content:
    read, rate = read_universal(path)
    records = {
        name: {key: channel for key, channel in record.items() if not channel.is_force}
        for name, record in read.items()
    }
    units = {channel.unit for record in records.values() for channel in record.values()}
    if len(units) > 1:
        raise SlipmodeError(
            f"{path}: all time signals must have one unit, got {short_list(sorted(units))}"
        )
    signals = {
        name: {key: channel.signal for key, channel in record.items()}
        for name, record in records.items()
    }
    return _Content(signals, rate, units.pop() or None)
