"""
A contact that lifts off
========================

A beam rubs on an oblique support: the normal load varies with the motion, and the contact is open
for part of each cycle. The frequency falls as it opens.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

cells = 12
K, M = (np.zeros((cells, cells)) for _ in range(2))
K += np.diag(np.full(cells, 2.0)) - np.diag(np.ones(cells - 1), 1) - np.diag(np.ones(cells - 1), -1)
K[-1, -1] = 1.0
M += np.eye(cells)
directions = np.zeros((cells, 2))  # tangential and normal, of one mass's motion
directions[6] = np.cos(0.6), np.sin(0.6)
chain = rom.Structure(mass=M, stiffness=100.0 * K, damping=1e-3, contact=directions)
law = rom.FrictionalContact(0.4, preload=1.0, tangential_stiffness=20.0, normal_stiffness=30.0)
reduced = rom.reduce(chain, modes=(0,), law=law)
backbone = rom.backbone(rom.tabulate(reduced, law, amplitude=(1.0,), tolerance=1e-2))
fall = 1.0 - backbone.frequency[-1] / backbone.frequency[0]

fig, axes = plt.subplots()
axes.plot(backbone.frequency, backbone.amplitude)
axes.set(xlabel="frequency [rad/s]", ylabel=r"|A| [kg$^{0.5}$ m]")
plt.show()
