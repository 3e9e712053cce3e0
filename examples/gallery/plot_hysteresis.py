"""
How much power does a contact dissipate?
========================================

The scene requests the motion of its contact in a window of time. The area of the hysteresis loop
is the energy that friction dissipates in a cycle; the mean power is 0.27 W.
"""

from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

from slipmode import runner

recording = runner.run("one-mode", mkdtemp())
contact = runner.load(recording.mcap)["/contact/0"]
x, f = contact.column("x"), contact.column("f")
seconds = contact.time[-1] - contact.time[0]
power = np.trapezoid(f * contact.column("v"), contact.time) / seconds

fig, axes = plt.subplots()
axes.plot(x, f)
axes.set(
    xlabel="displacement [m]",
    ylabel="friction force [N]",
    title=f"Friction dissipates {power:.3f} W",
)
axes.grid()
plt.show()
