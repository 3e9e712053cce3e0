"""Mass and stiffness of the bodies of a deck, tied and bolted as it says, by scikit-fem."""

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from abaqus_deck import Deck
from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
from skfem.helpers import ddot, dot, sym_grad, trace

from slipmode import rom

HOURGLASS = 0.02  # share of full integration, which keeps elements with one point from collapsing
_TIED = 2e-3  # how far tied surfaces may be apart [m]

_SKFEM = [0, 4, 3, 1, 7, 5, 2, 6]  # corners in its order


@BilinearForm
def elasticity(u, v, w):
    """Virtual work of the stresses."""
    strain, virtual = sym_grad(u), sym_grad(v)
    return w.lame * trace(strain) * trace(virtual) + 2.0 * w.shear * ddot(strain, virtual)


@BilinearForm
def inertia(u, v, w):
    """Virtual work of the accelerations."""
    return w.density * dot(u, v)


def bodies(deck: Deck) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
    """Mass and stiffness (3 nodes, 3 nodes) before anything is joined.

    Elements with one integration point, as Abaqus' C3D8R: full integration is too stiff in bending.
    """
    lame = deck.young * deck.poisson / (1 + deck.poisson) / (1 - 2 * deck.poisson)
    shear = deck.young / 2 / (1 + deck.poisson)
    used = deck.cells.max() + 1
    mesh = MeshHex(deck.coordinates[:used].T.copy(), deck.cells.T[_SKFEM].copy())
    element = ElementVector(ElementHex1())
    full, reduced = Basis(mesh, element, intorder=3), Basis(mesh, element, intorder=1)
    K = HOURGLASS * elasticity.assemble(full, lame=lame, shear=shear)
    K = K + (1 - HOURGLASS) * elasticity.assemble(reduced, lame=lame, shear=shear)
    M = inertia.assemble(full, density=deck.density)
    return M, K


def joined(deck: Deck) -> tuple[scipy.sparse.csr_array, np.ndarray]:
    """T (3 nodes, kept) of x = T x_kept, which fulfils what joins the bodies; the DOFs kept.

    Nodes of tied surfaces follow the facets that they stand on. Each equation between reference
    nodes is one between the surfaces that these are the mean motion of.
    """
    n = 3 * deck.coordinates.shape[0]
    C, follower = _ties(deck, n)
    if deck.equations:
        motion = {node: _mean_motion(deck, node) for node in deck.couplings}
        equations = np.array(
            [sum(f * motion[node][k - 1] for node, k, f in each) for each in deck.equations]
        )
        free = np.flatnonzero(np.abs(equations).max(axis=0))
        free = np.setdiff1d(free, follower)
        pivots = scipy.linalg.qr(equations[:, free], mode="r", pivoting=True)[1]
        follower = np.concatenate((follower, free[pivots[: len(equations)]]))
        C = scipy.sparse.vstack((C, scipy.sparse.csc_array(equations))).tocsc()
    in_cells = np.repeat(np.isin(np.arange(n // 3), deck.cells), 3)
    kept = np.setdiff1d(np.flatnonzero(in_cells), follower)
    others = scipy.sparse.linalg.splu(C[:, follower].tocsc())
    moving = np.flatnonzero(np.diff(C[:, kept].indptr))
    answer = scipy.sparse.coo_array(-others.solve(C[:, kept[moving]].toarray()))
    small = np.abs(answer.data) < 1e-13
    rows, columns, values = (each[~small] for each in (answer.row, answer.col, answer.data))
    T = scipy.sparse.coo_array(
        (
            np.concatenate((np.ones(kept.size), values)),
            (
                np.concatenate((kept, follower[rows])),
                np.concatenate((np.arange(kept.size), moving[columns])),
            ),
        ),
        (n, kept.size),
    )
    return T.tocsr(), kept


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


def _mean_motion(deck: Deck, node: int) -> np.ndarray:
    """Translation and rotation (6, 3 nodes) of a reference node: the best rigid motion."""
    nodes = np.unique(deck.surfaces[deck.couplings[node]])
    x = deck.coordinates[nodes]
    arm = x - x.mean(axis=0)
    inertia = (arm**2).sum() * np.eye(3) - arm.T @ arm
    cross = np.cross(np.eye(3), arm[:, np.newaxis])  # [node, direction] -> arm x e, negated
    rotation = np.linalg.solve(inertia, -cross.reshape(-1, 3).T)
    to_node = deck.coordinates[node] - x.mean(axis=0)
    translation = np.tile(np.eye(3) / len(nodes), len(nodes)) + np.cross(
        rotation, to_node, axis=0
    )
    found = np.zeros((6, 3 * len(deck.coordinates)))
    found[:, (3 * nodes[:, np.newaxis] + np.arange(3)).ravel()] = np.vstack(
        (translation, rotation)
    )
    return found
