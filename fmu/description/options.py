"""Options of an exported FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import isfinite
from typing import Literal

from slipmode.fmu.handle import ComponentOptions
from slipmode.rom import SlipmodeError
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.storage.text import checked_line

FmiVersion = Literal[2, 3]
MODEL_IDENTIFIER = "slipmode"


@dataclass(frozen=True)
class Origin:
    """Origin of a model; None is not written."""

    # author, copyright, license: One line each. The FMU's library has the license of slipmode
    author: str | None = None
    copyright: str | None = None
    license: str | None = None
    generated: datetime | None = None  # With a time zone

    def __post_init__(self) -> None:
        for key in ("author", "copyright", "license"):
            if (value := getattr(self, key)) is not None:
                checked_line(key, value)
        if self.generated is not None and self.generated.tzinfo is None:
            raise SlipmodeError("generated: must be a time with a time zone")

    def attributes(self) -> dict[str, str]:
        """Return the attributes that both versions of the standard have."""
        given = {"author": self.author, "copyright": self.copyright, "license": self.license}
        if self.generated is not None:
            at = self.generated.astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            given["generationDateAndTime"] = at
        return {name: value for name, value in given.items() if value is not None}


@frozen
class Stimuli:
    """Inputs of an experiment, step by step."""

    names: Sequence[str]  # Names of inputs, each with its rate
    durations: Floats  # (steps,): Communication steps [s]
    # (steps, names): At the start of each step, after jumps; in a step inputs move at their rates
    values: Floats


@dataclass(frozen=True)
class ExportOptions(ComponentOptions):
    """The keyword arguments of `export`, which describes them."""

    fmi: FmiVersion = 3
    platforms: Sequence[str] = ()
    name: str = "slipmode"
    start: Mapping[str, float] = field(default_factory=dict)
    largest_force: Mapping[str, float] = field(default_factory=dict)
    stop_time: float = 100.0
    step_size: float = 1.0
    reference_step: float | None = None
    stimuli: Stimuli | None = None
    origin: Origin | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_line("name", self.name)
        if self.fmi not in (2, 3):
            raise SlipmodeError(f"fmi: must be 2 or 3, got {self.fmi}")
        for key in ("stop_time", "step_size", "reference_step"):
            value = getattr(self, key)
            if value is not None and not (isfinite(value) and value > 0):
                raise SlipmodeError(f"{key}: must be a finite number > 0 [s], got {value}")

    @property
    def interval(self) -> float:
        """Interval of the reference result [s]."""
        return self.step_size if self.reference_step is None else self.reference_step
