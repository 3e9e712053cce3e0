"""A scene as an FMU.

export.py          the model of a scene, which starts as the scene does. Start here.
force_range.py     how hard it may be forced
command.py         the command line
ssp.py             a system structure package around the FMU
load.py            such a file in the place of a scene's component
"""
