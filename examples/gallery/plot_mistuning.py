"""
Does friction or mistuning win?
===============================

A disk of 24 blades, whose tips touch, passes through a resonance with engine order 3. In 30 drawn
disks the stiffness of the blades deviates by 4 %. The largest blade amplitude, relative to that of
the tuned disk, is smaller where the contacts slip.
"""

import matplotlib.pyplot as plt
import numpy as np

from slipmode import rom

disk, law = rom.lumped_disk(sectors=24, beta=1e-5), rom.Jenkins(limit=1.0, stiffness=5e4)
wave = rom.travelling_wave(disk, law, nodal_diameter=3)
omega = wave.frequency * np.linspace(0.965, 1.02, 56)
drawn = 0.04 * np.random.default_rng(1).standard_normal((30, 24))
disks = rom.MistunedDisk(disk, law, np.vstack((np.zeros(24), drawn)), highest=1e5)

fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
median = {}
for force, colour in ((0.1, "C0"), (4.0, "C1")):  # the contacts stick, slip [N]
    response = disks.response(omega, 3, [0.0, 0.0, force], local=True)
    peak = response.peak(dof=2)
    factor = peak[1:] / peak[0]
    median[force] = np.median(factor)
    right.plot(np.sort(factor), np.arange(1, 31), colour, label=f"{force:g} N")
tip = 1e3 * response.amplitude(dof=2)
left.plot(omega / (2 * np.pi), tip[1], "0.7", lw=0.8)
left.plot(omega / (2 * np.pi), tip[0, :, 0], "k", label="tuned")
left.set(xlabel="excitation [Hz]", ylabel="blade tips [mm], 4 N")
right.set(xlabel="amplification factor", ylabel="disks, of 30")
left.legend()
right.legend()
plt.show()
