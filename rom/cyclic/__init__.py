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
mistuned_disk.py   MistunedDisk: blades that differ, all nodal diameters together
disk_modes.py      its modes; disk_balance.py: its steady states
local_contacts.py  contacts by themselves; coupled_contacts.py: all contacts together
dual_contacts.py   the contact problem of these, as the core reads it
"""
