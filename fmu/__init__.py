"""The step-able component: a model that inputs go into and amplitudes come out of."""

from fmu.component import Component, Steppable, StoppedError
from fmu.export import export

__all__ = ["Component", "Steppable", "StoppedError", "export"]
