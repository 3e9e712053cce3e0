"""The step-able component: a model that inputs go into and amplitudes come out of."""

from fmu.component import Component
from fmu.export import export
from fmu.stepping import Steppable, StoppedError

__all__ = ["Component", "Steppable", "StoppedError", "export"]
