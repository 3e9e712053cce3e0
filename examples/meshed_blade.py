"""The matrices of the shipped scene "blade": a blade with a platform, meshed, and its dampers.

Plane stress, biquadratic elements of order 2 with Gauss-Lobatto mass (diagonal). The blade stands
on a clamped root; a friction damper presses at 45 degrees under each end of its platform.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.sparse

from slipmode import rom

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0  # steel [Pa], [-], [kg/m^3]
DEPTH = 0.03  # out of the plane [m]
X = np.array([-35.0, -20.0, -6.0, 0.0, 6.0, 20.0, 35.0]) * 1e-3  # ends of cells across [m]
Y = np.array([0, 10, 20, 30, 40, 50, 60, 70, 80, 92, 104, 116, 132, 148, 164, 180]) * 1e-3
STEM = 6e-3  # half its width [m]
PLATFORM = (0.04, 0.05)  # y of the one row of cells that spans all of X
DAMPING = 2e-6  # beta [s]

_POINT = np.array([-1.0, 0.0, 1.0])  # nodes of an element along each direction
_LOBATTO = np.array([1.0, 4.0, 1.0]) / 3.0
_GAUSS, _WEIGHT = np.polynomial.legendre.leggauss(3)


def lagrange(s: float) -> tuple[np.ndarray, np.ndarray]:
    """The three quadratic shape functions at s, and their slopes."""
    value = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
    return value, np.array([s - 0.5, -2.0 * s, s + 0.5])


def element(width: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (18, 18) and diagonal mass (18,) of a rectangle, DOFs u, v node by node."""
    elasticity = (
        YOUNG
        / (1.0 - POISSON**2)
        * np.array([[1.0, POISSON, 0.0], [POISSON, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - POISSON)]])
    )
    stiffness, area = np.zeros((18, 18)), 0.25 * width * height * DEPTH
    for a, weight_a in zip(_GAUSS, _WEIGHT, strict=True):
        for b, weight_b in zip(_GAUSS, _WEIGHT, strict=True):
            (f, df), (g, dg) = lagrange(a), lagrange(b)
            by_x = np.outer(df, g).ravel() * 2.0 / width
            by_y = np.outer(f, dg).ravel() * 2.0 / height
            strain = np.zeros((3, 18))
            strain[0, 0::2], strain[1, 1::2] = by_x, by_y
            strain[2, 0::2], strain[2, 1::2] = by_y, by_x
            stiffness += weight_a * weight_b * area * strain.T @ elasticity @ strain
    mass = DENSITY * area * np.repeat(np.outer(_LOBATTO, _LOBATTO).ravel(), 2)
    return stiffness, mass


def blade() -> rom.Structure:
    """The structure, clamped at y = 0; contact DOFs: tangent, normal of each damper.

    DOF 202, which the scene forces, is the horizontal one of the tip's middle.
    """
    nodes: dict[tuple[float, float], int] = {}
    rows, columns, values, masses = [], [], [], []
    for left, right in pairwise(X):
        for low, high in pairwise(Y):
            if max(-left, right) > STEM and (low, high) != PLATFORM:
                continue
            at = [
                (0.5 * (left + right) + 0.5 * (right - left) * s,
                 0.5 * (low + high) + 0.5 * (high - low) * t)
                for s in _POINT for t in _POINT
            ]  # fmt: skip
            number = [nodes.setdefault((round(x, 9), round(y, 9)), len(nodes)) for x, y in at]
            dofs = np.array([2 * k + d for k in number for d in (0, 1)])
            stiffness, mass = element(right - left, high - low)
            rows.append(np.repeat(dofs, 18))
            columns.append(np.tile(dofs, 18))
            values.append(stiffness.ravel())
            masses.append((dofs, mass))
    size = 2 * len(nodes)
    K = scipy.sparse.coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size)
    ).tocsr()
    M = np.zeros(size)
    for dofs, mass in masses:
        np.add.at(M, dofs, mass)
    free = np.array([2 * k + d for (_, y), k in nodes.items() if y > 0.0 for d in (0, 1)])
    place = {int(dof): k for k, dof in enumerate(free)}
    W = np.zeros((free.size, 4))
    slope = np.sqrt(0.5)
    for contact, (x, side) in enumerate(((X[0], -1.0), (X[-1], 1.0))):
        node = nodes[round(x, 9), round(PLATFORM[0], 9)]
        u, v = place[2 * node], place[2 * node + 1]
        W[[u, v], 2 * contact] = -side * slope, slope  # along the damper's face
        W[[u, v], 2 * contact + 1] = -side * slope, -slope  # onto it
    K = K[free][:, free]
    K = 0.5 * (K + K.T)
    return rom.Structure(scipy.sparse.diags_array(M[free]), K, DAMPING, contact=W)


if __name__ == "__main__":
    folder = (
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "runner/scenes"
    )
    structure = blade()
    structure.save(folder / "blade.npz")
    print(structure, (folder / "blade.npz").stat().st_size)
