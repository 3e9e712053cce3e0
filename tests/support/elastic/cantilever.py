"""A cantilever with elastic contacts, and models of it that take a second to tabulate."""

from functools import cache

import numpy as np
from elastic.frictional_beam import matrices
from scipy.linalg import eigh

from slipmode import rom

ELEMENTS = 8
TIP = 3 * ELEMENTS - 2  # its transverse DOF
FORCE_PATTERNS = ({TIP: 1.0}, {TIP: 1.0})
DOFS = (TIP, 5)
FORCES = {"force_A": 0.05, "force_B": 0.05}

SURFACE = rom.FrictionalContact(
    mu=0.4, preload=1.0, tangential_stiffness=20.0, normal_stiffness=30.0, tangents=2
)
LAWS = {
    "Jenkins": rom.Jenkins(limit=(0.4, 0.2, 0.01, 0.02), stiffness=(20.0, 20.0, 10.0, 10.0)),
    "mixed": rom.Contacts(
        [(SURFACE, (0, 2, 1)), (rom.Iwan(0.05, 8.0, -0.5, 0.5, sliders=6), (3,))]
    ),
    "with a gap": rom.Contacts(
        [
            (rom.FrictionalContact(0.3, 0.0, 20.0, 30.0, gap=0.002), (0, 1)),
            (rom.Sliders((0.02, 0.03), (5.0, 5.0)), (2, 3)),
        ]
    ),
}


def beam():
    """Stiffness and mass of the planar cantilever: u, v, rotation of each free node."""
    return matrices(ELEMENTS)[::-1]


def cantilever(law):
    """With a contact that is inclined, its third DOF a rotation, and one DOF elsewhere."""
    K, M = beam()
    W, node, angle = np.zeros((len(K), 4)), 12, np.radians(35.0)
    W[node : node + 2, 0] = np.cos(angle), np.sin(angle)
    W[node : node + 2, 1] = -np.sin(angle), np.cos(angle)
    W[node + 2, 2] = 0.1
    W[7, 3] = 1.0
    squares, modes = eigh(K + W @ np.diag(law.elements(4).reference) @ W.T, M)
    damping = M @ modes @ np.diag(0.008 * np.sqrt(squares)) @ modes.T @ M
    return rom.Structure(M, K, 0.5 * (damping + damping.T), contact=W)


@cache
def model(name, modes=(0, 1), tolerance=0.1):
    """Of the law with this name."""
    law = LAWS[name]
    patterns = FORCE_PATTERNS[: len(modes)]
    reduced = rom.reduce(cantilever(law), modes, law=law, force_patterns=patterns)
    return rom.tabulate(
        reduced, law, (0.03, 0.02)[: len(modes)], tolerance, combinations=(), harmonics=5
    )
