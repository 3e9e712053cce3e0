"""Files with measured records: .csv, .npz, .mat and universal files (.uff, .unv)."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.identification.records.measurement import Measurement, Record
from slipmode.rom.short_repr import frozen, short_list
from slipmode.rom.text import checked_line

_RATES = ("sample_rate", "sampling_rate", "fs")
_TIMES = ("time", "times", "t")
_UNEVEN = 1e-3  # largest deviation of a time step, relative to the mean step


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
    """Read decays that were recorded by one or more sensors.

    Parameters
    ----------
    files : str, Path, or sequence of these
        Names may have wildcards ("hit*.csv"). A .csv file (numbers separated by comma, semicolon
        or blank, with at most one header line) is one record: a column of times [s] named `time`
        or `t` (without a header line, a first column that rises in equal steps), if there is one,
        and a column per channel. In .npz and .mat files each array of
        (samples,) is a record of one channel and each array of (channels, samples) is a record;
        `sample_rate` [Hz] or `time` [s] may be there too. In universal files (.uff, .unv;
        needs `slipmode[uff]`) the time signals of data sets 58 are read; a node and direction that
        repeats starts a new record.
    quantity : str
        What is measured, such as "velocity".
    unit : str, optional
        Unit of all signals, such as "m/s". Required unless the files state it.
    channels : sequence of str or int, optional
        Channels to keep, by name or by position from 0. Default: all.
    sample_rate : float, optional
        [Hz]. Required if the files have neither a rate nor times.

    Returns
    -------
    Measurement

    Raises
    ------
    SlipmodeError
        If there is no such file, a file cannot be read, the unit or the sampling rate is missing
        or contradicts the file, or the records have different channels.
    """
    checked_line("quantity", quantity)
    if sample_rate is not None and not (np.ndim(sample_rate) == 0 and 0 < sample_rate < np.inf):
        raise SlipmodeError(f"sample_rate = {in_one_line(sample_rate)}: must be > 0 [Hz]")
    records: list[Record] = []
    names: tuple[str, ...] | None = None
    for path in found_files(files):
        content = _READERS[path.suffix.lower()](path)
        if unit is not None and content.unit is not None and unit != content.unit:
            raise SlipmodeError(f"unit = {unit!r}: {path} states {content.unit!r}")
        unit = content.unit if unit is None else unit
        if unit is None:
            raise SlipmodeError(f"unit: {path} does not state one; give unit=, such as 'm/s'")
        rate = _rate(path, content.sample_rate, sample_rate)
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
        raise SlipmodeError("files: no record was found in them")
    repeated = sorted({r.name for r in records if sum(r.name == s.name for s in records) > 1})
    if repeated:
        raise SlipmodeError(f"files: records {short_list(repeated)} occur more than once")
    return Measurement(records, quantity, checked_line("unit", unit), names)


def found_files(files: str | Path | Sequence[str | Path]) -> list[Path]:
    """Return the paths of readable files by names with or without wildcards; refuse others."""
    given = [files] if isinstance(files, str | Path) else list(files)
    paths: list[Path] = []
    for name in given:
        exact = Path(name)
        matches = [exact] if exact.is_file() else list(exact.parent.glob(exact.name or "."))
        if not matches:
            raise SlipmodeError(f"files: there is no file {name}")
        paths += sorted(matches, key=_natural)
    for path in paths:
        if path.suffix.lower() not in _READERS:
            raise SlipmodeError(f"{path}: the name must end in {', '.join(_READERS)}")
    return paths


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a key by which hit10 comes after hit9."""
    return [
        (int(part), "") if part.isdigit() else (-1, part)
        for part in re.split(r"(\d+)", str(path))
        if part
    ]


def _rate(path: Path, stated: float | None, given: float | None) -> float:
    if stated is None and given is None:
        raise SlipmodeError(
            f"sample_rate: {path} has neither a sampling rate nor times; give sample_rate= [Hz]"
        )
    if stated is not None and given is not None and abs(given / stated - 1.0) > _UNEVEN:
        raise SlipmodeError(f"sample_rate = {given:g} Hz: {path} states {stated:g} Hz")
    return float(given if stated is None else stated)  # type: ignore[arg-type]


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


def _rises_evenly(times: Floats) -> bool:
    steps = np.diff(times)
    step = float(np.mean(steps)) if steps.size else 0.0
    return bool(np.isfinite(step) and step > 0.0 and np.abs(steps - step).max() <= _UNEVEN * step)


def _rate_of_times(path: Path, times: Floats) -> float:
    if not _rises_evenly(times):
        raise SlipmodeError(
            f"{path}: times must rise in equal steps [s]; resample the signal to a constant rate"
        )
    return float((times.size - 1) / (times[-1] - times[0]))


def read_arrays(path: Path) -> dict[str, Any]:
    """Return the columns of a .csv file, or the arrays of an .npz or .mat file, by name."""
    suffix = path.suffix.lower()
    if suffix not in _ARRAYS:
        raise SlipmodeError(f"{path}: the name must end in {', '.join(_ARRAYS)}")
    return _ARRAYS[suffix](path)


