"""
How slow must a sweep be?
=========================

A sweep over 2000 s through a resonance lags behind the steady states. Its peak is 9 % lower than
the peak of the response curve.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import fmu, rom

reduced = rom.reduce(rom.two_mass(beta=0.01), modes=(0,))
model = rom.tabulate(reduced, rom.Tanh(2.0, alpha=0.02), amplitude=(4.0,))
component = fmu.Component(model, force_patterns=({0: 1.0},))
frequencies = np.linspace(0.93, 1.03, 1000)
swept = []
for step, frequency in enumerate(frequencies):
    component.set_inputs(force_A=0.15, frequency_A=frequency)
    component.do_step(2.0 * step, 2.0)
    found = component.outputs()
    swept.append(np.hypot(found["A_re"], found["A_im"]))
span = (0.93, 1.03)
curve = rom.response_curve(model, (0.98,), ({0: 0.15},), vary="frequency_A", span=span)

fig, axes = plt.subplots()
lag = 100.0 * (1.0 - max(swept) / abs(curve.amplitude[:, 0]).max())
axes.plot(frequencies, swept, label="sweep of 2000 s")
axes.plot(curve.parameter, abs(curve.amplitude[:, 0]), "--", label="steady states")
axes.set(xlabel="forcing frequency [rad/s]", ylabel=r"|A| [kg$^{0.5}$ m]")
axes.set_title(f"The peak of the sweep is {lag:.0f} % lower than the steady peak")
axes.legend()
plt.show()
