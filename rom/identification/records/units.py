"""Units of measured signals: those that files state, or that are given instead."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

from slipmode.rom import SlipmodeError
from slipmode.rom.identification.records.fields import Field
from slipmode.rom.slow import Unit, parse_unit


class AllowedUnits(NamedTuple):
    """Units that a signal may have: the argument that gives one, quantities, and words."""

    argument: str
    quantities: tuple[str, ...]
    words: str

    def unit(self, path: Path, key: str, field: Field, given: str | None) -> Unit:
        """Return the unit of a signal: `given`, or the unit in the file."""
        text = field.unit if given is None else given
        if not text:
            raise SlipmodeError(
                f"{self.argument}: {path} does not state one; give {self.argument}="
            )
        unit = parse_unit(text)
        if unit is None or unit.quantity not in self.quantities:
            what = f"{path}: {key} is in {text!r}"
            if given is not None:
                what = f"{self.argument} = {text!r}"
            raise SlipmodeError(f"{what}: must be {self.words}")
        return unit


FORCE: Final[AllowedUnits] = AllowedUnits(
    "force_unit", ("force",), "N (also with prefix m, u, k or M) or lbf"
)


def override_note(field: Field, unit: Unit) -> tuple[str, ...]:
    """Return a note if a unit that was given replaces another one in the file."""
    if field.unit in ("", unit.name):
        return ()
    return (f"{field.name} is in {unit.name} as given; the file states {field.unit}",)
