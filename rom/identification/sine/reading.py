"""Sine tests of one mode, and files with them: .csv, .npz and .mat."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification.records.reading import found_files, read_arrays
from slipmode.rom.short_repr import frozen, short_list

# Time derivatives of the displacement that a response in this unit is.
ORDERS: Final[Mapping[str, int]] = {"m": 0, "m/s": 1, "m/s^2": 2}
COLUMNS: Final = ("frequency", "force", "amplitude", "phase")


@frozen
class SineTest:
    """Steady responses to a sine sweep or stepped sine at one level.

    Attributes
    ----------
    name : str
    frequency : (points,) ndarray
        [Hz], in the order of the test.
    force : (points,) ndarray
        Amplitude F of the measured force F e^{i Omega t} [N], real or complex.
    response : (points,) ndarray
        Complex amplitude, with the phase relative to the same time as the force [sensor unit].
    """

    name: str
    frequency: Floats
    force: Complexes
    response: Complexes

    @property
    def control(self) -> Literal["force", "response"]:
        """Which of force and response was controlled: the one that changes less."""
        sizes = np.abs(self.force), np.abs(self.response)
        force, response = (float(each.max() / each.min()) for each in sizes)
        return "force" if force < response else "response"

    def within(self, band: tuple[float, float]) -> SineTest:
        """Return the points within a band [Hz]."""
        keep = (self.frequency >= band[0]) & (self.frequency <= band[1])
        parts = (self.frequency[keep], self.force[keep], self.response[keep])
        return SineTest(self.name, *parts)


@frozen
class SineTests:
    """Sine tests by the same sensors.

    Attributes
    ----------
    tests : sequence of SineTest
    unit : {"m", "m/s", "m/s^2"}
        Of all responses.
    """

    tests: Sequence[SineTest]
    unit: str

    def __len__(self) -> int:
        return len(self.tests)

    def __iter__(self) -> Iterator[SineTest]:
        return iter(self.tests)

    def __getitem__(self, key: str) -> SineTests:
        """Return the test of a name, or else the tests whose names start with it."""
        found = [test for test in self if test.name == key]
        found = found or [test for test in self if test.name.startswith(key)]
        if not found:
            names = short_list(test.name for test in self)
            raise SlipmodeError(f"tests: no name starts with {key!r}, they are {names}")
        return SineTests(found, self.unit)


def checked_tests(tests: SineTests, band: Any) -> tuple[list[SineTest], int]:
    """Return the points of the tests within a band, and the derivatives that the response is.

    Raises
    ------
    SlipmodeError
        If the band, the unit, or an array of a test is not allowed, or too few points are left.
    """
    ends = as_floats("band", band)
    if ends.shape != (2,) or not (np.isfinite(ends).all() and 0.0 < ends[0] < ends[1]):
        raise SlipmodeError(f"band = {in_one_line(band)}: must be 0 < lower < upper end [Hz]")
    if tests.unit not in ORDERS:
        raise SlipmodeError(
            f"unit = {in_one_line(tests.unit)}: must be {', '.join(ORDERS)}; convert the response"
        )
    names = [test.name for test in tests]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise SlipmodeError(f"tests: names {short_list(repeated)} occur more than once")
    found = []
    for test in tests:
        part = _checked(test).within((float(ends[0]), float(ends[1])))
        if part.frequency.size < 4:  # eight numbers for the four unknowns of a level
            raise SlipmodeError(
                f"tests: {test.name} has {part.frequency.size} points between {ends[0]:g} and "
                f"{ends[1]:g} Hz, needs 4; its frequencies are {test.frequency.min():g} to "
                f"{test.frequency.max():g} Hz"
            )
        found.append(part)
    return found, ORDERS[tests.unit]


def _checked(test: SineTest) -> SineTest:
    if not np.iscomplexobj(test.response):
        raise SlipmodeError(
            f"tests: {test.name} has a response without phase; give complex amplitudes, with the "
            "phase relative to the force"
        )
    arrays = [np.asarray(each) for each in (test.frequency, test.force, test.response)]
    if any(each.ndim != 1 or each.shape != arrays[0].shape or not each.size for each in arrays):
        raise SlipmodeError(
            f"tests: {test.name} must have frequency, force and response of one length, has "
            f"shapes {', '.join(str(each.shape) for each in arrays)}"
        )
    for name, each in zip(("frequency", "force", "response"), arrays, strict=True):
        if not (np.isfinite(each).all() and (each != 0.0).all()):
            raise SlipmodeError(f"tests: {name} of {test.name} must be finite and not 0")
    force, response = (each.astype(np.complex128) for each in arrays[1:])
    return SineTest(test.name, arrays[0].real, force, response)


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
            tests.append(_checked(test))
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
