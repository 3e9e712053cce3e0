"""The step-able component: a model that inputs go into and amplitudes come out of."""

from fmu.component import Component, Steppable, StoppedError

__all__ = ["Component", "Steppable", "StoppedError"]
