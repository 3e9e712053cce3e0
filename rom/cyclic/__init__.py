"""Cyclic structures: bladed disks from the matrices of one sector.

disk = rom.lumped_disk(sectors=24)
wave = rom.travelling_wave(disk, rom.Jenkins(2.0, 2e4), nodal_diameter=3)
model = wave.tabulate(amplitude=1e-3, force={2: 1.0})
a = rom.steady(model, frequency=[wave.frequency], force=[{2: 1.0}])

structure.py        CyclicStructure, all sectors as one Structure. Start here.
aerodynamics.py     forces between blades, by which nodal diameters flutter
lumped_disk.py      a disk of three masses a sector
sector_mesh.py      SectorMesh, from the finite element model of a sector
diameter_modes.py   modes of one nodal diameter, and their response
diagrams.py         frequencies by nodal diameter, and Campbell diagrams
wave/               travelling waves from one sector
mistuned/           disks whose blades differ, all nodal diameters together
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
