"""A planar cantilever with one elastic contact in a turned frame: strong friction and lift-off."""

import numpy as np
import scipy.linalg

from slipmode import rom
from slipmode.rom import FrictionalContact, Jenkins

ELEMENTS, AXIAL = 12, 400.0  # Euler-Bernoulli, L = EI = rho A = 1, EA
TIP = 3 * ELEMENTS - 2  # transverse DOF of the last node
TURNED = np.radians(35.0)  # the contact's tangent, from the beam's axis
DAMPING = 0.004  # modal, of every mode of the stuck structure
LIFT_OFF = FrictionalContact(mu=0.4, preload=1.0, tangential_stiffness=20.0, normal_stiffness=30.0)
SLIDER = Jenkins(limit=0.4, stiffness=40.0)


def element(h: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass (6, 6) of a beam along x: axial, transverse, rotation of both ends."""
    K, M = np.zeros((6, 6)), np.zeros((6, 6))
    transverse, axial = np.ix_([1, 2, 4, 5], [1, 2, 4, 5]), np.ix_([0, 3], [0, 3])
    bending = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h]]
    bending += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    inertia = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
    inertia += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    K[transverse], M[transverse] = np.array(bending) / h**3, np.array(inertia) * h / 420
    K[axial], M[axial] = AXIAL / h * np.array([[1, -1], [-1, 1]]), h / 6 * (np.eye(2) + 1)
    return K, M


def matrices(elements: int = ELEMENTS, *, clamped: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness, (3 nodes, 3 nodes): axial, transverse, rotation of each node."""
    k, m = element(1.0 / elements)
    K, M = np.zeros((2, 3 * (elements + 1), 3 * (elements + 1)))
    for first in range(0, 3 * elements, 3):
        at = np.ix_(*2 * [range(first, first + 6)])
        K[at] += k
        M[at] += m
    return (M[3:, 3:], K[3:, 3:]) if clamped else (M, K)


def structure(law: FrictionalContact | Jenkins, node: int) -> rom.Structure:
    """The beam with its contact: the tangent, and the normal if the law has one."""
    M, K = matrices()
    c, s = np.cos(TURNED), np.sin(TURNED)
    W = np.zeros((len(M), 1 if isinstance(law, Jenkins) else 2))
    W[3 * node - 3 : 3 * node - 1] = np.array([[c, -s], [s, c]])[:, : W.shape[1]]
    stuck = K + (W * law.elements(W.shape[1]).reference) @ W.T
    squares, shapes = scipy.linalg.eigh(stuck, M)
    C = M @ (shapes * (2 * DAMPING * np.sqrt(squares))) @ shapes.T @ M
    return rom.Structure(M, K, 0.5 * (C + C.T), contact=W)
