"""
What does a second tone do to the damping?
==========================================

Mode B vibrates at its own frequency and makes the contact slip for more of the time. Where mode A
alone leaves the contact stuck (amplitude 0.5), B raises the damping ratio of A from 1.0 to 1.6 %.
Where A makes the contact slip widely (amplitude 3.5), B changes it by less than 0.05 %.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0, 1))
law = rom.Tanh(2.0, alpha=0.02)
model = rom.tabulate(reduced, law, amplitude=(4.0, 4.0), tolerance=1e-2)

others = np.linspace(0.0, 4.0, 41)
amplitudes = [0.5, 0.9, 1.2, 2.0, 3.5]
damping = np.array([rom.backbone(model, 0, b, amplitudes).damping for b in others])

fig, axes = plt.subplots()
axes.plot(others, 100 * damping)
for size, zeta in zip(amplitudes, damping[0], strict=True):
    axes.text(0.0, 100 * zeta, f"|A| = {size:g}", va="bottom")
axes.set(xlabel=r"|B| [kg$^{0.5}$ m]", ylabel="damping ratio of A [%]")
most = 100 * damping[:, 0].max()
axes.set_title(f"B raises the damping to {most:.1f} %, from {100 * damping[0, 0]:.1f} %")
axes.grid()
plt.show()
