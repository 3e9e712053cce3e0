"""The torus of the two phases and the march along it, Eqs. (13), (14).

march.py          a contact problem as the core (rom/kernel/torus) reads and solves it
grid.py           its steps and phase lines
marched_modes.py  modes that are marched along with elastic contacts
"""
