"""The step-able component: a model that inputs go into and amplitudes come out of."""

from slipmode.fmu.archive.export import export
from slipmode.fmu.component import Component
from slipmode.fmu.stepping import Steppable, StoppedError

__all__ = ["Component", "Steppable", "StoppedError", "export"]
