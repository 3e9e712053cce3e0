"""Curves of a scene, each a picture and a file: `slipmode curve`, `backbone` and `design`.

scene_curves.py    the model of a scene over all that a curve reaches, and its curves
curve_charts.py    curves as recordings in Rerun; disk_charts.py: diagrams of bladed disks
"""
