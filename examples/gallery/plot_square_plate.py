"""
One force, two nearly equal modes
=================================

A plate of 300 by 297 mm has two modes 2 % apart, with one and two half waves along its sides. One
force at a point moves both, and a friction damper couples them. As the force passes their
resonances, its response turns from one mode to the other: below and above, the two amplitudes are
in phase, a line; in between they are a quarter of a period apart, and the nodal line of the plate
goes round. The damper slips most at the second resonance, and moves it down by 1 %.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom, runner

plate = rom.load_structure(runner.shipped_scenes()["square-plate"].with_suffix(".npz"))
damper = rom.Jenkins(limit=0.8, stiffness=1e4)
reduced = rom.reduce(plate, modes=(1, 2), law=damper, tones=(0, 0))
model = rom.tabulate(reduced, damper)
span = 2 * np.pi * np.array([268, 288])

fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
peak = {}
for force, style in ((0.05, ":"), (1.0, "-")):  # the damper sticks, slips [N]
    curve = rom.response_curve(model, [0.0], [{13: force}], "frequency_A", span)
    size = np.abs(curve.amplitude) / force
    peak[force] = curve.frequency[size.argmax(axis=0)] / (2 * np.pi)
    for name, each, colour in zip(curve.modes, size.T, ("C0", "C1"), strict=True):
        left.plot(curve.frequency / (2 * np.pi), 1e6 * each, style, c=colour, label=f"|{name}|")
turn = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
for k, hertz in enumerate((273, 274.2, 275.2, 276.5, 279)):
    a, a2 = rom.steady(model, [2 * np.pi * hertz], [{13: 1.0}])
    orbit = [(2e6 * each * turn).real for each in (a, a2)]
    right.plot(*orbit, c=plt.cm.viridis(k / 5), label=f"{hertz} Hz")
left.set(xlabel="excitation [Hz]", ylabel=r"amplitude per force [$10^{-6}$ kg$^{1/2}$ m/N]")
right.set(xlabel="displacement of mode A", ylabel="displacement of mode A2", aspect="equal")
left.legend(["stuck, |A|", "|A2|", "1 N, |A|", "|A2|"]), right.legend()
