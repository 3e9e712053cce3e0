"""
At which force does friction damp a resonance best?
===================================================

The response per force is a measure of damping. The peak is lowest at 0.06 to 0.08 N: with less
force the contact sticks, with more it slips freely and the mode is soft.
"""

import matplotlib.pyplot as plt

from slipmode import rom

structure = rom.two_mass(beta=0.002)
reduced = rom.reduce(structure, modes=(0,))
model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(12.0,))

fig, axes = plt.subplots()
peaks = {}
near, span = (0.98,), (0.9, 1.05)
for force in (0.02, 0.04, 0.06, 0.08, 0.1):
    curve = rom.response_curve(model, near, ({0: force},), vary="frequency_A", span=span)
    size = abs(curve.amplitude[:, 0]) / force
    peaks[force] = size.max()
    axes.plot(curve.parameter, size, label=f"{force:g} N")
axes.set(xlabel="forcing frequency [rad/s]", ylabel=r"|A| per force [kg$^{0.5}$ m/N]")
best = min(peaks, key=peaks.get)
axes.set_title(f"The peak per force is lowest at {best:g} N")
axes.grid()
axes.legend()
plt.show()
