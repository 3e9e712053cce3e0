"""
The best friction limit
=======================

The resonance peak for every friction limit at once, from one table: too small a limit takes out
little energy, too large a one keeps the contact stuck.
"""

import matplotlib.pyplot as plt

from slipmode import rom

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0,))
model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(12.0,))
curve = rom.performance_curve(model, {0: 0.15})
best, least = curve.optimum

fig, axes = plt.subplots()
axes.loglog(2.0 * curve.limit, curve.peak)
axes.plot(2.0 * best, least, "o", label=f"best: {2.0 * best:.2f} N")
axes.set(xlabel="friction limit [N]", ylabel=r"resonance peak |A| [kg$^{0.5}$ m]")
axes.legend()
plt.show()
