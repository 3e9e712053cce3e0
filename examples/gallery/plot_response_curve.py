"""
Response curves at five forces
==============================

Stuck, the peak is that of a stiff structure; slipping, that of a soft and damped one.
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
axes.set(xlabel="forcing frequency [rad/s]", ylabel="|A| per force")
axes.legend()
plt.show()
