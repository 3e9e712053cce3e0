"""Sine tests of one mode: forces and responses, checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Literal

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Floats, as_floats, frozen, in_one_line, short_list

# Time derivatives of the displacement that a response in this unit is.
ORDERS: Final[Mapping[str, int]] = {"m": 0, "m/s": 1, "m/s^2": 2}


@frozen
class SineTest:
    """Hold the steady responses of a sine sweep or stepped sine test at one level.

    Attributes
    ----------
    name : str
        Name of the test.
    frequency : (points,) ndarray
        Frequencies [Hz], in the order of the test.
    force : (points,) ndarray
        Amplitude F of the measured force F exp(i Omega t) [N], real or complex.
    response : (points,) ndarray
        Complex amplitude of the response [sensor unit], with the time origin of the force.
    change : (points,) ndarray, optional
        Relative rate of change of the response [1/s], for tests from time signals. Default: steady
        responses.
    stepped : bool
        Whether the frequency changed in steps.
    notes : tuple of str
        What was found when the test was read, one line each.
    """

    name: str
    frequency: Floats
    force: Complexes
    response: Complexes
    change: Floats | None = None
    stepped: bool = False
    notes: tuple[str, ...] = ()

    @property
    def control(self) -> Literal["force", "response"]:
        """Controlled signal, "force" or "response": the one whose amplitude changes less."""
        sizes = np.abs(self.force), np.abs(self.response)
        force, response = (float(each.max() / each.min()) for each in sizes)
        return "force" if force < response else "response"

    def within(self, band: tuple[float, float]) -> SineTest:
        """Return the points in a frequency band.

        Parameters
        ----------
        band : (float, float)
            Lower and upper end [Hz].

        Returns
        -------
        SineTest
            Test with these points.
        """
        keep = (self.frequency >= band[0]) & (self.frequency <= band[1])
        return replace(
            self,
            frequency=self.frequency[keep],
            force=self.force[keep],
            response=self.response[keep],
            change=None if self.change is None else self.change[keep],
        )


@frozen
class SineTests:
    """Hold sine tests measured by one set of sensors.

    Attributes
    ----------
    tests : sequence of SineTest
        Tests at several levels.
    unit : {"m", "m/s", "m/s^2"}
        Sensor unit of all responses.
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
            raise SlipmodeError(f"tests: no name starts with {key!r}; the names are {names}")
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
        part = checked(test).within((float(ends[0]), float(ends[1])))
        if part.frequency.size < 4:  # eight numbers for the four unknowns of a level
            raise SlipmodeError(
                f"tests: {test.name} must have at least 4 points between {ends[0]:g} and "
                f"{ends[1]:g} Hz, got {part.frequency.size}; its frequencies are "
                f"{test.frequency.min():g} to {test.frequency.max():g} Hz"
            )
        found.append(part)
    return found, ORDERS[tests.unit]


def checked(test: SineTest) -> SineTest:
    """Return a test with complex arrays; refuse arrays that do not fit."""
    if not np.iscomplexobj(test.response):
        raise SlipmodeError(
            f"tests: {test.name} has a response without phase; give complex amplitudes, with the "
            "phase relative to the force"
        )
    arrays = [np.asarray(each) for each in (test.frequency, test.force, test.response)]
    if any(each.ndim != 1 or each.shape != arrays[0].shape or not each.size for each in arrays):
        raise SlipmodeError(
            f"tests: {test.name} must have frequency, force and response of one length, got "
            f"shapes {', '.join(str(each.shape) for each in arrays)}"
        )
    for name, each in zip(("frequency", "force", "response"), arrays, strict=True):
        if not (np.isfinite(each).all() and (each != 0.0).all()):
            raise SlipmodeError(f"tests: {name} of {test.name} must be finite and not 0")
    force, response = (each.astype(np.complex128) for each in arrays[1:])
    frequency = arrays[0].real
    return replace(test, frequency=frequency, force=force, response=response)
