"""Files with sine tests: .csv, .npz and .mat."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.records.files import found_files, read_arrays
from slipmode.rom.identification.sine.responses import ORDERS, SineTest, SineTests, checked
from slipmode.rom.short_repr import short_list

COLUMNS: Final = ("frequency", "force", "amplitude", "phase")


def read_sine_tests(
    files: str | Path | Sequence[str | Path],
    *,
    unit: str | None = None,
    force_unit: str | None = None,
) -> SineTests:
    """Read sine sweeps or stepped sines: amplitudes and phase against the forcing frequency.

    Parameters
    ----------
    files : str, Path, or sequence of these
        Names may have wildcards ("level*.csv"). A .csv or .npz file is one test with the columns
        or arrays `frequency` [Hz], `force` [N], `amplitude` [sensor unit] and `phase` [rad], the
        phase of the response relative to the force. A unit may follow a name of a column, as in
        `force [N]`. A .mat file has these arrays, or any number of structures with these fields.
    unit : {"m", "m/s", "m/s^2"}, optional
        Unit of the response. Required unless the files state it.
    force_unit : {"N"}, optional
        Unit of the force. Required unless the files state it.

    Returns
    -------
    SineTests

    Raises
    ------
    SlipmodeError
        If there is no such file, a file cannot be read, has no force, or a unit is missing,
        contradicts the file or is not allowed.
    """
    stated: dict[str, str | None] = {"amplitude": unit, "force": force_unit}
    arguments = {"amplitude": "unit", "force": "force_unit"}
    allowed = {
        "amplitude": tuple(ORDERS),
        "force": ("N",),
        "frequency": ("Hz",),
        "phase": ("rad",),
    }
    tests = []
    for path in found_files(files):
        for name, columns, units in _tests_of(path, read_arrays(path)):
            for key, own in units.items():
                if key in stated and stated[key] not in (None, own):
                    raise SlipmodeError(
                        f"{arguments[key]} = {stated[key]!r}: {path} states {own!r}"
                    )
                if own not in allowed[key]:
                    raise SlipmodeError(
                        f"{path}: {key} is in {own!r}: must be {' or '.join(allowed[key])}"
                    )
            for key in stated:
                stated[key] = stated[key] or units.get(key)
                if stated[key] is None:
                    raise SlipmodeError(
                        f"{arguments[key]}: {path} does not state one; give {arguments[key]}="
                    )
            wave = columns["amplitude"] * np.exp(1j * columns["phase"])
            test = SineTest(name, columns["frequency"], columns["force"].astype(complex), wave)
            tests.append(checked(test))
    for key, given in stated.items():
        if given not in allowed[key]:
            raise SlipmodeError(f"{arguments[key]} = {given!r}: must be {', '.join(allowed[key])}")
    return SineTests(tests, str(stated["amplitude"]))


def _tests_of(
    path: Path, arrays: Mapping[str, Any]
) -> Iterator[tuple[str, dict[str, Floats], dict[str, str]]]:
    """Yield the name, the columns and the units of each test in a file."""
    structures = list(_structures(arrays, ""))
    if not structures:
        names = short_list(arrays)
        raise SlipmodeError(
            f"{path}: needs {', '.join(COLUMNS)}, has {names}; the force must be measured"
        )
    for name, fields in structures:
        columns, units = {}, {}
        for key, given in fields.items():
            plain, unit = _name_and_unit(key)
            if plain in COLUMNS:
                columns[plain] = np.ravel(as_floats(f"{path}: {plain}", given))
                if unit:
                    units[plain] = unit
        if len({each.size for each in columns.values()}) > 1:
            raise SlipmodeError(f"{path}: {', '.join(COLUMNS)} must have one length")
        if "units" in fields:  # of the fields in their order, as one text
            order = [key for key in fields if key in COLUMNS]
            text = str(np.ravel(fields["units"])[0])
            units = dict(zip(order, (each.strip() for each in text.split(",")), strict=False))
        yield name or path.stem, columns, units


def _name_and_unit(key: str) -> tuple[str, str]:
    """Return the parts of `force [N]`; the unit may be empty."""
    name, _, unit = re.sub(r"[(\])]", "[", key).partition("[")
    return name.strip(), unit.strip(" [")


def _structures(given: Any, name: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the structures with all columns, at any depth, and their names with numbers from 1."""
    if isinstance(given, np.ndarray) and given.dtype.kind in "OV":  # cells, structures
        for k, each in enumerate(given.ravel(), 1):
            number = f"_{k}" if given.size > 1 else ""
            fields = dict(zip(given.dtype.names, each, strict=True)) if given.dtype.names else each
            yield from _structures(fields, name + number)
    elif isinstance(given, Mapping):
        if set(COLUMNS) <= {_name_and_unit(str(key))[0] for key in given}:
            yield name, dict(given)
            return
        for key, each in given.items():
            yield from _structures(each, key)