def _csv_columns(path: Path) -> dict[str, Any]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SlipmodeError(f"{path}: cannot be read as text") from error
    lines = [line for line in lines if line.strip() and not line.startswith("#")]
    separator = next((c for c in ",;\t" if lines and c in lines[-1]), None)
    rows = [line.split(separator) for line in lines]
    header = rows.pop(0) if rows and not _are_numbers(rows[0]) else None
    try:
        table = np.array(rows, dtype=float).T  # "nan" and empty cells: see below
    except ValueError:
        wrong = next((k for k, row in enumerate(rows) if not _are_numbers(row)), len(rows))
        raise SlipmodeError(
            f"{path}: line {wrong + 1 + (header is not None)} must have one number a column, "
            "decimal points, and columns separated by comma, semicolon, tab or blank"
        ) from None
    if table.ndim != 2 or table.shape[1] < 2:
        raise SlipmodeError(f"{path}: has no samples")
    names = [name.strip().strip('"') for name in header] if header else []
    if len(set(names)) != len(table):
        timed = len(table) > 1 and _rises_evenly(table[0])
        names = [f"channel {k}" for k in range(len(table) - timed)]
        names = ["time", *names] if timed else names
    return dict(zip(names, table, strict=True))


def _are_numbers(row: Sequence[str]) -> bool:
    try:
        np.array(row, dtype=float)
    except ValueError:
        return False
    return True


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
        plain = re.split(r"[ \[(]", name.lower())[0]
        if plain in _RATES and array.ndim == 0:
            rate = float(array)
        elif plain in _TIMES and array.ndim == 1:
            rate = _rate_of_times(path, array)
        elif one_record:
            columns[name] = array
        elif array.ndim == 1 and array.size > 1:
            records[name] = {"channel 0": array}
        elif array.ndim == 2:
            records[name] = {f"channel {k}": row for k, row in enumerate(array)}
    if one_record:
        records = {path.stem: columns}
    if rate is not None and not 0.0 < rate < np.inf:
        raise SlipmodeError(f"{path}: sample_rate = {rate:g}: must be > 0 [Hz]")
    if not any(records.values()):
        raise SlipmodeError(f"{path}: has no signals: arrays of (samples,) or (channels, samples)")
    return _Content(records, rate)


def _npz_arrays(path: Path) -> dict[str, Any]:
    try:
        with np.load(path, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except Exception as error:  # damaged files make zipfile, zlib and numpy raise nearly anything
        raise SlipmodeError(f"{path}: is not a readable .npz file") from error


def _mat_arrays(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        arrays = loadmat(path)
    except NotImplementedError as error:
        raise SlipmodeError(f"{path}: is of MATLAB 7.3; save it with -v7") from error
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable .mat file") from error
    return {k: v for k, v in arrays.items() if not k.startswith("__")}


def _read_arrays(path: Path) -> _Content:
    arrays = read_arrays(path)
    return _content(path, arrays, one_record=_ARRAYS[path.suffix.lower()] is _csv_columns)


def _read_uff(path: Path) -> _Content:
    pyuff = extra("pyuff", "uff")
    try:
        file = pyuff.UFF(str(path))
        sets = [file.read_sets(int(k)) for k in np.flatnonzero(file.get_set_types() == 58)]
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable universal file") from error
    records: list[dict[str, Floats]] = []
    rates, units = set(), set()
    for each in sets:
        if each["func_type"] != 1:  # time response
            continue
        channel = f"{each['rsp_node']}:{each['rsp_dir']:+d}"
        if not records or channel in records[-1]:
            records.append({})
        records[-1][channel] = np.asarray(each["data"], dtype=float)
        rates.add(_rate_of_times(path, np.asarray(each["x"], dtype=float)))
        units.add(str(each["ordinate_axis_units_lab"]).strip())
    if not records:
        raise SlipmodeError(f"{path}: has no time signals in data sets 58")
    if max(rates) > (1.0 + _UNEVEN) * min(rates) or len(units) > 1:
        raise SlipmodeError(f"{path}: all time signals must have one sampling rate and one unit")
    unit = units.pop()
    stem = path.stem
    named = {stem if len(records) == 1 else f"{stem}_{k}": r for k, r in enumerate(records, 1)}
    return _Content(named, rates.pop(), None if unit.upper() in ("", "NONE") else unit)


_ARRAYS: dict[str, Callable[[Path], dict[str, Any]]] = {
    ".csv": _csv_columns,
    ".txt": _csv_columns,
    ".npz": _npz_arrays,
    ".mat": _mat_arrays,
}
_READERS: dict[str, Callable[[Path], _Content]] = {
    **dict.fromkeys(_ARRAYS, _read_arrays),
    ".uff": _read_uff,
    ".unv": _read_uff,
}
