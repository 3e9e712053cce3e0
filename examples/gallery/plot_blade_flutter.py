"""
Does an engine order end the flutter of blades?
===============================================

Aerodynamic forces between the 24 blades of a disk feed energy into six nodal diameters. Friction
between the blade tips limits nodal diameter 6 to a small amplitude. Engine order 4 near a mode of
the second family makes the contacts slip, too, and ends the flutter at 3.1 N.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

influence = {-1: 2e3, 0: 1e3j, 1: -2e3}  # by distance of the blade that moves [N/m]
disk = rom.lumped_disk(sectors=24, beta=2e-6).with_aerodynamics([2], influence, 1250.0)
law = rom.Jenkins(limit=1.0, stiffness=2e4)
linear = rom.flutter_growth(disk, law)
flutter = rom.travelling_wave(disk, law, nodal_diameter=6)
forced = rom.travelling_wave(disk, law, nodal_diameter=4, mode=1)
cycle, unstable = flutter.limit_cycles()
omega = 0.999 * forced.frequency
(most,) = forced.steady_states(omega, {2: 4.0})
ends = 1.5 * abs(cycle.amplitude), 1.1 * abs(most.amplitude)
at = cycle.frequency, omega
model = rom.tabulate_waves((flutter, forced), ends, (None, {2: 4.0}), 5e-3, frequency=at)
tip = 2e3 * abs(flutter.shape[2])  # mm per amplitude

force, amplitude = np.linspace(0.05, 4.0, 30), []
for each in force:
    found = rom.limit_cycles(model, (None, omega), [{}, {2: each}])
    amplitude.append(tip * abs(found[0].amplitude[0]) if found else 0.0)

fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.bar(linear.nodal_diameter, linear.growth)
left.set(xlabel="nodal diameter", ylabel="growth rate while contacts stick [1/s]")
right.plot(force, amplitude, ".-")
right.set(xlabel="engine order 4 [N]", ylabel="flutter of the blade tips [mm]")
plt.show()
