"""The step-able component: a model that inputs go into and amplitudes come out of.

component.py   Component: set_inputs, do_step, outputs. Start here; an FMU takes the same steps,
               rom/kernel/slow/component/component.c. handle.py: its options, and the core's part
inputs.py      names of the inputs, allowed values, how they move; outputs.py: names of the outputs
archive/ variables/ description/   the component as a file for FMI tools
src/           C of that file: faces/ (FMI 2.0, 3.0, browser/) over instance/ over resources/
imported.py    such a file as a component, through FMPy; stepping.py: the interface of both
"""

import lazy_loader

from slipmode import __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]
