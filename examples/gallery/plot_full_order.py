"""
How exact is a steady state of the slow flow?
=============================================

The same steady states are computed from the friction table and by integrating the full equations
in time. They differ by 0.04 % at most.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom
from slipmode.rom import full

structure, law = rom.two_mass(beta=0.01), rom.Tanh(limit=2.0, alpha=0.02)
reduced = rom.reduce(structure, modes=(0,))
model = rom.tabulate(reduced, law, amplitude=(4.0,))

frequencies, force = np.linspace(0.94, 1.02, 7), ({0: 0.15},)
slow = [abs(rom.steady(model, (w,), force)[0]) for w in np.linspace(0.94, 1.02, 60)]
exact = []
for w in frequencies:
    excitation = full.Excitation.harmonic(structure, force, frequency=(w,))
    steady = full.steady_amplitude(structure, law, excitation, outputs=(0,))
    exact.append(abs(steady.amplitude[0, 0] / reduced.mode_shapes[0, 0]))
there = [abs(rom.steady(model, (w,), force)[0]) for w in frequencies]
error = np.max(np.abs(np.array(there) / exact - 1.0))

fig, axes = plt.subplots()
axes.plot(np.linspace(0.94, 1.02, 60), slow, label="slow flow")
axes.plot(frequencies, exact, "o", label="full order")
axes.set_title(f"Slow flow and full order differ by {100 * error:.2f} % at most")
axes.grid()
axes.set(xlabel="forcing frequency [rad/s]", ylabel=r"|A| [kg$^{0.5}$ m]")
axes.legend()
plt.show()
