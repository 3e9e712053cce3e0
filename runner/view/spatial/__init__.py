"""Drawings of motion in space: over the phases of two carriers, and of all sectors of a disk.

drawings.py    which of them a recording has
torus_view.py  motion of a contact over the phases of both carriers
disk_view.py   every sector of a bladed disk
blade_map.py   amplitudes of all blades over time
"""
