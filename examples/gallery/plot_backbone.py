"""
Damping of one contact
======================

The damped nonlinear mode: what friction does to the frequency and the damping of a mode grows once
the contact slips, and falls again where the limit is small against the motion.
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
above.plot(backbone.amplitude, backbone.frequency)
above.set_ylabel("frequency [rad/s]")
below.plot(backbone.amplitude, 100 * backbone.damping)
below.plot(backbone.amplitude[best], 100 * most, "o")
below.set(xlabel=r"|A| [kg$^{0.5}$ m]", ylabel="damping ratio [%]")
plt.show()
