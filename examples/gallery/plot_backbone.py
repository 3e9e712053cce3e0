"""
At which amplitude does a contact damp most?
============================================

The damped nonlinear mode has the frequency and the damping of free vibration at each amplitude.
The contact damps most at twice the amplitude at which it begins to slip. The damping ratio is
0.88 % there and 0.1 % without slip.
"""

import matplotlib.pyplot as plt

from slipmode import rom

structure = rom.two_mass(beta=0.002)
reduced = rom.reduce(structure, modes=(0,))
model = rom.tabulate(reduced, rom.Coulomb(limit=2.0), amplitude=(12.0,))
backbone = rom.backbone(model)

best = backbone.damping.argmax()
most = backbone.damping[best]

fig, (above, below) = plt.subplots(2, sharex=True)
above.set_title(f"Largest damping: {100 * most:.2f} %")
above.grid(), below.grid()
above.plot(backbone.amplitude, backbone.frequency)
above.set_ylabel("frequency [rad/s]")
below.plot(backbone.amplitude, 100 * backbone.damping)
below.plot(backbone.amplitude[best], 100 * most, "o")
below.set(xlabel=r"|A| [kg$^{0.5}$ m]", ylabel="damping ratio [%]")
plt.show()
