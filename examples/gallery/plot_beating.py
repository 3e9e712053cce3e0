"""
From rest, beside a resonance
=============================

Slow time has the beats between the free vibration and the forced one, and their end.
"""

from tempfile import mkdtemp

import matplotlib.pyplot as plt

from slipmode import runner

recording = runner.run("beating", mkdtemp())
modes = runner.load(recording.mcap)["/modes"]
amplitude = modes.column("A_abs")
highest, last = amplitude.max(), amplitude[-1]

fig, axes = plt.subplots()
axes.plot(modes.time, amplitude)
axes.set(xlabel="time [s]", ylabel=r"|A| [kg$^{0.5}$ m]")
plt.show()
