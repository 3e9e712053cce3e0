"""The periodic motion of the contacts, Eqs. (13), (14): a march along the torus of the carriers.

motion.py         its harmonics P_nm. Start here; the march is rom/kernel/torus/torus.c.
grid.py           steps and phase lines of it
problem.py        the contact problem as the core reads it
marched_modes.py  modes that are marched along with elastic contacts
"""
