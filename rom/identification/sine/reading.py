"""Files with sine tests: .csv, .npz, .mat and universal files (.uff, .unv)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from slipmode.rom.arrays import as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.records.files import (
    UNIVERSAL,
    found_files,
    read_arrays,
    sampling_rate,
    stated_rate,
)
from slipmode.rom.identification.records.universal import read_universal
from slipmode.rom.identification.sine.responses import ORDERS, SineTest, SineTests, checked
from slipmode.rom.identification.sine.signals import demodulate_sine_test
from slipmode.rom.short_repr import frozen, short_list

COLUMNS: Final = ("frequency", "force", "amplitude", "phase")
_ALLOWED: Final[Mapping[str, tuple[str, ...]]] = {  # units
    "response": tuple(ORDERS),
    "force": ("N",),
    "frequency": ("Hz",),
    "phase": ("rad",),
}
_ARGUMENTS: Final = {"response": "unit", "force": "force_unit"}


@frozen
class _Content:
    """One test in a file.

    It has the columns `frequency`, `force`, `response` of steady responses, or the signals `force`
    and `response` with a sampling rate [Hz], None if the file does not state it.
    """

    name: str
    columns: Mapping[str, Any]
    units: Mapping[str, str]
    sample_rate: float | None = None

    def test(self, path: Path, sample_rate: float | None) -> SineTest:
        """Return the test; `sample_rate` [Hz] is that of signals if the file does not state it."""
        force, response = self.columns["force"], self.columns["response"]
        if "frequency" in self.columns:
            return checked(SineTest(self.name, self.columns["frequency"], force, response))
        rate = sampling_rate(path, self.sample_rate, sample_rate)
        return demodulate_sine_test(self.name, force, response, rate)


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

        - A .csv or .npz file is one test. Time signals are the columns or arrays `force` [N] and
          `response` [sensor unit], with `time` [s] or `sample_rate` [Hz]. Steady responses are
          `frequency` [Hz], `force` [N], `amplitude` [sensor unit] and `phase` relative to the
          force [rad]. A unit may follow the name of a column, as in `force [N]`.
        - A .mat file has these arrays, or any number of structures with these fields.
        - A universal file (.uff, .unv; needs `slipmode[uff]`) has time signals in data sets 58. A
          node and direction that repeats starts a new test.
    unit : {"m", "m/s", "m/s^2"}, optional
        Sensor unit of the response. Required unless the files state it.
    force_unit : {"N"}, optional
        Unit of the force. Required unless the files state it.
    sample_rate : float, optional
        Sampling rate of time signals [Hz]. Required if the files have neither a rate nor times.
    channels : sequence of two str, optional
        Names of the time signals of force and response. Default: "force" and "response". In
        universal files: the channel of an excitation force, and the other channel.

    Returns
    -------
    SineTests
        All tests; time signals are demodulated by `rom.demodulate_sine_test`.

    Raises
    ------
    SlipmodeError
        If a file does not exist or cannot be read, or has no force. If a unit or the sampling rate
        is missing, contradicts the file or is not allowed, or signals are no sine tests.
    """
    stated: dict[str, str | None] = {"response": unit, "force": force_unit}
    if channels is not None and (isinstance(channels, str) or len(channels) != 2):
        raise SlipmodeError(
            f"channels = {in_one_line(channels)}: must be the names of force and response"
        )
    tests = []
    for path in found_files(files):
        read = _of_universal if path.suffix.lower() in UNIVERSAL else _of_arrays
        for content in read(path, channels):
            _check_units(path, content.units, stated)
            tests.append(content.test(path, sample_rate))
    return SineTests(tests, str(stated["response"]))


def _check_units(path: Path, units: Mapping[str, str], stated: dict[str, str | None]) -> None:
    """Refuse units that are missing, contradict `stated` ones, or are not allowed; add others."""
    for key, own in units.items():
        if key in stated and stated[key] not in (None, own):
            raise SlipmodeError(
                f"{_ARGUMENTS[key]} = {stated[key]!r}: must be {own!r}, as {path} states"
            )
        if own not in _ALLOWED[key]:
            raise SlipmodeError(
                f"{path}: {key} is in {own!r}: must be {' or '.join(_ALLOWED[key])}"
            )
    for key, argument in _ARGUMENTS.items():
        given = stated[key] = stated[key] or units.get(key)
        if given is None:
            raise SlipmodeError(f"{argument}: {path} does not state one; give {argument}=")
        if given not in _ALLOWED[key]:
            allowed = ", ".join(_ALLOWED[key])
            raise SlipmodeError(f"{argument} = {given!r}: must be {allowed}")


