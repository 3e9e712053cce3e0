"""An L-shaped planar frame of beam elements with Jenkins contacts to the ground."""

import numpy as np
import scipy.linalg
from elastic.frictional_beam import element

from slipmode import rom

ELEMENTS = 8  # per leg, of length 1
TIP = 6 * ELEMENTS - 2  # vertical DOF of the free end of the horizontal leg
DAMPING = 0.004  # modal, of every mode of the stuck structure
LAW = rom.Jenkins(limit=(0.4, 0.3), stiffness=(4.0, 3.0))
NODES = (5, 12)  # of the contacts, counted from 1 at the clamped end


def l_frame():
    """A vertical leg clamped at its foot, a horizontal one from its head; friction on both."""
    size = 3 * (2 * ELEMENTS + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    along_x = element(1.0 / ELEMENTS)
    turn = scipy.linalg.block_diag(*2 * [[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    for e in range(2 * ELEMENTS):
        at = np.ix_(*2 * [range(3 * e, 3 * e + 6)])
        k, m = (turn.T @ x @ turn if e < ELEMENTS else x for x in along_x)
        K[at] += k
        M[at] += m
    K, M = K[3:, 3:], M[3:, 3:]
    W = np.zeros((len(M), 2))
    W[3 * NODES[0] - 3, 0] = 1.0  # across the vertical leg
    W[3 * NODES[1] - 2, 1] = 1.0  # across the horizontal leg
    stuck = K + (W * LAW.elements(2).reference) @ W.T
    squares, shapes = scipy.linalg.eigh(stuck, M)
    C = M @ (shapes * (2 * DAMPING * np.sqrt(squares))) @ shapes.T @ M
    return rom.Structure(M, K, 0.5 * (C + C.T), contact=W)
