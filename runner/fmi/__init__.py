"""A scene as an FMU.

export.py          the model of a scene, which starts as the scene does. Start here.
command.py         the command line
ssp.py             a system structure package around the FMU
load.py            an FMU as the component of a scene
"""
