"""Disks with aerodynamic forces on the blade tips, by which some nodal diameters flutter."""

from slipmode import rom

# Of the neighbours up to the second; forward and backward waves differ.
INFLUENCE = {0: -3e3j, 1: 2e3 - 3e3j, -1: 1e3 + 4e3j, 2: 300.0, -2: -200j}
FREQUENCY = 1200.0


def fluttering_disk(sectors, own=INFLUENCE[0], **given):
    """A disk without aerodynamic forces, and the same with them."""
    disk = rom.lumped_disk(sectors, 2e-6, **given)
    return disk, disk.with_aerodynamics([2], INFLUENCE | {0: own}, FREQUENCY)
