"""
Two modes, one friction
=======================

The force on the second mode grows: once that moves, the contacts slide more of the time, and
what they do to the first mode changes.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0, 1), carrier=(0.98, 1.65))
law = rom.Tanh(2.0, alpha=0.02)
model = rom.tabulate(reduced, law, amplitude=(4.0, 2.0), tolerance=1e-2)

forces = np.linspace(0.0, 0.3, 13)
frequency = (0.98, 1.65)
found = np.array([rom.steady(model, frequency, ({0: 0.15}, {1: f})) for f in forces])

fig, axes = plt.subplots()
axes.plot(forces, abs(found[:, 0]), label="|A|, forced by 0.15 N")
axes.plot(forces, abs(found[:, 1]), label="|B|")
axes.set(xlabel="force on mode B [N]", ylabel=r"amplitude [kg$^{0.5}$ m]")
axes.legend()
plt.show()
