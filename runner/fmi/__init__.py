"""A scene as an FMU.

export.py          the model of a scene, which starts as the scene does. Start here.
command.py         the command line
ssp.py             a system structure package around the FMU
load.py            an FMU as the component of a scene
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
