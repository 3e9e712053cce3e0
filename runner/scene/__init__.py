"""Scenes: TOML files with a structure, its friction, and scripted forces.

keys.py         every key with its kind, unit, default and meaning. Start here
scene.py        reading a file; contacts.py: the laws of its contacts
saved_model.py  a saved model instead of a structure with contacts
sections.py     a scene in Python
toml_table.py   tables of declared keys, read and written; values.py: kinds of values
script.py       a quantity over time by breakpoints; schedule.py: all scripts as steps
kept.py         static state and reduction of large structures, stored on disk
"""
