"""Scenes: TOML files with a structure, its friction, and scripted forces.

keys.py         every key with its kind, unit, default and meaning; structure_keys.py: keys of the
                structure and its contacts. Start here
scene.py        rules that link keys; contacts.py, structures.py: the laws and matrices of a scene
sections.py     a scene in Python
toml_table.py   declared tables, read and written; values.py: kinds of values
script.py       a quantity over time by breakpoints; schedule.py: all scripts as steps
kept.py         static state and reduction of large structures, stored on disk
"""