def _of_universal(path: Path, channels: Sequence[str] | None) -> Iterator[_Content]:
    """Yield the time signals of each record of a universal file."""
    records, rate = read_universal(path)
    for name, record in records.items():
        forces = [key for key, each in record.items() if each.is_force]
        others = [key for key in record if key not in forces]
        if channels is None and (len(forces) != 1 or len(others) != 1):
            raise SlipmodeError(
                f"{path}: {name} has the forces {short_list(forces) or 'none'} and the responses "
                f"{short_list(others) or 'none'}; choose one of each by channels="
            )
        chosen = channels or (forces[0], others[0])
        if missing := [key for key in chosen if key not in record]:
            raise SlipmodeError(f"channels: {path} has {short_list(record)}, not {missing[0]!r}")
        found = dict(zip(("force", "response"), (record[key] for key in chosen), strict=True))
        units = {key: each.unit for key, each in found.items() if each.unit}
        yield _Content(name, {key: each.signal for key, each in found.items()}, units, rate)


def _of_arrays(path: Path, channels: Sequence[str] | None) -> Iterator[_Content]:
    """Yield the tests of a .csv, .npz or .mat file."""
    arrays = read_arrays(path)
    signals = ("force", "response") if channels is None else tuple(channels)
    allowed = [COLUMNS, signals] if channels is None else [signals]
    structures = list(_structures(arrays, "", allowed))
    if not structures:
        needed = ", or the time signals ".join(", ".join(each) for each in allowed)
        raise SlipmodeError(
            f"{path}: must have {needed}, got {short_list(arrays)}; the force must be measured"
        )
    for name, fields in structures:
        plain = {_name_and_unit(key)[0]: key for key in fields}
        names = next(each for each in allowed if set(each) <= set(plain))
        columns: dict[str, Any] = {
            key: np.ravel(as_floats(f"{path}: {key}", fields[plain[key]])) for key in names
        }
        if len({each.size for each in columns.values()}) > 1:
            raise SlipmodeError(f"{path}: {', '.join(names)} must have one length")
        if names is COLUMNS:
            kinds = {key: "response" if key == "amplitude" else key for key in COLUMNS}
            columns["response"] = columns["amplitude"] * np.exp(1j * columns["phase"])
        else:
            kinds = dict(zip(signals, ("force", "response"), strict=True))
            columns = {kinds[key]: each for key, each in columns.items()}
        units = {kinds[key]: unit for key, unit in _units(fields, names).items()}
        yield _Content(name or path.stem, columns, units, _rate(path, fields))


def _units(fields: Mapping[str, Any], names: Sequence[str]) -> dict[str, str]:
    """Return the units of columns that follow their names, or are in a text `units`."""
    units = dict(map(_name_and_unit, fields))
    if "units" in fields:  # of the fields in their order, as one text
        text = str(np.ravel(fields["units"])[0])
        order = [plain for plain in units if plain in (*names, "time")]
        units = dict(zip(order, (each.strip() for each in text.split(",")), strict=False))
    return {plain: unit for plain, unit in units.items() if plain in names and unit}


def _rate(path: Path, fields: Mapping[str, Any]) -> float | None:
    """Return the sampling rate [Hz] that the fields of a test state."""
    for key, given in fields.items():
        array = np.squeeze(np.asarray(given))
        if array.dtype.kind in "fiu":
            rate = stated_rate(path, key, array.astype(float))
            if rate is not None:
                return rate
    return None


def _name_and_unit(key: str) -> tuple[str, str]:
    """Return the parts of `force [N]`; the unit may be empty."""
    name, _, unit = re.sub(r"[(\])]", "[", key).partition("[")
    return name.strip(), unit.strip(" [")


def _structures(
    given: Any, name: str, allowed: Sequence[Sequence[str]]
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the structures with all of some columns, and their names with numbers from 1.

    They may be at any depth; `allowed` has the sets of columns.
    """
    if isinstance(given, np.ndarray) and given.dtype.kind in "OV":  # cells, structures
        for k, each in enumerate(given.ravel(), 1):
            number = f"_{k}" if given.size > 1 else ""
            fields = dict(zip(given.dtype.names, each, strict=True)) if given.dtype.names else each
            yield from _structures(fields, name + number, allowed)
    elif isinstance(given, Mapping):
        names = {_name_and_unit(str(key))[0] for key in given}
        if any(set(each) <= names for each in allowed):
            yield name, dict(given)
            return
        for key, each in given.items():
            yield from _structures(each, key, allowed)
