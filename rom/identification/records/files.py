"""Measured arrays in files: text, .npz, .mat and universal files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import one_line_reason, short_list
from slipmode.rom.identification.records.fields import Field, Group, name_and_unit
from slipmode.rom.identification.records.text_table import read_text_table
from slipmode.rom.identification.records.universal import read_universal
from slipmode.rom.storage import open_npz

TEXTS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".lvm", ".prn")
UNIVERSAL = (".uff", ".unv", ".uf")
_SUFFIXES = (*TEXTS, ".npz", ".mat", *UNIVERSAL)


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
        if path.suffix.lower() not in _SUFFIXES:
            raise SlipmodeError(f"{path}: the name must end in {', '.join(_SUFFIXES)}")
    return paths


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a key by which hit2 comes before hit10."""
    return [
        (int(part), "") if part.isdigit() else (-1, part)
        for part in re.split(r"(\d+)", str(path))
        if part
    ]


def distinct_names(named: Sequence[tuple[Path, str]]) -> list[str]:
    """Return the names of records in files: their own, or with the file if these repeat."""
    names = [name or path.stem for path, name in named]
    if len(set(names)) < len(names):
        paths = [path for path, _ in named]
        names = [
            path.stem if paths.count(path) == 1 else f"{path.stem}_{name}"
            for path, name in zip(paths, names, strict=True)
        ]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise SlipmodeError(f"files: records {short_list(repeated)} occur more than once")
    return names


def read_groups(path: Path) -> list[Group]:
    """Return the arrays of a file that belong together: a table, structures, blows."""
    suffix = path.suffix.lower()
    if suffix in UNIVERSAL:
        return read_universal(path)
    if suffix in TEXTS:
        return [read_text_table(path)]
    groups = list(_groups("", _npz_arrays(path) if suffix == ".npz" else _mat_arrays(path)))
    if not groups:
        raise SlipmodeError(f"{path}: has no arrays of numbers")
    return groups


def _npz_arrays(path: Path) -> dict[str, Any]:
    try:
        with open_npz(path) as stored:
            return {name: stored[name] for name in stored.files}
    except Exception as error:  # damaged files make zipfile, zlib and numpy raise nearly anything
        reason = one_line_reason(error)
        raise SlipmodeError(f"{path}: is not a readable .npz file: {reason}") from error


def _mat_arrays(path: Path) -> dict[str, Any]:

    try:
        arrays = scipy.io.loadmat(path)
    except NotImplementedError as error:
        raise SlipmodeError(f"{path}: is a MATLAB -v7.3 file; save it with -v7") from error
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable .mat file") from error
    return {k: v for k, v in arrays.items() if not k.startswith("__")}


def _groups(name: str, given: Any) -> Iterator[Group]:
    """Yield the structures with arrays of numbers at any depth, numbered from 1 in arrays."""
    if isinstance(given, Mapping):
        fields = _fields(given)
        if any(field.values.size > 1 for field in fields):
            yield Group(name, fields, arrays=True)
        for key, each in given.items():
            yield from _groups(str(key), each)
    elif isinstance(given, np.ndarray) and given.dtype.kind in "OV":  # cells, structures
        for k, each in enumerate(given.ravel(), 1):
            number = f"_{k}" if given.size > 1 else ""
            names = given.dtype.names
            yield from _groups(
                name + number, dict(zip(names, each, strict=True)) if names else each
            )


def _fields(arrays: Mapping[str, Any]) -> list[Field]:
    """Return the arrays of numbers, with units of their names or of a text `units`."""
    found, units = [], []
    for key, given in arrays.items():
        array = np.squeeze(np.asarray(given))
        name, unit = name_and_unit(str(key))
        if name in ("unit", "units") and array.dtype.kind == "U" and array.size:
            units = [each.strip() for each in str(array.ravel()[0]).split(",")]
        elif array.dtype.kind in "fiu":
            values = array.astype(float)
            # of single precision also where it was stored with more
            single = np.array_equal(values, values.astype(np.float32), equal_nan=True)
            largest = np.nanmax(np.abs(values), initial=0.0)
            rounding = np.spacing(largest.astype(np.float32) if single else largest)
            found.append(Field(name, values, unit, float(rounding)))
    signals = [field for field in found if field.values.ndim]
    if len(units) == 1:
        signals = [field for field in signals if field.kind != "time"]
        units *= len(signals)
    if len(units) == len(signals):
        stated = {id(f): name_and_unit(f"x [{u}]")[1] for f, u in zip(signals, units, strict=True)}
        found = [replace(field, unit=stated.get(id(field), field.unit)) for field in found]
    return found
