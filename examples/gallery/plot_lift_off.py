"""
How far does the frequency fall when a contact lifts off?
=========================================================

The foot of a body, on oblique springs, slides along its support. Its normal load varies, and it
is open for part of each cycle at large amplitudes. The frequency falls by 14 %.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

turned = np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]])
springs = np.diag([100.0, 900.0])  # from the body to its foot
oblique = turned @ springs @ turned.T
# the body moves along, not upwards
joined = np.hstack((-np.array([[1.0], [0.0]]), np.eye(2)))
stiffness = joined.T @ oblique @ joined
stiffness[0, 0] += 50.0
inertia = np.diag([1.0, 0.02, 0.02])
mass = rom.Structure(mass=inertia, stiffness=stiffness, damping=1e-3, contact=[1, 2])
stiffness = {"tangential_stiffness": 20.0, "normal_stiffness": 60.0}
law = rom.FrictionalContact(0.4, preload=1.0, **stiffness)
reduced = rom.reduce(mass, modes=(0,), law=law)
backbone = rom.backbone(rom.tabulate(reduced, law, amplitude=(1.0,), tolerance=1e-3))
fall = 1.0 - backbone.frequency[-1] / backbone.frequency[0]

fig, axes = plt.subplots()
axes.plot(backbone.frequency, backbone.amplitude)
axes.set_title(f"The frequency falls by {100 * fall:.0f} %")
axes.grid()
axes.set(xlabel="frequency [rad/s]", ylabel=r"|A| [kg$^{0.5}$ m]")
plt.show()
