"""What an FMU says of itself in modelDescription.xml, whatever the version of the standard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

from slipmode.fmu.variables.variable import Variable
from slipmode.rom import SlipmodeError
from slipmode.rom.text import checked_line

FmiVersion = Literal[2, 3]
MODEL_IDENTIFIER = "slipmode"


@dataclass(frozen=True)
class Experiment:
    """The experiment that an importer offers first.

    Attributes
    ----------
    stop_time : float
        [s]
    step_size : float
        Communication step, and that of fixed-step integrators [s].
    tolerance : float
    reference_step : float
        Interval of the reference result [s].
    """

    stop_time: float
    step_size: float
    tolerance: float
    reference_step: float


@dataclass(frozen=True)
class Origin:
    """Whose model it is; what is None is not said.

    Attributes
    ----------
    author, copyright, license : str, optional
        One line each; of the model. The library in the FMU has the license of slipmode.
    generated : datetime, optional
        With a time zone.
    """

    author: str | None = None
    copyright: str | None = None
    license: str | None = None
    generated: datetime | None = None

    def __post_init__(self) -> None:
        for key in ("author", "copyright", "license"):
            if (value := getattr(self, key)) is not None:
                checked_line(key, value)
        if self.generated is not None and self.generated.tzinfo is None:
            raise SlipmodeError("generated: must have a time zone")

    def attributes(self) -> dict[str, str]:
        """As both versions of the standard write it."""
        said = {"author": self.author, "copyright": self.copyright, "license": self.license}
        if self.generated is not None:
            at = self.generated.astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            said["generationDateAndTime"] = at
        return {name: value for name, value in said.items() if value is not None}


@dataclass(frozen=True)
class Description:
    """What an FMU says of itself.

    Attributes
    ----------
    name : str
        Of the model.
    description : str
    version : str
        Of slipmode.
    token : str
        Instantiation token: the content hash of the resources.
    variables : sequence of Variable
    experiment : Experiment
    sources : sequence of str
        C files in sources/.
    origin : Origin
    """

    name: str
    description: str
    version: str
    token: str
    variables: Sequence[Variable]
    experiment: Experiment
    sources: Sequence[str]
    origin: Origin = Origin()
