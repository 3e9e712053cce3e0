"""Functions at nodal DOFs (data sets 58) of universal files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.identification.records.files import UNEVEN, rate_of_times
from slipmode.rom.short_repr import frozen

_TIME_RESPONSE = 1  # function type
_EXCITATION_FORCE = 13  # type of ordinate data


@frozen
class UniversalChannel:
    """A time signal.

    Attributes
    ----------
    signal : (samples,) ndarray
    unit : str
        Empty if the file does not state it.
    is_force : bool
        Whether it is an excitation force.
    """

    signal: Floats
    unit: str
    is_force: bool


def read_universal(path: Path) -> tuple[dict[str, dict[str, UniversalChannel]], float]:
    """Return the records of a universal file by name, and their sampling rate [Hz].

    A record has its channels by node and direction, as "12:+3", and excitation forces as
    "force 12:+3". A channel that repeats starts a new record.
    """
    pyuff = extra("pyuff", "uff")
    try:
        file = pyuff.UFF(str(path))
        sets = [file.read_sets(int(k)) for k in np.flatnonzero(file.get_set_types() == 58)]
    except Exception as error:
        raise SlipmodeError(f"{path}: is not a readable universal file") from error
    records: list[dict[str, UniversalChannel]] = []
    rates = set()
    for each in sets:
        if each["func_type"] != _TIME_RESPONSE:
            continue
        name, channel = _channel(each)
        if not records or name in records[-1]:
            records.append({})
        records[-1][name] = channel
        rates.add(rate_of_times(path, np.asarray(each["x"], dtype=float)))
    if not records:
        raise SlipmodeError(f"{path}: has no time signals in data sets 58")
    if max(rates) > (1.0 + UNEVEN) * min(rates):
        raise SlipmodeError(f"{path}: all time signals must have one sampling rate")
    stem = path.stem
    named = {stem if len(records) == 1 else f"{stem}_{k}": r for k, r in enumerate(records, 1)}
    return named, rates.pop()


def _channel(each: dict[str, Any]) -> tuple[str, UniversalChannel]:
    unit = str(each["ordinate_axis_units_lab"]).strip()
    unit = "" if unit.upper() == "NONE" else unit
    is_force = each["ordinate_spec_data_type"] == _EXCITATION_FORCE
    name = f"{'force ' if is_force else ''}{each['rsp_node']}:{each['rsp_dir']:+d}"
    return name, UniversalChannel(np.asarray(each["data"], dtype=float), unit, is_force)
