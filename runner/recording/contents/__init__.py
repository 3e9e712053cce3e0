"""The contents of MCAP files, whole or damaged.

inventory.py   what a file holds and what is missing from it, for all who read it. Start here.
walk.py        the walk over the records of a file, and its continuation after damage
chunks.py      chunks as arrays of messages, within a limit of memory
layout.py      the layout of messages; summary.py: the summary section
"""
