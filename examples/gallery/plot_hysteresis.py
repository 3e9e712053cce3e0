"""
Hysteresis in a recording
=========================

A scene asks for the motion of its contacts in a window; the area of the loop is what friction
takes out in a cycle.
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
axes.set(xlabel="displacement [m]", ylabel="friction force [N]", title=f"{power:.3f} W")
plt.show()
