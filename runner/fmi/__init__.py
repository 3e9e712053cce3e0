"""A scene as an FMU.

export.py          the model of a scene, which starts as the scene does. Start here.
force_range.py     largest forces that its friction table allows
command.py         the command line
ssp.py             a system structure package around the FMU
load.py            an FMU as the component of a scene
"""
