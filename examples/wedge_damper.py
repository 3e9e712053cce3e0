"""The matrices of the shipped scene "wedge-damper": two bodies and a damper pressed between them.

Model of Balaji and Ferhatoglu, "Vibration response variability in friction-damped systems".
"""

import sys
from pathlib import Path

import numpy as np
import scipy.sparse

from slipmode import rom

MASS, DAMPER_MASS = 10.0, 0.1  # [kg]
GROUND, DAMPING = 1e5, 20.0  # of each DOF of the bodies [N/m], [N s/m]
COUPLING = {(0, 1): 9e5, (2, 3): 3e5, (4, 5): 1e6}  # between two DOFs [N/m]
ANGLES = np.radians([40.0, -40.0])  # of the faces of the damper


def wedge_damper() -> rom.Structure:
    """Return the structure: DOFs 0, 1 and 2, 3 of the bodies, 4, 5 of the damper.

    Contact DOFs: tangent and normal of the first and of the second face.
    """
    K = np.diag([GROUND] * 4 + [0.0, 0.0])
    for pair, k in COUPLING.items():
        K[np.ix_(pair, pair)] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    W = np.zeros((6, 4))
    for face, angle in enumerate(ANGLES):
        columns = slice(2 * face, 2 * face + 2)
        W[4:, columns] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        W[columns, columns] = -W[4:, columns]
    M, C = np.diag([MASS] * 4 + [DAMPER_MASS] * 2), np.diag([DAMPING] * 4 + [0.0, 0.0])
    sparse = scipy.sparse.csr_array
    return rom.Structure(sparse(M), sparse(K), sparse(C), contact=sparse(W))


if __name__ == "__main__":
    folder = (
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "runner/scenes"
    )
    wedge_damper().save(folder / "wedge-damper.npz")
