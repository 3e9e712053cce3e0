"""Sectors of a mesh, against the mesh of the whole disk."""

import sys

import numpy as np
import pytest
import scipy.linalg

from benchmarks.cyclic.sector import sector
from slipmode import rom
from slipmode.rom.cyclic.static_response import StaticResponse
from slipmode.rom.structure.solvers.factorisation import SMALL

SECTORS = 5


@pytest.fixture(scope="module")
def solid():
    return sector(SECTORS, 5, 4, 1)


def cyclic(solid, next_contact=None, contact=None):
    first = solid.mesh.dofs[solid.right_face[0], 2]
    structure = rom.Structure(
        solid.mass, solid.stiffness, 1e-6, contact=[int(first)] if contact is None else contact
    )
    return solid.mesh.cyclic(structure, SECTORS, next_contact)


def whole_disk(solid):
    """Return stiffness, mass (dense) and the places of the whole disk's DOFs, from the meshes of
    its sectors, turned and joined by the positions of their nodes, all in x, y, z."""
    rotations, found, keys = [], {}, []
    for j in range(SECTORS):
        angle = 2.0 * np.pi * j / SECTORS
        R = np.array(
            [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]]
        )
        rotations.append(R)
        for point in solid.mesh.coordinates @ R.T:
            keys.append(found.setdefault(tuple(np.round(point, 6) + 0.0), len(found)))
    keys = np.array(keys).reshape(SECTORS, -1)
    K, M = (np.zeros((3 * len(found), 3 * len(found))) for _ in range(2))
    dofs = solid.mesh.dofs
    nodes, directions = np.nonzero(dofs >= 0)
    order = np.argsort(dofs[nodes, directions])
    nodes, directions = nodes[order], directions[order]
    for j, R in enumerate(rotations):
        turn = np.zeros((nodes.size, 3 * len(found)))
        for k in range(3):
            # displacement of the sector's own directions, by those of the whole disk
            turn[np.arange(nodes.size), 3 * keys[j][nodes] + k] += R[k, directions]
        K += turn.T @ solid.stiffness @ turn
        M += turn.T @ solid.mass @ turn
    held = np.diag(M) == 0.0
    return K[~held][:, ~held], M[~held][:, ~held]


def test_the_sectors_have_the_frequencies_of_the_whole_disk(solid):
    K, M = whole_disk(solid)
    together = scipy.linalg.eigh(K, M, eigvals_only=True)
    disk = cyclic(solid)
    squares = []
    for k in range(SECTORS):
        mass, _, stiffness = (each.toarray() for each in disk.of_diameter(k))
        squares.append(scipy.linalg.eigh(stiffness, mass, eigvals_only=True))
    np.testing.assert_allclose(np.sort(np.concatenate(squares)), together, rtol=1e-8)


@pytest.mark.parametrize("solver", ["pypardiso", "SuperLU"])
def test_the_interior_is_eliminated_by_either_solver(solver, monkeypatch):
    """Displacements of about 1 are within 3e-11."""
    if solver == "SuperLU":
        monkeypatch.setitem(sys.modules, "pypardiso", None)
    else:
        pytest.importorskip("pypardiso")
    solid, k = sector(SECTORS, 8, 6, 4), 2
    disk, springs = cyclic(solid), np.array([1e7])
    eliminated = disk.mass.shape[0] - disk.condensed.boundary.size
    assert eliminated > SMALL
    static = StaticResponse(disk, k, springs)
    W = disk.contact_motion(k)
    K = disk.of_diameter(k)[2] + W.conj().T @ (springs * W)
    exact = np.random.default_rng(1).standard_normal((K.shape[0], 2, 2)) @ [1.0, 1.0j]
    np.testing.assert_allclose(static(K @ exact), exact, atol=1e-9)


def test_a_rotation_of_the_disk_moves_no_contacts_between_neighbours(solid):
    """Nor does any other motion of the whole disk as a rigid body: of nodal diameters 0 and 1."""
    points, dofs = solid.mesh.with_next(SECTORS)
    size = solid.mass.shape[0]
    following = solid.left_face + len(solid.mesh.coordinates)
    # nodes of neighbours do not coincide: displacements along the line that joins them
    along = points[following] - points[solid.right_face]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    W = np.zeros((2 * size, along.shape[0]))
    for column, (own, other) in enumerate(zip(solid.right_face, following, strict=True)):
        W[dofs[own], column] = along[column]
        W[dofs[other], column] = -along[column]
    disk = cyclic(solid, W[size:], W[:size])
    x, y, _ = solid.mesh.coordinates.T
    motions = {
        0: [
            np.array([-y, x, 0.0 * x]).T,
            np.array([0.0, 0.0, 1.0]) + 0.0 * solid.mesh.coordinates,
        ],
        1: [np.array([1.0, 1.0j, 0.0]) + 0.0 * solid.mesh.coordinates],
    }
    for k, shapes in motions.items():
        for shape in shapes:
            u = np.zeros(size, dtype=complex)
            u[dofs[: len(x)][dofs[: len(x)] >= 0]] = shape[dofs[: len(x)] >= 0]
            moved = disk.contact_motion(k) @ u[disk.free_dofs]
            np.testing.assert_allclose(moved, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"axis": "x"}, "turned by one sector about x, is .* m away"),
        ({"left": "right", "right": "left"}, "check sectors, axis, and whether left and right"),
        ({"axis": "r"}, "axis: must be one of x, y, z"),
        ({"left": [0]}, "left, right: must be as many nodes"),
        ({"left": [], "right": []}, "at least one, got 0 and 0"),
        ({"right": [-1]}, "right: nodes must be 0 to"),
        ({"dofs": "half"}, "dofs: must be integers of shape"),
    ],
)
def test_sectors_that_do_not_meet_are_refused(solid, changed, message):
    mesh = solid.mesh
    given = {name: getattr(mesh, name) for name in ("coordinates", "dofs", "left", "right")}
    given |= {
        key: given.get(value, value) if isinstance(value, str) else value
        for key, value in changed.items()
    }
    if changed.get("dofs") == "half":
        given["dofs"] = 0.5 * mesh.dofs
    structure = rom.Structure(solid.mass, solid.stiffness, contact=[0])
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.SectorMesh(**given).cyclic(structure, SECTORS)


def test_nodes_that_are_not_held_alike_are_refused(solid):
    dofs = solid.mesh.dofs.copy()
    taken = dofs[solid.mesh.right[0], 0]
    dofs[dofs == taken] = -1
    dofs[dofs > taken] -= 1
    kept = np.delete(np.arange(solid.mass.shape[0]), taken)
    structure = rom.Structure(
        solid.mass[kept][:, kept], solid.stiffness[kept][:, kept], contact=[0]
    )
    mesh = rom.SectorMesh(solid.mesh.coordinates, dofs, solid.mesh.left, solid.mesh.right)
    with pytest.raises(rom.SlipmodeError, match="meet, but have different free DOFs"):
        mesh.cyclic(structure, SECTORS)
