"""The step-able component: a model that inputs go into and amplitudes come out of.

component.py   Component: set_inputs, do_step, outputs. Start here; its step is that of an FMU too,
               rom/kernel/slow/component/component.c.
inputs.py      names of the inputs, what is allowed, how they move
archive/ variables/ description/   the same as a file for FMI tools
src/           that file's C: faces/ (FMI 2.0, 3.0) over instance/ over resources/
imported.py    such a file as a component, through FMPy; stepping.py: what both have in common
"""

from slipmode.fmu.archive.export import export
from slipmode.fmu.component import Component
from slipmode.fmu.stepping import Steppable, StoppedError
from slipmode.rom import __version__

__all__ = ["Component", "Steppable", "StoppedError", "__version__", "export"]
