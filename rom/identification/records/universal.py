"""Functions at nodal DOFs (data sets 58) of universal files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, extra, frozen, short_list
from slipmode.rom.identification.records.fields import UNEVEN, Field, Group, rate_of_times
from slipmode.rom.slow import parse_unit

_TIME_RESPONSE = 1  # function type
_EXCITATION_FORCE = 13  # type of ordinate data
_DIGITS = 6  # of printed abscissas, 1E13.5
_TIME_STAMP = re.compile(r"\d{1,2}:\d\d")
_END = re.compile(rb"^    -1[ \t]*\r?$", re.MULTILINE)  # begins and ends data sets


@frozen
class _Signal:
    """A time signal.

    Attributes
    ----------
    place : str
        Node and direction as "12:+3", after "force" for an excitation force.
    words : tuple of str
        Label of the ordinate, name of the entity, and ID lines that name the sensor.
    stamp : tuple of str
        ID lines with the time or the run in which it was measured.
    samples : ndarray
    unit : str
    rate : float
        [Hz]
    missing : int
        Number of samples that the data set states and does not have.
    """

    place: str
    words: tuple[str, ...]
    stamp: tuple[str, ...]
    samples: Floats
    unit: str
    rate: float
    missing: int

    @classmethod
    def of(cls, path: Path, each: dict[str, Any]) -> _Signal:
        """Return the signal of a data set."""
        is_force = each["ordinate_spec_data_type"] == _EXCITATION_FORCE
        node = each["rsp_node"]
        place = f"{'force ' if is_force else ''}{node}:{each['rsp_dir']:+d}"
        lines = {f"id{k}": _text(each, f"id{k}") for k in range(1, 6)}
        # By convention line 2 is the run. Without numbers of nodes it may name the sensor.
        of_run = [
            key
            for key, text in lines.items()
            if _TIME_STAMP.search(text) or (node and key == "id2")
        ]
        words = [_text(each, "ordinate_axis_lab"), _text(each, "rsp_ent_name")]
        words += [text for key, text in lines.items() if key not in of_run]
        samples = np.asarray(each["data"], dtype=float)[: each["num_pts"]]
        return cls(
            place,
            tuple(words),
            tuple(lines[key] for key in of_run),
            samples,
            _text(each, "ordinate_axis_units_lab"),
            _rate(path, each),
            int(each["num_pts"]) - samples.size,
        )


def _text(each: dict[str, Any], key: str) -> str:
    text = str(each[key] or "").strip()
    return "" if text.upper() == "NONE" else text


def _rate(path: Path, each: dict[str, Any]) -> float:
    """Return the sampling rate of a data set [Hz]."""
    unit = parse_unit(_text(each, "abscissa_axis_units_lab"))
    size = unit.size if unit and unit.quantity == "time" else 1.0
    if each["abscissa_spacing"] == 1 and each["abscissa_inc"] > 0.0:
        return float(1.0 / (size * each["abscissa_inc"]))
    times = size * np.asarray(each["x"], dtype=float)
    rounding = 0.5 * 10.0 ** (np.ceil(np.log10(np.abs(times).max(initial=1e-300))) - _DIGITS)
    return rate_of_times(path, [Field("time", times, "", rounding)])[0]


def read_universal(path: Path) -> list[Group]:
    """Return the records of a universal file, without name if there is one.

    Channels are distinguished by node and direction, label, entity and ID lines. A record has the
    signals of one time stamp or run, if all of these have the same channels. Otherwise a channel
    that repeats starts a new record.
    """
    pyuff = extra("pyuff", "uff")
    try:
        file = pyuff.UFF(str(path))
        sets = [file.read_sets(int(k)) for k in np.flatnonzero(file.get_set_types() == 58)]
        whole = len(_END.findall(path.read_bytes())) % 2 == 0
        every = [_Signal.of(path, each) for each in sets if each["func_type"] == _TIME_RESPONSE]
    except SlipmodeError:
        raise
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable universal file") from error
    if not every:
        raise SlipmodeError(f"{path}: has no time signals in data sets 58")
    rates = [each.rate for each in every]
    if max(rates) > (1.0 + UNEVEN) * min(rates):
        raise SlipmodeError(f"{path}: all time signals must have one sampling rate")
    notes = [] if whole else ["the file ends within a data set, which was left out"]
    records = _records(every)
    return [
        _group(f"{path.stem}_{k}" if len(records) > 1 else "", record, notes)
        for k, record in enumerate(records, 1)
    ]


def _records(every: Sequence[_Signal]) -> list[list[_Signal]]:
    by_stamp: dict[tuple[str, ...], list[_Signal]] = {}
    for each in every:
        by_stamp.setdefault(each.stamp, []).append(each)
    channels = [sorted((each.place, each.words) for each in same) for same in by_stamp.values()]
    if len(set(channels[0])) == len(channels[0]) and all(c == channels[0] for c in channels):
        return list(by_stamp.values())
    records: list[list[_Signal]] = []
    for each in every:
        if not records or (each.place, each.words) in [(e.place, e.words) for e in records[-1]]:
            records.append([])
        records[-1].append(each)
    return records


def _group(name: str, record: Sequence[_Signal], notes: Sequence[str]) -> Group:
    """Return a record, whose channels have the shortest names that differ."""
    found = list(notes)
    places = [each.place for each in record]
    names = places
    if len(set(places)) < len(places):
        words = list(zip(*(each.words for each in record), strict=True))
        alone = [list(each) for each in words if len(set(each)) == len(places)]
        whole = [" ".join(filter(None, each.words)) for each in record]
        forces = ["force " if place.startswith("force") else "" for place in places]
        names = [f + n for f, n in zip(forces, (alone or [whole])[0], strict=True)]
        found.append(
            f"several signals have one node and direction; they are channels {short_list(names)}"
        )
    for channel, each in zip(names, record, strict=True):
        if each.missing > 0:
            stated = each.samples.size + each.missing
            found.append(f"{channel} states {stated} samples and has {each.samples.size}")
    fields = [Field(n, each.samples, each.unit) for n, each in zip(names, record, strict=True)]
    return Group(name, fields, record[0].rate, tuple(found))
