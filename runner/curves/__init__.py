"""Curves of a scene's structure, each a picture and a file: `slipmode curve`, `slipmode backbone`.

scene_curves.py    the model of a scene over all that a curve reaches, and its curves
commands.py        the command line
"""
