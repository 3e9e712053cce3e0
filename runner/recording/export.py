"""Export of samples to other tools: `slipmode export` to .npz, .csv or .parquet."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.extras import extra
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.load import Selection, Signals, read, warn_of_damage


def export(
    path: str | PathLike[str], output: str | PathLike[str], topics: Sequence[str] = ()
) -> list[Path]:
    """Write the samples of a recording as .npz, .csv or .parquet; return the files.

    The ending of `output` chooses the format. ``.npz``: arrays ``/modes.time`` and
    ``/modes.A_abs``, and ``units``, a mapping in JSON. ``.csv`` and ``.parquet``: a table of each
    channel, with the units in the header or in the fields' metadata; several channels go to files
    of their own, ``run.modes.csv`` and ``run.contact.0.csv`` for ``run.csv``. Without `topics` all
    channels are written. Warns with DamagedRecordingWarning if the recording is damaged. Raises
    SlipmodeError if there is no such recording, channel or format, or damage left no samples;
    OSError if a file cannot be written.
    """
    target = Path(output)
    if target.suffix not in (".npz", ".csv", ".parquet"):
        raise SlipmodeError(f"{target}: the name must end in .npz, .csv or .parquet")
    data = read(path)
    with naming(path):
        wanted = Selection(topics).of(data).channels
    if target.exists() and target.samefile(path):
        raise SlipmodeError(f"{target}: is the recording itself; give another name")
    warn_of_damage(path, data)
    if target.suffix == ".npz":
        _write_npz(target, wanted)
        return [target]
    files = []
    for topic, signals in wanted.items():
        one = f"{target.stem}{topic.replace('/', '.')}{target.suffix}"
        files.append(target if len(wanted) == 1 else target.with_name(one))
        _write_table(files[-1], signals)
    return files


def _write_npz(path: Path, channels: Mapping[str, Signals]) -> None:
    arrays = {"units": np.array(json.dumps({t: s.units for t, s in channels.items()}))}
    for topic, signals in channels.items():
        arrays[f"{topic}.time"] = signals.time
        arrays |= {f"{topic}.{name}": signals.column(name) for name in signals.channel.names}
    with replacing(path) as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def _write_table(path: Path, signals: Signals) -> None:
    """Write time and fields as .csv, with units in the header, or as .parquet, with metadata."""
    pa, units = extra("pyarrow", "export"), {"time": "s", **signals.units}
    fields = [pa.field(n, pa.float64(), metadata={"unit": unit}) for n, unit in units.items()]
    about = {"topic": signals.channel.topic, "description": signals.channel.description}
    table = pa.table([signals.time, *signals.values.T], schema=pa.schema(fields, metadata=about))
    with replacing(path) as file:
        if path.suffix == ".csv":
            named = table.rename_columns([f"{name} [{unit}]" for name, unit in units.items()])
            extra("pyarrow.csv", "export").write_csv(named, file)
        else:
            extra("pyarrow.parquet", "export").write_table(table, file)
