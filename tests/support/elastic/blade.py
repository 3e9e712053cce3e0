"""A rectangular blade of four-node elements: plane stress, unit thickness and density."""

import numpy as np


def blade(nx, ny, lx=1.0, ly=0.2, E=1.0, nu=0.3):
    """Return mass and stiffness of a grid of elements, two displacements a node."""
    hx, hy = lx / nx, ly / ny
    D = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    k_e, m_e = np.zeros((2, 8, 8))
    g = 1.0 / np.sqrt(3.0)
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for point in (np.array([xi, eta]) for xi in (-g, g) for eta in (-g, g)):
        along = 1 + corner * point
        N = 0.25 * along.prod(axis=1)
        dx, dy = (0.5 * corner * along[:, ::-1] / (hx, hy)).T
        B = np.zeros((3, 8))
        B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = dx, dy, dy, dx
        k_e += B.T @ D @ B * hx * hy / 4.0
        m_e += np.kron(np.outer(N, N), np.eye(2)) * hx * hy / 4.0
    K, M = np.zeros((2, 2 * (nx + 1) * (ny + 1), 2 * (nx + 1) * (ny + 1)))
    for i in range(nx):
        for j in range(ny):
            first = i * (ny + 1) + j
            nodes = np.array([first, first + ny + 1, first + ny + 2, first + 1])
            dofs = (2 * nodes[:, np.newaxis] + [0, 1]).ravel()
            K[np.ix_(dofs, dofs)] += k_e
            M[np.ix_(dofs, dofs)] += m_e
    return M, K
