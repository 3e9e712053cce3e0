"""Measured records, and the usable parts of them that are fitted."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, as_floats, frozen, in_one_line, short_list

SAMPLES = 2.5  # samples per period of the highest frequency of a band, at least
Bands = tuple[tuple[float, float], ...]  # lower and upper end of the band of each mode [Hz]


@frozen
class Record:
    """Hold the signals of one measured decay.

    Attributes
    ----------
    name : str
        Name, unique in a measurement.
    signal : (channels, samples) ndarray
        Signals [sensor unit].
    sample_rate : float
        Sampling rate [Hz].
    notes : tuple of str
        What was found when the record was read, one line each.
    """

    name: str
    signal: Floats
    sample_rate: float
    notes: tuple[str, ...] = ()

    @property
    def samples(self) -> int:
        """Number of samples of each channel."""
        return int(self.signal.shape[1])

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return (self.samples - 1) / self.sample_rate

    @property
    def times(self) -> Floats:
        """Times of the samples after the first sample, (samples,) [s]."""
        return np.arange(self.samples) / self.sample_rate

    def part(self, start: float, end: float) -> Record:
        """Return the samples between two times.

        Parameters
        ----------
        start, end : float
            Times after the first sample [s].

        Returns
        -------
        Record
            Record with these samples.
        """
        first, last = (round(t * self.sample_rate) for t in (start, end))
        return replace(self, signal=self.signal[:, first : last + 1])


@frozen
class Prepared:
    """A record and its usable part.

    Attributes
    ----------
    name : str
    part : Record or None
        The usable part; None if the record is excluded.
    start, end : float
        Of the usable part [s].
    noise : float
        Standard deviation of the noise of a sample [sensor unit].
    notes : tuple of str
        What was found, a line each; the last one says why an excluded record is excluded.
    """

    name: str
    part: Record | None
    start: float
    end: float
    noise: float
    notes: tuple[str, ...]

    def excluded(self, reason: str) -> Prepared:
        """Return the record as excluded, for a reason in one line."""
        notes = (*self.notes, reason)
        return replace(self, part=None, start=0.0, end=0.0, notes=notes)


@frozen
class RecordReport:
    """Report how an identification used a record.

    Attributes
    ----------
    name : str
        Name of the record.
    use : {"fitted", "held out", "excluded"}
        Use of the record.
    start, end : float
        Ends of the usable part [s]; 0 if the record is excluded.
    amplitude : (modes,) ndarray
        Initial amplitudes in the reference channel [sensor unit]; NaN if the record is excluded.
    error : float
        Normalised error of the prediction from the first window [-], see `Prediction`.
    notes : tuple of str
        Findings about the record, one line each.
    """

    name: str
    use: Literal["fitted", "held out", "excluded"]
    start: float
    end: float
    amplitude: Floats
    error: float
    notes: tuple[str, ...]


@frozen
class Measurement:
    """Hold the records of one test, measured by one set of sensors.

    Attributes
    ----------
    records : sequence of Record
        Records with unique names.
    quantity : str
        Measured quantity, such as "velocity".
    unit : str
        Sensor unit: the unit of all signals, such as "m/s".
    channels : tuple of str
        Names of the channels.
    """

    records: Sequence[Record]
    quantity: str
    unit: str
    channels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    @property
    def numbers(self) -> dict[int, str]:
        """Names of records by number: last digits of the names, or positions from 1."""
        last = [re.search(r"(\d+)\D*$", record.name) for record in self.records]
        found = [int(match[1]) for match in last if match]
        if len(set(found)) < len(self.records):
            found = list(range(1, len(self.records) + 1))
        return dict(zip(found, (record.name for record in self.records), strict=True))

    def __getitem__(self, key: str | int) -> Record:
        """Return a record by its name, or by its number (see `numbers`)."""
        name = self.numbers.get(key) if isinstance(key, int) else key
        for record in self.records:
            if record.name == name:
                return record
        raise SlipmodeError(
            f"record {key!r} is not in the measurement, which has "
            f"{short_list(f'{k} ({name})' for k, name in self.numbers.items())}"
        )


def checked_bands(bands: Any, data: Measurement) -> Bands:
    """Return the bands of one or two modes; refuse others, and sampling rates too low for them."""
    given = as_floats("bands", bands)
    if given.ndim != 2 or given.shape[1] != 2 or not 1 <= len(given) <= 2:
        raise SlipmodeError(
            f"bands = {in_one_line(bands)}: must be one or two pairs of frequencies [Hz], such as "
            "[(100, 140), (225, 260)]"
        )
    if not (
        np.isfinite(given).all() and (given[:, 0] > 0).all() and (given[:, 1] > given[:, 0]).all()
    ):
        raise SlipmodeError(f"bands = {in_one_line(bands)}: must be 0 < lower < upper end [Hz]")
    if len(given) == 2 and given[0, 1] > given[1, 0]:
        raise SlipmodeError(
            f"bands = {in_one_line(bands)}: must not overlap, and the lower band must be first"
        )
    slowest = min(data, key=lambda record: record.sample_rate)
    if slowest.sample_rate < SAMPLES * given.max():
        raise SlipmodeError(
            f"bands: {given.max():g} Hz needs a sampling rate of at least "
            f"{SAMPLES * given.max():g} Hz, but record {slowest.name} has "
            f"{slowest.sample_rate:g} Hz"
        )
    return tuple((float(low), float(high)) for low, high in given)
