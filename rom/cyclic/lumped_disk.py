"""A disk of three masses a sector, whose frequencies are published."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.cyclic.structure import CyclicStructure


def lumped_disk(
    sectors: int = 24,
    beta: float = 2e-6,
    *,
    disk_mass: float = 1.2,
    blade_masses: tuple[float, float] = (0.35, 0.25),
    disk_stiffness: float = 5e7,
    ground_stiffness: float = 6e5,
    blade_stiffnesses: tuple[float, float] = (1e6, 2e6),
    contact: ArrayLike | None = None,
    next_contact: ArrayLike | None = None,
) -> CyclicStructure:
    """Return a disk with one disk mass and two blade masses in each sector.

    DOFs 0, 1 and 2 of a sector are the disk and the two blade masses. Springs connect the disk
    mass to the ground, to the next disk mass and to the first blade mass, and both blade masses.
    The defaults are the lumped disk of the tutorial of pyHarm. Its natural frequencies are 88.264,
    169.344 (twice) and 189.302 Hz (twice) at nodal diameters 0, 1 and 2.

    Parameters
    ----------
    sectors : int, default 24
        Number of sectors N, at least 3.
    beta : float, default 2e-6
        Factor of stiffness-proportional damping, C = beta K [s].
    disk_mass : float, default 1.2
        Mass of the disk [kg].
    blade_masses : (float, float), default (0.35, 0.25)
        Masses of the blade, from the root [kg].
    disk_stiffness : float, default 5e7
        Stiffness between neighbouring disk masses [N/m].
    ground_stiffness : float, default 6e5
        Stiffness between disk mass and ground [N/m].
    blade_stiffnesses : (float, float), default (1e6, 2e6)
        Stiffness between disk and first blade mass, and between the blade masses [N/m].
    contact, next_contact : (3, N_c) array_like, optional
        Directions of the contacts on a sector and on the next sector [-]. Default: the tips (DOF
        2) of neighbouring blades rub against each other.

    Returns
    -------
    CyclicStructure
        Disk with n = 3 DOFs in each sector.

    Examples
    --------
    >>> rom.lumped_disk(24)
    CyclicStructure(24 sectors of 3 DOFs, 1 contacts each)
    """
    k1, k2 = blade_stiffnesses
    blade = np.array([[k1, -k1, 0.0], [-k1, k1 + k2, -k2], [0.0, -k2, k2]])
    # DOF 3 is the disk mass of the next sector.
    blade = np.pad(blade, (0, 1))
    stiffness = blade + disk_stiffness * np.outer([1.0, 0.0, 0.0, -1.0], [1.0, 0.0, 0.0, -1.0])
    stiffness[0, 0] += ground_stiffness
    if contact is None:
        contact, next_contact = [[0.0], [0.0], [-1.0]], [[0.0], [0.0], [1.0]]
    own = np.asarray(contact, dtype=float)
    following = 0.0 * own if next_contact is None else np.asarray(next_contact, dtype=float)
    return CyclicStructure(
        np.diag([disk_mass, *blade_masses, 0.0]),
        stiffness,
        sectors,
        beta,
        contact=np.pad(own, ((0, 1), (0, 0))),
        next_contact=np.pad(following, ((0, 1), (0, 0))),
        blade=blade,
        left=[0],
        right=[3],
    )
