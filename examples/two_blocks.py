"""A steel block pressed on another, meshes that do not match: friction damps its first mode.

The lower block is held at its base, the faces meet in four patches. Under pressure on its top, the
upper block is shaken sideways, somewhat below the frequency that it has while all patches stick.
"""

import numpy as np
import scipy.sparse

from slipmode import rom

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0  # steel [Pa], [-], [kg/m^3]
DAMPING = 1e-6  # beta [s]
MU, TANGENTIAL, NORMAL = 0.3, 2e12, 1e13  # friction; stiffness per area [N/m^3]
PRESSURE = 5e7  # on top [Pa]
BELOW = 0.95  # of the frequency of the mode

_CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
)  # fmt: skip


def block(
    cells: tuple[int, int, int], size: tuple[float, float, float], bottom: float
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and hexahedra (cells, 8) of a block."""
    x, y, z = (np.linspace(0.0, s, n + 1) for n, s in zip(cells, size, strict=True))
    nodes = np.stack(np.meshgrid(x, y, z + bottom, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape([n + 1 for n in cells])
    corners = [number[tuple(slice(1, None) if s > 0 else slice(-1) for s in c)] for c in _CORNERS]
    return nodes, np.stack(corners, axis=-1).reshape(-1, 8)


def element(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass (24, 24) of a cell with edges `size` [m], linear shape functions."""
    lame, shear = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON), YOUNG / 2 / (1 + POISSON)
    elasticity = np.diag([2 * shear] * 3 + [shear] * 3)
    elasticity[:3, :3] += lame
    stiffness, mass = np.zeros((24, 24)), np.zeros((24, 24))
    for point in _CORNERS / np.sqrt(3.0):
        factors = 1.0 + _CORNERS * point
        N = factors.prod(axis=1) / 8.0
        dx, dy, dz = (_CORNERS * N[:, np.newaxis] / factors * 2.0 / size).T
        strain = np.zeros((6, 24))
        for row, axis in enumerate((dx, dy, dz)):
            strain[row, row::3] = axis
        for row, (a, b) in enumerate(((0, 1), (1, 2), (2, 0))):
            strain[3 + row, a::3], strain[3 + row, b::3] = (dx, dy, dz)[b], (dx, dy, dz)[a]
        weight = size.prod() / 8.0
        stiffness += weight * strain.T @ elasticity @ strain
        mass += weight * DENSITY * np.kron(np.outer(N, N), np.eye(3))
    return stiffness, mass


def assembled(meshes: list[tuple], dofs: np.ndarray) -> list:
    """Stiffness and mass of bodies whose nodes follow each other; DOFs -1 are held."""
    n, first, found = dofs.max() + 1, 0, [[], []]
    for nodes, cells in meshes:
        size = nodes[cells[0, 6]] - nodes[cells[0, 0]]
        own = dofs[cells + first].reshape(len(cells), 24)
        rows, columns = np.repeat(own, 24, axis=1).ravel(), np.tile(own, 24).ravel()
        free = (rows >= 0) & (columns >= 0)
        for matrix, of_cell in zip(found, element(size), strict=True):
            entries = np.tile(of_cell.ravel(), len(cells))[free]
            matrix.append(scipy.sparse.coo_array((entries, (rows[free], columns[free])), (n, n)))
        first += len(nodes)
    sums = (sum(matrix).tocsc() for matrix in found)
    return [0.5 * (matrix + matrix.T) for matrix in sums]


def two_blocks() -> tuple[rom.Structure, rom.ContactPairs, np.ndarray]:
    """The structure, its contacts, and unit forces (3, n) on its top, along x, y and z."""
    lower = block((2, 2, 3), (0.04, 0.03, 0.04), bottom=0.0)
    upper = block((3, 3, 3), (0.04, 0.03, 0.02), bottom=0.04)
    nodes = np.concatenate((lower[0], upper[0]))
    free = nodes[:, 2] > 0.0
    dofs = np.full(nodes.shape, -1)
    dofs[free] = np.arange(3 * free.sum()).reshape(-1, 3)
    K, M = assembled([lower, upper], dofs)

    # cells have their lower face first, seen from outside when turned over, then their upper one
    first = len(lower[0])
    underside = first + upper[1][upper[0][upper[1][:, 0], 2] == 0.04][:, [0, 3, 2, 1]]
    ground = lower[1][lower[0][lower[1][:, 4], 2] == 0.04][:, 4:]
    pairs = rom.contact_pairs(nodes, dofs, underside, ground, tolerance=1e-4).gathered(4)
    structure = rom.Structure(M, K, DAMPING, contact=pairs.W)

    top = np.flatnonzero(np.isclose(nodes[:, 2], 0.06))
    edges = np.isclose(nodes[top, :2], [0.0, 0.0]) | np.isclose(nodes[top, :2], [0.04, 0.03])
    share = 0.5 ** edges.sum(axis=1)  # what a node has of the area of a cell
    on_top = np.zeros((3, structure.n_dofs))
    on_top[np.arange(3)[:, np.newaxis], dofs[top].T] = share / share.sum()
    return structure, pairs, on_top


def shaken(forces: list[float]) -> tuple[rom.Preload, rom.Reduced, list[rom.SteadyState]]:
    """The blocks at rest, their first mode, and its steady states under each force [N]."""
    structure, pairs, (_, sideways, up) = two_blocks()
    law = rom.FrictionalContact.on_areas(
        pairs.area, mu=MU, tangential_stiffness=TANGENTIAL, normal_stiffness=NORMAL
    )
    rest = rom.preload(structure, law, -PRESSURE * pairs.area.sum() * up)
    reduced = rom.reduce(structure, (0,), law=rest.law)
    frequency = BELOW * reduced.frequency
    states = [
        rom.steady_state(reduced, rest.law, frequency, [force * sideways], tolerance=2e-2)
        for force in forces
    ]
    return rest, reduced, states


if __name__ == "__main__":
    forces = [1000.0, 2000.0, 3000.0]
    rest, reduced, states = shaken(forces)
    print("normal forces [N]:", np.round(rest.normal_force))
    print(f"first mode: {reduced.frequency[0] / (2 * np.pi):.0f} Hz")
    for force, state in zip(forces, states, strict=True):
        print(f"{force:.0f} N: |a| / force = {abs(state.amplitude[0]) / force:.3g} kg^1/2 m/N")
