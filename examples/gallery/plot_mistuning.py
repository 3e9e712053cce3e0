"""
Does friction or mistuning win?
===============================

The tips of 24 blades touch, and engine order 3 excites a resonance. In 100 random disks the
stiffness of the blades deviates by 4 %. The median amplification of the largest blade is 1.50
where the contacts stick and 1.27 where they slip. Bands have 95 % confidence; dashed lines are
extreme value distributions.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

disk = rom.lumped_disk(sectors=24, beta=1e-5, blade_stiffnesses=(1e6, 4e6))
law = rom.Jenkins(limit=1.0, stiffness=5e4)
wave = rom.travelling_wave(disk, law, nodal_diameter=3)
omega = wave.frequency * np.linspace(0.955, 1.02, 60)
patterns = rom.random_mistuning(100, 24, 0.04, seed=1)
disks = rom.MistunedDisk(disk, law, patterns, highest=1e5)

fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
median = {}
for force, colour in ((0.1, "C0"), (4.0, "C1")):  # the contacts stick, slip [N]
    found = disks.amplification(omega, 3, {2: force}, dof=2)
    median[force], *_ = found.quantile(0.5)
    below, low, high = found.distribution()
    right.plot(found.factor, below, colour, label=f"{force:g} N")
    right.fill_between(found.factor, low, high, color=colour, alpha=0.2, lw=0)
    right.plot(found.factor, found.extreme_value.cdf(found.factor), colour, ls="--")
two = rom.MistunedDisk(disk, law, [np.zeros(24), disks.deviation[0]], highest=1e5)
tuned, tips = 1e3 * two.response(omega, 3, {2: 4.0}, local=True).amplitude(dof=2)
left.plot(omega / (2 * np.pi), tips, "0.7", lw=0.8)
left.plot(omega / (2 * np.pi), tuned[:, 0], "k", label="tuned")
left.set(xlabel="excitation [Hz]", ylabel="blade tips of one disk [mm], 4 N")
right.set(xlabel="amplification factor", ylabel="part of the disks below")
left.legend(), right.legend()
