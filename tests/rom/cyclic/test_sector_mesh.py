"""Sectors of a mesh, against the mesh of the whole disk."""

import numpy as np
import pytest
import scipy.sparse

from benchmarks.cyclic.sector import sector
from slipmode import rom

SECTORS = 5


@pytest.fixture(scope="module")
def solid():
    return sector(SECTORS, 5, 4, 1)


def cyclic(solid, contact=None, next_contact=None):
    contact = [solid.mesh.dofs[solid.right_face[0], 2]] if contact is None else contact
    structure = rom.Structure(solid.mass, solid.stiffness, 1e-6, contact=contact)
    return solid.mesh.cyclic(structure, SECTORS, next_contact)


def whole_disk(solid):
    """Return stiffness and mass of the whole disk, and matrices from the motion of the whole disk
    to each sector in its own directions: meshes of sectors, turned and joined where nodes meet."""
    nodes, directions = np.nonzero(solid.mesh.dofs >= 0)
    order = np.argsort(solid.mesh.dofs[nodes, directions])
    nodes, directions = nodes[order], directions[order]
    found, turns = {}, []
    for angle in 2.0 * np.pi / SECTORS * np.arange(SECTORS):
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
        places = [tuple(np.round(x, 6) + 0.0) for x in solid.mesh.coordinates @ R.T]
        at = np.array([found.setdefault(place, len(found)) for place in places])
        rows = np.repeat(np.arange(nodes.size), 3)
        columns = (3 * at[nodes, np.newaxis] + np.arange(3)).ravel()
        turns.append((R[:, directions].T.ravel(), (rows, columns)))
    shape = nodes.size, 3 * len(found)
    turns = [scipy.sparse.csc_array(each, shape=shape) for each in turns]
    K, M = (sum(T.T @ each @ T for T in turns) for each in (solid.stiffness, solid.mass))
    free = np.flatnonzero(M.diagonal())
    return K[free][:, free], M[free][:, free], [T[:, free] for T in turns]


@pytest.mark.oracle
@pytest.mark.parametrize("k", [1, -2])
def test_stuck_waves_of_a_mesh_are_the_linear_response_of_the_whole_disk(k):
    """Also where the interior of the sector is eliminated, and most modes respond statically."""
    solid = sector(SECTORS, 8, 6, 4)
    dof, law = int(solid.mesh.dofs[solid.right_face[0], 2]), rom.Jenkins(1e9, 1e7)
    wave = rom.travelling_wave(cyclic(solid), law, k)
    omega = 0.97 * wave.frequency
    force = np.zeros(wave.shape.size, dtype=complex)
    place = int(np.flatnonzero(wave.structure.free_dofs == dof)[0])
    force[place] = 1.0
    (state,) = wave.steady_states(omega, force)
    K, M, turns = whole_disk(solid)
    points = scipy.sparse.vstack([T[[dof]] for T in turns])
    stuck = K + 1e7 * points.T @ points
    dynamic = stuck - omega**2 * M + 1j * omega * 1e-6 * K
    load = points.T @ (0.5 * np.exp(2j * np.pi * k * np.arange(SECTORS) / SECTORS))
    free = wave.structure.free_dofs
    expected, static = (
        (turns[0] @ scipy.sparse.linalg.spsolve(each.tocsc(), load))[free]
        for each in (dynamic, stuck)
    )
    # Modes from ten times the natural frequency respond statically: (1 / 10)^2 of their response.
    assert np.abs(state.displacement - expected).max() < 0.01 * np.abs(static).max()
    assert np.abs(static).max() < 0.2 * np.abs(expected).max()


@pytest.mark.oracle
def test_rigid_motions_of_the_disk_move_no_contacts_between_neighbours(solid):
    """A rotation and a shift along the axis have nodal diameter 0, a shift across it 1."""
    points, dofs = solid.mesh.with_next(SECTORS)
    size, x = solid.mass.shape[0], solid.mesh.coordinates
    following = solid.left_face + len(x)
    # nodes of neighbours do not coincide: displacements along the line that joins them
    along = points[following] - points[solid.right_face]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    W = np.zeros((2 * size, along.shape[0]))
    for column, (own, other) in enumerate(zip(solid.right_face, following, strict=True)):
        W[dofs[own], column] = along[column]
        W[dofs[other], column] = -along[column]
    disk, own = cyclic(solid, W[:size], W[size:]), dofs[: len(x)]
    rotation = np.column_stack((-x[:, 1], x[:, 0], 0.0 * x[:, 2]))
    for k, shape in (
        (0, rotation),
        (0, np.tile([0.0, 0.0, 1.0], (len(x), 1))),
        (1, np.tile([1.0, 1.0j, 0.0], (len(x), 1))),
    ):
        u = np.zeros(size, dtype=complex)
        u[own[own >= 0]] = shape[own >= 0]
        moved = disk.contact_motion(k) @ u[disk.free_dofs]
        np.testing.assert_allclose(moved, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"axis": "x"}, "turned by one sector about x, is .* m away"),
        ({"left": "right", "right": "left"}, "check sectors, axis, and whether left and right"),
        ({"axis": "r"}, "axis: must be one of x, y, z"),
        ({"left": [0]}, "left, right: must be as many nodes"),
        ({"dofs": [[0.5]]}, "dofs: must be integers of shape"),
    ],
)
def test_sectors_that_do_not_meet_are_refused(solid, changed, message):
    given = {name: getattr(solid.mesh, name) for name in ("coordinates", "dofs", "left", "right")}
    changed = {key: given.get(str(value), value) for key, value in changed.items()}
    structure = rom.Structure(solid.mass, solid.stiffness, contact=[0])
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.SectorMesh(**given | changed).cyclic(structure, SECTORS)
