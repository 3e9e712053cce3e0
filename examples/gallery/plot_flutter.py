"""
How much energy of the flow can friction take?
==============================================

A flow feeds energy into a mode, and friction limits the mode to a stable limit cycle. Beyond the
unstable limit cycle the amplitude grows without bound. The two approach each other as the flow
becomes stronger: friction fails soon after 0.025 rad^2/s^2.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

structure = rom.two_mass(beta=0.01)
law = rom.Coulomb(limit=2.0)
cycles = []
for strength in np.linspace(0.0125, 0.025, 11):
    reduced = rom.reduce(structure, modes=(0,), aerodynamics=(-1j * strength,))
    model = rom.tabulate(reduced, law, amplitude=(8.0,))
    for cycle in rom.limit_cycles(model):
        cycles.append((strength, abs(cycle.amplitude[0]), cycle.stable))
strength, amplitude, stable = map(np.array, zip(*cycles, strict=True))

fig, axes = plt.subplots()
axes.plot(strength[stable], amplitude[stable], "o-")
axes.plot(strength[~stable], amplitude[~stable], "x--")
axes.text(0.016, 1.5, "stable: friction limits the flutter", color="C0")
axes.text(0.0132, 4.6, "unstable: flutter grows above it", color="C1")
axes.grid()
axes.set(xlabel=r"-Im of the coefficient [rad$^2$/s$^2$]", ylabel=r"|A| [kg$^{0.5}$ m]")
plt.show()
