"""
How long until the vibration is steady?
=======================================

A force begins to act near a resonance, and the free vibration beats against the forced one. The
amplitude is twice its final value at first, and stays within 25 % of it after 1205 s.
"""

from tempfile import mkdtemp

import matplotlib.pyplot as plt

from slipmode import runner

recording = runner.run("beating", mkdtemp())
modes = runner.load(recording.mcap)["/modes"]
amplitude = modes.column("A_abs")
highest, last = amplitude.max(), amplitude[-1]
settled = modes.time[abs(amplitude / last - 1.0) > 0.25][-1]

fig, axes = plt.subplots()
axes.plot(modes.time, amplitude)
axes.axhspan(0.75 * last, 1.25 * last, alpha=0.2)
axes.set_title(f"Within 25 % of the steady amplitude after {settled:.0f} s")
axes.grid()
axes.set(xlabel="time [s]", ylabel=r"|A| [kg$^{0.5}$ m]")
plt.show()
