"""Mass and stiffness of the bodies of a deck, tied and bolted as it says, by scikit-fem."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from abaqus_deck import Deck
from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
from skfem.helpers import ddot, dot, sym_grad, trace

from slipmode import rom

HOURGLASS = 0.01  # share of full integration, which keeps elements with one point from collapsing

_TIED = 2e-3  # how far tied surfaces may be apart [m]
_ROUNDING = 1e-13
_ONE_POINT = np.full((3, 1), 0.5), np.ones(1)
_SKFEM = [0, 4, 3, 1, 7, 5, 2, 6]  # corners in its order


@dataclass
class Bodies:
    """Matrices of the DOFs that are left, n of them.

    Attributes
    ----------
    mass, stiffness : (n, n) sparse matrix
    load : (n,) ndarray
        The loads of the deck.
    dofs : (nodes, 3) ndarray of int
        -1 where a node follows others, or is in no cell.
    labels : rom.Labels
        Nodes by their numbers in the deck.
    motion : (3 nodes, n) sparse matrix
        x, y, z of every node, by the DOFs that are left.
    """

    mass: scipy.sparse.csc_array
    stiffness: scipy.sparse.csc_array
    load: np.ndarray
    dofs: np.ndarray
    labels: rom.Labels
    motion: scipy.sparse.csr_array


def bodies(deck: Deck) -> Bodies:
    """The bodies of a deck, joined."""
    motion, kept = joined(deck)
    M, K = (_symmetric(motion.T @ matrix @ motion) for matrix in cells(deck))
    load = np.zeros(motion.shape[0])
    for node, direction, force in deck.loads:
        load += force * _motion(deck, node)[direction - 1]
    dofs = np.full(deck.coordinates.shape, -1)
    dofs.ravel()[kept] = np.arange(kept.size)
    labels = rom.Labels(deck.number[kept // 3], kept % 3 + 1)
    return Bodies(M, K, motion.T @ load, dofs, labels, motion)


def _symmetric(matrix: scipy.sparse.csr_array) -> scipy.sparse.csc_array:
    return (0.5 * (matrix + matrix.T)).tocsc()


@BilinearForm
def elasticity(u, v, w):
    """Virtual work of the stresses."""
    strain, virtual = sym_grad(u), sym_grad(v)
    return w.lame * trace(strain) * trace(virtual) + 2.0 * w.shear * ddot(strain, virtual)


@BilinearForm
def inertia(u, v, w):
    """Virtual work of the accelerations."""
    return w.density * dot(u, v)


def cells(deck: Deck) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
    """Mass and stiffness (3 nodes, 3 nodes) before anything is joined.

    Elements with one integration point, as Abaqus' C3D8R: full integration is stiffer in bending.
    """
    lame = deck.young * deck.poisson / (1 + deck.poisson) / (1 - 2 * deck.poisson)
    shear = deck.young / 2 / (1 + deck.poisson)
    used, place = np.unique(deck.cells, return_inverse=True)
    corners = place.reshape(deck.cells.shape).T[_SKFEM]
    mesh = MeshHex(deck.coordinates[used].T.copy(), corners.copy())
    element = ElementVector(ElementHex1())
    full = Basis(mesh, element, intorder=2)
    one_point = Basis(mesh, element, quadrature=_ONE_POINT)
    K = HOURGLASS * elasticity.assemble(full, lame=lame, shear=shear)
    K = K + (1 - HOURGLASS) * elasticity.assemble(one_point, lame=lame, shear=shear)
    M = inertia.assemble(full, density=deck.density)
    dofs = (3 * used[:, np.newaxis] + np.arange(3)).ravel()
    n = 3 * len(deck.coordinates)
    place = scipy.sparse.csr_array(
        (np.ones(dofs.size), (dofs, np.arange(dofs.size))), (n, dofs.size)
    )
    return place @ M @ place.T, place @ K @ place.T


def joined(deck: Deck) -> tuple[scipy.sparse.csr_array, np.ndarray]:
    """T (3 nodes, kept) of x = T x_kept, which fulfils what joins the bodies; the DOFs kept.

    Nodes of tied surfaces follow the facets that they stand on. Each equation between reference
    nodes is one between the surfaces that these are the mean motion of.
    """
    n = 3 * deck.coordinates.shape[0]
    C, follower = _ties(deck, n)
    if deck.equations:
        equations = np.array(
            [sum(f * _motion(deck, node)[k - 1] for node, k, f in each) for each in deck.equations]
        )
        free = np.setdiff1d(np.flatnonzero(np.abs(equations).max(axis=0)), follower)
        pivots = scipy.linalg.qr(equations[:, free], mode="r", pivoting=True)[1]
        follower = np.concatenate((follower, free[pivots[: len(equations)]]))
        C = scipy.sparse.vstack((C, scipy.sparse.csc_array(equations))).tocsc()
    in_cells = np.isin(np.arange(n) // 3, deck.cells)
    kept = np.setdiff1d(np.flatnonzero(in_cells), follower)
    others = scipy.sparse.linalg.splu(C[:, follower].tocsc())
    moving = np.flatnonzero(np.diff(C[:, kept].indptr))
    answer = scipy.sparse.coo_array(-others.solve(C[:, kept[moving]].toarray()))
    large = np.abs(answer.data) > _ROUNDING
    rows, columns, values = (each[large] for each in (answer.row, answer.col, answer.data))
    row = np.concatenate((kept, follower[rows]))
    column = np.concatenate((np.arange(kept.size), moving[columns]))
    value = np.concatenate((np.ones(kept.size), values))
    return scipy.sparse.csr_array((value, (row, column)), (n, kept.size)), kept


def _ties(deck: Deck, n: int) -> tuple[scipy.sparse.csc_array, np.ndarray]:
    """C (followers, n) with C x = 0, and the DOFs that follow; a node follows one surface."""
    dofs = np.arange(n).reshape(-1, 3)
    rows, followers = [], []
    for slave, master in deck.ties:
        pairs = rom.contact_pairs(
            deck.coordinates, dofs, deck.surfaces[slave], deck.surfaces[master], tolerance=_TIED
        )
        own = dofs[np.concatenate(pairs.nodes)].ravel()
        new = ~np.isin(own, followers)
        rows.append(pairs.relative.T[new])
        followers += own[new].tolist()
    if not rows:
        return scipy.sparse.csc_array((0, n)), np.empty(0, int)
    return scipy.sparse.vstack(rows).tocsc(), np.array(followers)


def _motion(deck: Deck, node: int) -> np.ndarray:
    """Translation and rotation (6, 3 nodes) of a node, by the rigid motion that fits best."""
    found = np.zeros((6, 3 * len(deck.coordinates)))
    if node not in deck.couplings:
        found[[0, 1, 2], 3 * node + np.arange(3)] = 1.0
        return found
    nodes = np.unique(deck.surfaces[deck.couplings[node]])
    arm = deck.coordinates[nodes] - deck.coordinates[nodes].mean(axis=0)
    inertia = (arm**2).sum() * np.eye(3) - arm.T @ arm
    moment = np.cross(arm[:, np.newaxis], np.eye(3)).reshape(-1, 3)  # arm x displacement
    rotation = np.linalg.solve(inertia, moment.T)
    to_node = deck.coordinates[node] - deck.coordinates[nodes].mean(axis=0)
    mean = np.tile(np.eye(3) / len(nodes), len(nodes))
    translation = mean + np.cross(rotation, to_node, axis=0)
    found[:, (3 * nodes[:, np.newaxis] + np.arange(3)).ravel()] = [*translation, *rotation]
    return found
