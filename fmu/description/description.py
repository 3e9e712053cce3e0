"""What an FMU says of itself in modelDescription.xml, whatever the version of the standard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from slipmode.fmu.variables.variable import Variable

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
    """

    name: str
    description: str
    version: str
    token: str
    variables: Sequence[Variable]
    experiment: Experiment
    sources: Sequence[str]
