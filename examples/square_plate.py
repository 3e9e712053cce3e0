"""The matrices of the shipped scene "square-plate": a plate on simple supports, with a damper.

The sides differ by 1 %, so the modes (1, 2) and (2, 1) are 1.2 % apart. A friction damper joins
one point to the ground. The DOFs are the displacements of a grid of inner points, row by row; the
modes of the grid are those of the plate, sampled sines.
"""

import sys
from pathlib import Path

import numpy as np
import scipy.sparse

from slipmode import rom

YOUNG, DENSITY, POISSON = 7.0e10, 2700.0, 0.33  # aluminium [Pa], [kg/m^3], [-]
SIDES, THICKNESS = (0.3, 0.297), 2e-3  # [m]
POINTS = 6  # of the grid along each side, without the edges
DAMPER = 10  # DOF: second row, fifth point
DAMPING = 2e-6  # beta [s]


def square_plate() -> rom.Structure:
    """The structure; one contact, the damper."""
    rigidity = YOUNG * THICKNESS**3 / (12.0 * (1.0 - POISSON**2))
    number = np.arange(1, POINTS + 1)
    sines = np.sqrt(2.0 / (POINTS + 1)) * np.sin(
        np.pi * np.outer(number, number) / (POINTS + 1)
    )  # orthogonal
    modes = np.kron(sines, sines)
    squares = [(number * np.pi / side) ** 2 for side in SIDES]
    waves = np.add.outer(*squares).ravel()
    mass = DENSITY * THICKNESS * np.prod(SIDES) / (POINTS + 1) ** 2  # of a point
    stiffness = mass * rigidity / (DENSITY * THICKNESS) * (modes * waves**2) @ modes.T
    M, K = (
        scipy.sparse.csr_array(each)
        for each in (mass * np.eye(POINTS**2), 0.5 * (stiffness + stiffness.T))
    )
    return rom.Structure(M, K, DAMPING, contact=[DAMPER])


if __name__ == "__main__":
    folder = (
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "runner/scenes"
    )
    structure = square_plate()
    structure.save(folder / "square-plate.npz")
    print(structure, (folder / "square-plate.npz").stat().st_size)
