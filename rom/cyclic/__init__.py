"""Cyclic structures: bladed disks from the matrices of one sector.

disk = rom.lumped_disk(sectors=24)
wave = rom.travelling_wave(disk, rom.Jenkins(2.0, 2e4), nodal_diameter=3)
model = wave.tabulate(amplitude=1e-3)
a = rom.steady(model, frequency=[wave.frequency], force=[{2: 1.0}])

structure.py       CyclicStructure; all sectors as one Structure. Start here.
disks.py           lumped disks
diameter_modes.py  modes of one nodal diameter, and their response
wave_problem.py    the contact problem of a travelling wave
travelling_wave.py TravellingWave: steady states, and models for everything else
"""
