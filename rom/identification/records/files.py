"""Measured arrays in files: .csv, .npz and .mat, and sampling rates."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.stored_arrays import open_npz

TEXTS, UNIVERSAL = (".csv", ".txt"), (".uff", ".unv")  # suffixes
_RATES = ("sample_rate", "sampling_rate", "fs")
_TIMES = ("time", "times", "t")
UNEVEN = 1e-3  # largest deviation of a time step, relative to the mean step


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
        if path.suffix.lower() not in (*_ARRAYS, *UNIVERSAL):
            allowed = ", ".join((*_ARRAYS, *UNIVERSAL))
            raise SlipmodeError(f"{path}: the name must end in {allowed}")
    return paths


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a key by which hit10 comes after hit9."""
    return [
        (int(part), "") if part.isdigit() else (-1, part)
        for part in re.split(r"(\d+)", str(path))
        if part
    ]


def sampling_rate(path: Path, stated: float | None, given: Any) -> float:
    """Return the sampling rate [Hz] that a file states or that is given; refuse contradictions."""
    if given is not None and not (np.ndim(given) == 0 and 0 < given < np.inf):
        raise SlipmodeError(f"sample_rate = {in_one_line(given)}: must be > 0 [Hz]")
    if stated is None and given is None:
        raise SlipmodeError(
            f"sample_rate: {path} has neither a sampling rate nor times; give sample_rate= [Hz]"
        )
    if stated is not None and given is not None and abs(given / stated - 1.0) > UNEVEN:
        raise SlipmodeError(f"sample_rate = {given:g} Hz: must be {stated:g} Hz, as {path} states")
    return float(given if stated is None else stated)


def stated_rate(path: Path, name: str, array: Floats) -> float | None:
    """Return the sampling rate [Hz] by an array that is a rate or times; None if it is neither."""
    plain = re.split(r"[ \[(]", name.lower())[0]
    if plain in _RATES and array.ndim == 0:
        rate = float(array)
        if not 0.0 < rate < np.inf:
            raise SlipmodeError(f"{path}: sample_rate = {rate:g}: must be > 0 [Hz]")
        return rate
    return rate_of_times(path, array) if plain in _TIMES and array.ndim == 1 else None


def _rises_evenly(times: Floats) -> bool:
    steps = np.diff(times)
    step = float(np.mean(steps)) if steps.size else 0.0
    return bool(np.isfinite(step) and step > 0.0 and np.abs(steps - step).max() <= UNEVEN * step)


def rate_of_times(path: Path, times: Floats) -> float:
    """Return the sampling rate [Hz] of times [s] in equal steps; refuse others."""
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


def _npz_arrays(path: Path) -> dict[str, Any]:
    try:
        with open_npz(path) as stored:
            return {name: stored[name] for name in stored.files}
    except Exception as error:  # damaged files make zipfile, zlib and numpy raise nearly anything
        reason = " ".join(str(error).split())
        raise SlipmodeError(f"{path}: is not a readable .npz file: {reason}") from error


def _mat_arrays(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        arrays = loadmat(path)
    except NotImplementedError as error:
        raise SlipmodeError(f"{path}: is a MATLAB -v7.3 file; save it with -v7") from error
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable .mat file") from error
    return {k: v for k, v in arrays.items() if not k.startswith("__")}


_ARRAYS: dict[str, Callable[[Path], dict[str, Any]]] = {
    **dict.fromkeys(TEXTS, _csv_columns),
    ".npz": _npz_arrays,
    ".mat": _mat_arrays,
}
