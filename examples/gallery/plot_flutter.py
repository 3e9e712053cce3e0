"""
Flutter that friction holds
===========================

A flow puts energy into a mode. Friction holds it at the stable limit cycle; beyond the
unstable one it grows without bound. The two meet where friction cannot take more.
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
axes.plot(strength[stable], amplitude[stable], "o-", label="stable")
axes.plot(strength[~stable], amplitude[~stable], "x--", label="unstable")
axes.set(xlabel=r"-Im of the coefficient [rad$^2$/s$^2$]", ylabel=r"|A| [kg$^{0.5}$ m]")
axes.legend()
plt.show()
