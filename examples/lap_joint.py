"""The matrices of the shipped scene "lap-joint": two beams that overlap, and the contacts between.

Plane Euler-Bernoulli beams with axial DOFs u, v, rotation at each node. The lower one is clamped
at its left end, the upper one at its right; over the lap their faces touch at some points.
"""

import sys
from pathlib import Path

import numpy as np
import scipy.sparse

from slipmode import rom

YOUNG, DENSITY = 7.0e10, 2700.0  # aluminium [Pa], [kg/m^3]
HEIGHT, DEPTH = 8e-3, 0.03  # of each beam [m]
LENGTH, LAP = 0.24, 0.04  # of each beam, and of what they share [m]
CELL = 0.01  # of the mesh [m]
POINTS = (0, 1, 3, 4)  # nodes of the lap that touch, from the end of the upper beam on
DAMPING = 1.2e-5  # beta [s]


def element() -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass (6, 6) of one cell."""
    h, EA = CELL, YOUNG * HEIGHT * DEPTH
    EI, rho = EA * HEIGHT**2 / 12.0, DENSITY * HEIGHT * DEPTH
    K, M = np.zeros((6, 6)), np.zeros((6, 6))
    axial, bending = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    K[axial] = EA / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
    M[axial] = rho * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    K[bending] = EI / h**3 * np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    )  # fmt: skip
    M[bending] = rho * h / 420.0 * np.array(
        [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    )  # fmt: skip
    return K, M


def lap_joint() -> rom.Structure:
    """The structure; contact DOFs: tangent, normal of each point, left to right.

    The lower beam has the first DOFs, node by node from its clamp; the upper one follows, from
    its free end to its clamp.
    """
    cells, shared = round(LENGTH / CELL), round(LAP / CELL)
    size = 3 * (cells + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    of_cell = element()
    for k in range(cells):
        here = slice(3 * k, 3 * k + 6)
        K[here, here] += of_cell[0]
        M[here, here] += of_cell[1]
    lower, upper = slice(3, size), slice(0, size - 3)
    n = size - 3
    W = np.zeros((2 * n, 2 * len(POINTS)))
    for i, point in enumerate(POINTS):
        below = 3 * (cells - shared + point) - 3
        above = n + 3 * point
        # the faces lie half a height off the axes: u_face = u - y rotation
        W[[below, below + 2], 2 * i] = 1.0, -0.5 * HEIGHT
        W[[above, above + 2], 2 * i] = -1.0, -0.5 * HEIGHT
        W[[below + 1, above + 1], 2 * i + 1] = 1.0, -1.0  # they close where the lower one rises

    def both(matrix: np.ndarray) -> scipy.sparse.csr_array:
        return scipy.sparse.block_diag((matrix[lower, lower], matrix[upper, upper])).tocsr()

    return rom.Structure(both(M), both(K), DAMPING, contact=W)


if __name__ == "__main__":
    folder = (
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "runner/scenes"
    )
    structure = lap_joint()
    structure.save(folder / "lap-joint.npz")
    print(structure, (folder / "lap-joint.npz").stat().st_size)
