"""Rotors: structures whose stiffness and frequencies follow the rotor speed.

rotating.py     RotatingStructure: K_0 + Omega^2 K_1, and its modes over speeds. Start here.
speed_modes.py  SpeedModes: modes followed over rotor speeds, the Campbell diagram
reduction.py    reduce_rotating: a reduced model whose frequencies follow the rotor speed
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
