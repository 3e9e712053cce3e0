"""Scenes: TOML files with a structure, its friction, and scripted forces.

scene.py        which keys there are, read section by section. Start here.
contacts.py     the laws of contacts: [friction], [[contacts]]
sections.py     what a scene is in Python, with units
kept.py         static state and reduction of large structures, kept on disk
toml_table.py   values by kind; a refusal names the full key; toml_writer.py: back to text
reference.py    every key in words, for the documentation
script.py       a quantity over time: breakpoints; schedule.py: all of them as steps
"""
