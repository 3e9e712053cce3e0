"""A planar cantilever with one elastic contact in a turned frame: strong friction and lift-off."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from slipmode import rom
from slipmode.rom import FrictionalContact, Jenkins, full

ELEMENTS, AXIAL = 12, 400.0  # Euler-Bernoulli, L = EI = rho A = 1, EA
TIP = 3 * ELEMENTS - 2  # transverse DOF of the last node
TURNED = np.radians(35.0)  # the contact's tangent, from the beam's axis
DAMPING = 0.004  # modal, of every mode of the stuck structure
LIFT_OFF = FrictionalContact(mu=0.4, preload=1.0, tangential_stiffness=20.0, normal_stiffness=30.0)
SLIDER = Jenkins(limit=0.4, stiffness=40.0)


@dataclass(frozen=True)
class Row:
    """Forces at the tip (A, B) at omega (1 + detuning) of the stuck modes, and what they make."""

    law: FrictionalContact | Jenkins
    node: int
    force: tuple[float, float]
    detuning: tuple[float, float]
    amplitude: tuple[complex, complex]  # of modes A and B at full order, mass-normalised


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


def problem(row: Row, structure: rom.Structure) -> tuple[full.Excitation, np.ndarray]:
    """The row's forces, and rows (2, 36) that take the modal amplitudes out of displacements."""
    reduced = rom.reduce(structure, (0, 1), law=row.law)
    frequency = reduced.frequency * (1.0 + np.array(row.detuning))
    force = tuple({TIP: size} for size in row.force)
    excitation = full.Excitation.harmonic(structure, force, frequency)
    return excitation, reduced.mode_shapes.T @ structure.mass


# By 512 steps per period of B; they scatter by 5e-5 from window to window in the first and last
# row, by less than 1e-5 in the others.
ROWS = (
    Row(
        *(LIFT_OFF, 8, (0.02, 0.03), (-0.001, -0.001)),
        amplitude=(-0.0095045 - 0.0105977j, -0.0002858 - 0.0064184j),
    ),
    Row(
        *(LIFT_OFF, 8, (0.05, 0.05), (-0.01, -0.005)),
        amplitude=(-0.01728141 - 0.00687752j, 0.00348303 - 0.00995753j),
    ),
    Row(
        *(LIFT_OFF, 8, (0.1, 0.1), (-0.02, -0.01)),
        amplitude=(-0.02285658 - 0.0048023j, 0.01135441 - 0.01074956j),
    ),
    Row(
        *(LIFT_OFF, 8, (0.3, 0.3), (-0.05, -0.03)),
        amplitude=(-0.04292433 - 0.004294j, 0.01369347 - 0.00270485j),
    ),
    Row(
        *(SLIDER, 5, (0.05, 0.05), (-0.01, -0.005)),
        amplitude=(-0.0169741 - 0.0102614j, 0.0012093 - 0.0061911j),
    ),
)
