"""A family of structures that nobody chose: beams, plates and meshed blades with elastic contacts.

Each seed draws a body, its contacts, their stiffness against the body, friction, modes and forces.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from elastic.frictional_beam import matrices

from slipmode import rom

KEPT = 14  # modes of each body beside the static response to its contacts


@dataclass(frozen=True)
class Member:
    """One structure, forced near its modes."""

    name: str
    structure: rom.Structure
    law: rom.Jenkins | rom.FrictionalContact
    modes: tuple[int, ...]
    force: tuple[np.ndarray, ...]
    frequency: tuple[float, ...]
    scale: tuple[float, ...]  # amplitudes that the forces would make in the stuck structure


def _quadrilateral(stiffness_of, mass_of, nx, ny, lx, ly, per_node):
    """Matrices of a grid of equal four-node elements, each given over shape functions."""
    hx, hy = lx / nx, ly / ny
    size = per_node * (nx + 1) * (ny + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    k_e = np.zeros((4 * per_node, 4 * per_node))
    m_e = np.zeros_like(k_e)
    g = 1.0 / np.sqrt(3.0)
    for xi in (-g, g):
        for eta in (-g, g):
            N = 0.25 * np.array(
                [
                    (1 - xi) * (1 - eta),
                    (1 + xi) * (1 - eta),
                    (1 + xi) * (1 + eta),
                    (1 - xi) * (1 + eta),
                ]
            )
            dx = 0.5 / hx * np.array([-(1 - eta), 1 - eta, 1 + eta, -(1 + eta)])
            dy = 0.5 / hy * np.array([-(1 - xi), -(1 + xi), 1 + xi, 1 - xi])
            k_e += stiffness_of(N, dx, dy) * hx * hy / 4.0
            m_e += mass_of(N) * hx * hy / 4.0
    for i in range(nx):
        for j in range(ny):
            nodes = [i * (ny + 1) + j, (i + 1) * (ny + 1) + j]
            nodes = [nodes[0], nodes[1], nodes[1] + 1, nodes[0] + 1]
            dofs = np.concatenate([per_node * n + np.arange(per_node) for n in nodes])
            K[np.ix_(dofs, dofs)] += k_e
            M[np.ix_(dofs, dofs)] += m_e
    return M, K


def blade(nx, ny, lx=1.0, ly=0.2, E=1.0, nu=0.3):
    """Plane stress, unit thickness and density: two displacements a node."""
    D = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])

    def stiffness(N, dx, dy):
        B = np.zeros((3, 8))
        B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = dx, dy, dy, dx
        return B.T @ D @ B

    def mass(N):
        return np.kron(np.outer(N, N), np.eye(2))

    return _quadrilateral(stiffness, mass, nx, ny, lx, ly, 2)


def plate(nx, ny, lx=1.0, ly=0.6, thickness=0.05, nu=0.3):
    """Mindlin plate: deflection, two rotations a node; shear softened against locking."""
    bending = (
        thickness**3 / 12 / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    )
    size = max(lx / nx, ly / ny)
    shear = 5 / 6 * thickness / 2 / (1 + nu) / (1 + (size / thickness) ** 2)

    def stiffness(N, dx, dy):
        B, S = np.zeros((3, 12)), np.zeros((2, 12))
        B[0, 1::3], B[1, 2::3], B[2, 1::3], B[2, 2::3] = dx, dy, dy, dx
        S[0, 0::3], S[0, 1::3], S[1, 0::3], S[1, 2::3] = dx, -N, dy, -N
        return B.T @ bending @ B + shear * S.T @ S

    def mass(N):
        return np.kron(np.outer(N, N), np.diag([thickness, thickness**3 / 12, thickness**3 / 12]))

    return _quadrilateral(stiffness, mass, nx, ny, lx, ly, 3)


def _body(rng):
    """Name, mass, stiffness, and for each node its DOFs that contacts may have."""
    kind = rng.choice(["beam", "free beam", "blade", "plate", "free plate"])
    if kind == "beam":
        M, K = matrices()
        return kind, M, K, [[3 * n, 3 * n + 1] for n in range(12)]
    if kind == "free beam":
        M, K = matrices(clamped=False)
        return kind, M, K, [[3 * n, 3 * n + 1] for n in range(13)]
    nx, ny = int(rng.integers(8, 20)), int(rng.integers(3, 6))
    per_node = 2 if kind == "blade" else 3
    M, K = blade(nx, ny) if kind == "blade" else plate(nx, ny)
    nodes = np.arange((nx + 1) * (ny + 1))
    if not kind.startswith("free"):
        kept = np.arange(per_node * (ny + 1), len(M))
        M, K = M[np.ix_(kept, kept)], K[np.ix_(kept, kept)]
        nodes = nodes[: -(ny + 1)]
    directions = [0, 1] if kind == "blade" else [0]
    return kind, M, K, [[per_node * n + d for d in directions] for n in nodes]


def _projected(M, K, W, force_rows, reference):
    """The body on its lowest stuck modes and what static forces at the contacts do."""
    stuck = K + (W * reference) @ W.T
    _, shapes = scipy.linalg.eigh(stuck, M, subset_by_index=(0, KEPT - 1))
    held = stuck + 1e-9 * np.trace(stuck) / np.trace(M) * M
    static = np.linalg.solve(held, W)
    static -= shapes @ (shapes.T @ M @ static)
    gram = static.T @ M @ static
    values, vectors = np.linalg.eigh(gram)
    good = values > 1e-10 * values.max()
    T = np.hstack((shapes, static @ vectors[:, good] / np.sqrt(values[good])))
    return T, T.T @ M @ T, T.T @ K @ T, T.T @ W, T.T @ force_rows


def _separated(omega, shapes, W, f):
    """Modes that the force moves, that touch the contacts, and that are 10 % from all others."""
    squares = omega**2
    lowest = 1e-6 * squares.max() / 1e3
    found = []
    for j in np.flatnonzero(squares > lowest)[:8]:
        apart = np.abs(np.delete(omega, j) / omega[j] - 1.0).min()
        touches = np.abs(W.T @ shapes[:, j]).max() > 1e-3 * np.abs(W.T @ shapes[:, :8]).max()
        moved = abs(shapes[:, j] @ f[:, 0]) > 0.05 * np.abs(shapes[:, :8].T @ f[:, 0]).max()
        if apart > 0.1 and touches and moved:
            found.append(j)
    return np.array(found)


def member(seed: int) -> Member:
    """The member of a seed: of what it draws, the first whose modes are well separated."""
    rng = np.random.default_rng(seed)
    while True:
        drawn = _drawn(seed, rng)
        if drawn is not None:
            return drawn


def _drawn(seed: int, rng: np.random.Generator) -> Member | None:
    kind, M, K, nodes = _body(rng)
    frictional = bool(rng.random() < 0.5) and len(nodes[0]) == 2
    most = 30 if not frictional else 15
    count = min(int(np.round(np.exp(rng.uniform(0, np.log(most))))), len(nodes))
    chosen = rng.choice(len(nodes), count, replace=False)
    columns = []
    for node in sorted(chosen):
        angle = rng.uniform(0, 2 * np.pi)
        dofs = nodes[node]
        axes = np.zeros((2, len(M)))
        if len(dofs) == 2:
            axes[0, dofs] = np.cos(angle), np.sin(angle)
            axes[1, dofs] = -np.sin(angle), np.cos(angle)
        else:
            axes[0, dofs] = 1.0
        columns += list(axes[: 2 if frictional else 1])
    W = np.array(columns).T
    held = K + 1e-3 * np.sort(scipy.linalg.eigh(K, M, eigvals_only=True))[4] * M
    local = 1.0 / np.einsum("nc,nc->c", W, np.linalg.solve(held, W))
    ratio = np.exp(rng.uniform(np.log(0.01), np.log(100.0)))
    stiffness = ratio * np.median(local)
    reference = np.full(W.shape[1], stiffness)
    force_dof = nodes[rng.integers(len(nodes))][-1]
    row = np.zeros((len(M), 1))
    row[force_dof] = 1.0
    _, M, K, W, f = _projected(M, K, W, row, reference)
    squares, shapes = scipy.linalg.eigh(K + (W * reference) @ W.T, M)
    omega = np.sqrt(np.maximum(squares, 0.0))
    zeta = np.exp(rng.uniform(np.log(1e-3), np.log(1e-2)))
    C = M @ (shapes * (2 * zeta * omega)) @ shapes.T @ M
    structure = rom.Structure(M, K, 0.5 * (C + C.T), contact=W)
    two = bool(rng.random() < 0.5)
    candidates = _separated(omega, shapes, W, f)
    if candidates.size < 1 + two:
        return None
    modes = tuple(sorted(int(m) for m in rng.choice(candidates[:4], 1 + two, replace=False)))
    detuned = rng.uniform(-0.02, 0.01, size=2)
    frequency = tuple(float(omega[m] * (1 + d)) for m, d in zip(modes, detuned, strict=False))
    work = shapes.T @ f[:, 0]
    forces, scale = [], []
    for mode, Omega in zip(modes, frequency, strict=True):
        # a force that makes the mode's largest contact displacement about 1 where all sticks
        moved = np.abs(W.T @ shapes[:, mode]).max()
        wanted = 1.0 / moved * np.exp(rng.uniform(np.log(0.3), 0.0))
        stiff = abs(omega[mode] ** 2 - Omega**2 + 2j * zeta * omega[mode] * Omega)
        forces.append(2 * wanted * stiff / work[mode] * f[:, 0])
        scale.append(float(wanted))
    share = np.exp(rng.uniform(np.log(0.15), np.log(3.0)))
    hold = share * stiffness  # limit against the elastic force there
    if frictional:
        mu = float(rng.uniform(0.2, 0.6))
        law = rom.FrictionalContact(
            mu, hold / mu * 0.5, stiffness, stiffness * rng.uniform(0.5, 2)
        )
    else:
        law = rom.Jenkins(hold, stiffness)
    name = f"{seed}: {kind}, {count} {'frictional' if frictional else 'Jenkins'}, k {ratio:.2g}, "
    name += f"hold {share:.2g}, zeta {zeta:.2g}, modes {modes}"
    return Member(name, structure, law, modes, tuple(forces), frequency, tuple(scale))
