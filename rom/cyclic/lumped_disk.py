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
    """Return a disk of one disk mass and two blade masses a sector, DOFs 0, 1 and 2.

    The springs of a sector are: disk to ground, to the next disk mass and to the first blade mass,
    and between the blade masses. The defaults are the lumped disk of pyHarm's tutorial: natural
    frequencies 88.264, 169.344 (twice) and 189.302 Hz (twice) at nodal diameters 0, 1 and 2 of 24
    sectors.

    Parameters
    ----------
    sectors : int
        At least 3.
    beta : float
        C = beta K [s].
    disk_mass, blade_masses : float
        [kg]
    disk_stiffness, ground_stiffness, blade_stiffnesses : float
        [N/m]
    contact, next_contact : (3, N_c) array_like, optional
        Directions on a sector and on the next. Default: the blade tips, DOF 2, of neighbours touch
        each other, by displacements in the direction of the DOFs.
    """
    k, (k1, k2) = disk_stiffness, blade_stiffnesses
    # DOF 3 is the disk mass of the next sector.
    stiffness = np.array(
        [
            [ground_stiffness + k + k1, -k1, 0.0, -k],
            [-k1, k1 + k2, -k2, 0.0],
            [0.0, -k2, k2, 0.0],
            [-k, 0.0, 0.0, k],
        ]
    )
    if contact is None:
        contact, next_contact = [[0.0], [0.0], [-1.0]], [[0.0], [0.0], [1.0]]
    own = np.asarray(contact, dtype=float)
    further = np.zeros_like(own) if next_contact is None else np.asarray(next_contact, dtype=float)
    blade = np.zeros((4, 4))
    blade[:3, :3] = [[k1, -k1, 0.0], [-k1, k1 + k2, -k2], [0.0, -k2, k2]]
    return CyclicStructure(
        np.diag([disk_mass, *blade_masses, 0.0]),
        stiffness,
        sectors,
        beta,
        contact=np.vstack((own, np.zeros_like(own[:1]))),
        next_contact=np.vstack((further, np.zeros_like(further[:1]))),
        blade=blade,
        left=[0],
        right=[3],
    )
