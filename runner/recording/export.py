"""Export of samples to other tools: `slipmode export` to .npz, .csv or .parquet."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.runner.recording.load import Signals, read


def export(
    path: str | PathLike[str], output: str | PathLike[str], topics: Sequence[str] = ()
) -> list[Path]:
    """Write the samples of a recording as .npz, .csv or .parquet; return the files.

    The ending of `output` chooses the format. ``.npz``: arrays ``/modes.time`` and
    ``/modes.A_abs``, and ``units``, a mapping in JSON. ``.csv`` and ``.parquet``: a table of each
    channel, with the units in the header or in the fields' metadata; several channels go to files
    of their own, ``run.modes.csv`` and ``run.contact.0.csv`` for ``run.csv``. Without `topics` all
    channels are written. Raises SlipmodeError if there is no such recording, channel or format,
    OSError if a file cannot be written.
    """
    target = Path(output)
    if target.suffix not in (".npz", *_TABLES):
        raise SlipmodeError(f"{target}: the name must end in .npz, .csv or .parquet")
    channels = read(path).channels
    with naming(path):
        wanted = {topic: channels[topic] for topic in topics or channels}
    if target.exists() and target.samefile(path):
        raise SlipmodeError(f"{target} is the recording itself: give another name")
    if target.suffix == ".npz":
        _write_npz(target, wanted)
        return [target]
    write = _TABLES[target.suffix]
    written = {_table_path(target, topic, len(wanted)): s for topic, s in wanted.items()}
    for file, signals in written.items():
        write(signals, file)
    return list(written)


def _write_npz(path: Path, channels: Mapping[str, Signals]) -> None:
    arrays = {"units": np.array(json.dumps({t: s.units for t, s in channels.items()}))}
    for topic, signals in channels.items():
        arrays[f"{topic}.time"] = signals.time
        arrays |= {f"{topic}.{name}": signals.column(name) for name in signals.channel.names}
    with replacing(path) as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def _table_path(path: Path, topic: str, count: int) -> Path:
    if count == 1:
        return path
    return path.with_name(f"{path.stem}{topic.replace('/', '.')}{path.suffix}")


def _write_csv(signals: Signals, path: Path) -> None:
    names = [f"{name} [{unit}]" for name, unit in {"time": "s", **signals.units}.items()]
    table, csv = extra("pyarrow", "export").table, extra("pyarrow.csv", "export")
    with replacing(path) as file:
        csv.write_csv(table(_columns(signals), names), file)


def _write_parquet(signals: Signals, path: Path) -> None:
    pa, parquet = extra("pyarrow", "export"), extra("pyarrow.parquet", "export")
    units = {"time": "s", **signals.units}
    fields = [pa.field(name, pa.float64(), metadata={"unit": units[name]}) for name in units]
    about = {"topic": signals.channel.topic, "description": signals.channel.description}
    schema = pa.schema(fields, metadata=about)
    with replacing(path) as file:
        parquet.write_table(pa.table(_columns(signals), schema=schema), file)


def _columns(signals: Signals) -> list[Any]:
    """Return time and fields as Arrow arrays."""
    pa = extra("pyarrow", "export")
    return [pa.array(signals.time), *(pa.array(column) for column in signals.values.T)]


_TABLES: Mapping[str, Callable[[Signals, Path], None]] = {
    ".csv": _write_csv,
    ".parquet": _write_parquet,
}
