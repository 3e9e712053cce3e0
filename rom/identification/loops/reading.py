"""Files with loops of force against displacement: text, .npz, .mat and universal files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from slipmode.rom import SlipmodeError
from slipmode.rom.common import in_one_line, short_list
from slipmode.rom.identification.loops.loop import Loop
from slipmode.rom.identification.records.fields import Field, Group, renamed
from slipmode.rom.identification.records.files import distinct_names, found_files, read_groups
from slipmode.rom.identification.records.reading import records_of
from slipmode.rom.identification.records.units import FORCE, AllowedUnits, override_note
from slipmode.rom.slow import parse_unit

_LENGTH: Final = AllowedUnits(
    "unit", ("displacement",), "m (also with prefix n, u, m or c), in or ft"
)


def read_loops(
    files: str | Path | Sequence[str | Path],
    *,
    unit: str | None = None,
    force_unit: str | None = None,
    channels: Sequence[str | int] | None = None,
) -> tuple[Loop, ...]:
    """Return loops of force against displacement from files.

    Parameters
    ----------
    files : str, Path, or sequence of these
        Names of files, also with wildcards ("loop*.csv"), in the formats and with the records of
        `rom.read_measurement`. A record has the displacement and the force in the order of time,
        as columns, arrays or channels. Times are ignored: the laws do not depend on rates.
    unit : str, optional
        Unit of the displacement, such as "mm". It overrides the files. Required unless the files
        state it.
    force_unit : str, optional
        Unit of the force, such as "N" or "kN". It overrides the files. Required unless the files
        state it.
    channels : (displacement, force), optional
        Columns of displacement and force, by name or by position from 0. Default: the only force,
        by its name or unit, and the only displacement or other signal.

    Returns
    -------
    tuple of Loop
        A loop of each record, in m and N.

    Raises
    ------
    SlipmodeError
        If a file does not exist or cannot be read, has no force and displacement, or a unit is
        missing or not allowed.
    """
    if channels is not None and (isinstance(channels, str) or len(channels) != 2):
        raise SlipmodeError(
            f"channels = {in_one_line(channels)}: must be the displacement and the force"
        )
    groups = [(path, group) for path in found_files(files) for group in read_groups(path)]
    found = list(records_of(groups, channels))
    if not found:
        raise SlipmodeError("files: contain no loop")
    names = distinct_names([(path, group.name) for path, group in found])
    loops = []
    for name, (path, group) in zip(names, found, strict=True):
        x, force = _columns(path, group, channels)
        length = _LENGTH.unit(path, "displacement", x, unit)
        newton = FORCE.unit(path, "force", force, force_unit)
        notes = (*group.notes, *override_note(x, length), *override_note(force, newton))
        loops.append(Loop(name, length.size * x.values, newton.size * force.values, notes))
    return tuple(loops)


def _columns(path: Path, group: Group, channels: Sequence[Any] | None) -> tuple[Field, Field]:
    """Return displacement and force of a record."""
    fields = renamed([each for each in group.fields if each.values.ndim == 1])
    if channels is not None:
        by_key: dict[Any, Field] = {each.name: each for each in fields} | dict(enumerate(fields))
        chosen = [by_key[key] for key in channels if key in by_key]
    else:
        forces = [each for each in fields if each.kind == "force"]
        others = [each for each in fields if each.kind == ""]
        measured = [each for each in others if _is_length(each)]
        chosen = [*(measured or others), *forces] if len(forces) == 1 else []
    if len(chosen) != 2:
        raise SlipmodeError(
            f"{path}: must have one displacement and one force, got "
            f"{short_list(each.name for each in fields) or 'no signals'}; choose both by channels="
        )
    x, force = chosen
    return x, force


def _is_length(field: Field) -> bool:
    unit = parse_unit(field.unit)
    return field.name.lower() == "displacement" or (
        unit is not None and unit.quantity == "displacement"
    )
