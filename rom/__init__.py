"""From a structure's matrices to a step-able reduced-order model.

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0, 1))
model = rom.tabulate(reduced, rom.Tanh(limit=2.0, alpha=0.02), amplitude=(4.0, 4.0))
a_A, a_B = rom.steady(model, frequency=(0.98, 1.65), force=({0: 0.15}, {1: 0.25}))

The rooms follow that chain, and the source paper's equations: structure/ (1)-(3), laws/ (28),
reduction/ (8), (13), contact/ (13), (14), (20), table/ (20), slow/ (12), (18), (19), (22)-(25);
identification/ finds laws of the slow flow in measurements, full/ is Eq. (1) integrated in
full, kernel/ what of all that is computed in C. validity/ is what the method assumes.
"""

import logging

import lazy_loader

from slipmode import __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]

# Remarks on results go to this logger; the user chooses whether they are shown.
logging.getLogger("slipmode").addHandler(logging.NullHandler())
