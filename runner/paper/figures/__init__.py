"""The figures of the source paper, drawn anew.

figures.py lists them; motion_figures.py and resonance_figures.py draw them, in the style of
style.py.
"""
