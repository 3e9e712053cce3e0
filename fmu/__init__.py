"""The step-able component: a model that inputs go into and amplitudes come out of."""

from slipmode.fmu.archive.export import export
from slipmode.fmu.component import Component
from slipmode.fmu.stepping import Steppable, StoppedError
from slipmode.rom import __version__

__all__ = ["Component", "Steppable", "StoppedError", "__version__", "export"]
