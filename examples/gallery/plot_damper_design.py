"""
Which friction limit is best?
=============================

One friction table gives the resonance peak for every friction limit. A low limit dissipates
little energy, a high limit keeps the contact stuck. The lowest peak is at 3.06 N.
"""

import matplotlib.pyplot as plt

from slipmode import rom

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0,))
model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(12.0,))
curve = rom.performance_curve(model, {0: 0.15})
best, least = curve.optimum

fig, axes = plt.subplots()
axes.semilogx(2.0 * curve.limit, curve.peak)
axes.plot(2.0 * best, least, "o")
axes.set_title(f"The peak is lowest with a limit of {2.0 * best:.2f} N")
axes.grid(which="both", alpha=0.4)
axes.set(xlabel="friction limit [N]", ylabel=r"resonance peak |A| [kg$^{0.5}$ m]")
plt.show()
