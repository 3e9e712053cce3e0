"""Contacts from meshes: rigid motions, areas, resultants, frames, patches, bad input."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from slipmode import rom

TURN = Rotation.from_euler("xyz", [0.4, -0.7, 1.1]).as_matrix()


@dataclass
class Surfaces:
    """Two surfaces that face each other, the lower one first; `up` is its normal before TURN."""

    coordinates: np.ndarray
    lower: np.ndarray  # facets
    upper: np.ndarray
    turn: np.ndarray

    @property
    def dofs(self):
        return np.arange(self.coordinates.size).reshape(-1, 3)

    @property
    def is_lower(self):
        return np.isin(np.arange(len(self.coordinates)), self.lower)

    def pairs(self, **changed):
        given = {"surface": self.lower, "target": self.upper, "tolerance": 0.1} | changed
        return rom.contact_pairs(self.coordinates, self.dofs, **given)


def grid(nx, ny, kind, seed):
    """Points of a unit square, inner ones moved in it, and facets counter-clockwise."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, nx + 1), np.linspace(0, 1, ny + 1), indexing="ij")
    inside = (x % 1 != 0) & (y % 1 != 0)
    x, y = (c + 0.15 / max(nx, ny) * inside * rng.standard_normal(c.shape) for c in (x, y))
    number = np.arange(x.size).reshape(x.shape)
    quads = np.stack(
        [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1
    ).reshape(-1, 4)
    triangles = np.concatenate((quads[:, [0, 1, 2, 2]], quads[:, [0, 2, 3, 3]]))
    facets = {
        "quads": quads,
        "triangles": triangles[:, :3],
        "mixed": np.concatenate(
            (quads[::2], quads[1::2, [0, 1, 2, 2]], quads[1::2, [0, 2, 3, 3]])
        ),
    }[kind]
    return np.stack((x.ravel(), y.ravel(), np.zeros(x.size)), axis=1), facets


def surfaces(lower=(4, 3), upper=(3, 5), kinds=("quads", "triangles"), gap=0.0, bend=0.0, seed=0):
    """Squares turned in space; bent ones do not lie on each other's facets."""
    below, facets = grid(*lower, kinds[0], seed)
    above, others = grid(*upper, kinds[1], seed + (lower != upper))
    above[:, 2] += gap
    x = np.concatenate((below, above))
    x[:, 2] += bend * np.sin(2.0 * x[:, 0] + x[:, 1])
    return Surfaces(x @ TURN.T, facets, others[:, ::-1] + len(below), TURN)


MESHES = {
    "matching quadrilaterals": surfaces((4, 3), (4, 3), ("quads", "quads")),
    "quadrilaterals on triangles": surfaces(),
    "triangles on quadrilaterals": surfaces(kinds=("triangles", "quads")),
    "with a gap": surfaces(gap=0.05),
    "bent, with a gap": surfaces(gap=0.03, bend=0.05, kinds=("quads", "quads")),
    "mixed": surfaces(kinds=("mixed", "quads")),
}


def rigid_motions(coordinates):
    """Three translations and three rotations, (6, n)."""
    moved = [np.tile(e, (len(coordinates), 1)) for e in np.eye(3)]
    return np.array(
        [each.ravel() for each in moved + [np.cross(e, coordinates) for e in np.eye(3)]]
    )


@pytest.mark.oracle
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("patches", [None, 4])
def test_rigid_and_closing_motions_of_the_bodies(mesh, patches):
    """Bodies that move as one move no contact; closing by one closes every contact by one."""
    pairs = mesh.pairs(normal=mesh.turn[:, 2])
    assert pairs.unpaired.size == 0
    pairs = pairs.gathered(patches) if patches else pairs
    if mesh is not MESHES["bent, with a gap"]:
        assert pairs.area.sum() == pytest.approx(1.0, rel=1e-13)
        centre = mesh.turn @ [0.5, 0.5, 0.0]
        np.testing.assert_allclose(pairs.area @ pairs.position, centre, atol=1e-13)
    motions = rigid_motions(mesh.coordinates + np.array([3.0, -2.0, 5.0]))
    np.testing.assert_allclose(motions @ pairs.W, 0.0, atol=1e-13)
    up, down = (sign * np.outer(moved, mesh.turn[:, 2]).ravel()
                for sign, moved in ((1.0, mesh.is_lower), (-1.0, ~mesh.is_lower)))  # fmt: skip
    x_c = (up @ pairs.W).reshape(-1, 3)
    np.testing.assert_allclose(x_c[:, 2], pairs.frames[:, 2] @ mesh.turn[:, 2], rtol=1e-13)
    if mesh is not MESHES["bent, with a gap"]:
        np.testing.assert_allclose(x_c, np.tile([0.0, 0.0, 1.0], (len(x_c), 1)), atol=1e-14)
    np.testing.assert_allclose(down @ pairs.W, x_c.ravel(), atol=1e-13)


@pytest.mark.oracle
def test_a_cylinder_has_the_area_of_its_facets_and_normals_that_point_outwards():
    """Into a tube around it, with a gap that differs by what facets cut off."""
    circumference, rows, gap = 24, 4, 0.01
    angle = 2 * np.pi * np.arange(circumference) / circumference

    def shell(radius, turn):
        ring = np.stack((radius * np.cos(angle + turn), radius * np.sin(angle + turn)), axis=1)
        z = np.linspace(0.0, 1.0, rows + 1)
        return np.concatenate([np.column_stack((ring, np.full(len(ring), h))) for h in z])

    k = np.arange(circumference)
    row = np.stack((k, (k + 1) % circumference), axis=1)
    facets = np.concatenate(
        [np.column_stack((row + r * 24, row[:, ::-1] + (r + 1) * 24)) for r in range(rows)]
    )
    inner, outer = shell(1.0, 0.0), shell(1.0 + gap, 0.1)
    x = np.concatenate((inner, outer))
    dofs = np.arange(x.size).reshape(-1, 3)
    pairs = rom.contact_pairs(x, dofs, facets, facets[:, ::-1] + len(inner), tolerance=0.05)
    assert pairs.unpaired.size == 0
    assert pairs.area.sum() == pytest.approx(circumference * 2 * np.sin(np.pi / circumference))
    np.testing.assert_allclose(pairs.frames[:, 2, :2], pairs.position[:, :2], atol=1e-12)
    np.testing.assert_allclose(pairs.frames[:, 0, 2], 1.0)
    sagitta = (1 + gap) * (1 - np.cos(np.pi / circumference))
    assert np.all((pairs.gap > gap - sagitta - 1e-12) & (pairs.gap < gap + 1e-12))
    np.testing.assert_allclose(rigid_motions(x) @ pairs.W, 0.0, atol=1e-13)
    with pytest.raises(rom.SlipmodeError, match=r"^patches: the normals of patch 0 differ"):
        pairs.gathered(1)


@pytest.mark.oracle
def test_linear_displacements_are_met_exactly_on_meshes_that_do_not_match():
    """The patch test: a linear field of both bodies has no relative motion where they touch."""
    for kinds in (("quads", "triangles"), ("triangles", "quads")):
        mesh = surfaces(kinds=kinds)
        field = mesh.coordinates @ np.random.default_rng(1).standard_normal((3, 3)) + [1.0, 2, 3]
        np.testing.assert_allclose(field.ravel() @ mesh.pairs().W, 0.0, atol=1e-13)


@pytest.mark.oracle
@pytest.mark.parametrize("target", ["facets", "nodes"])
def test_nodes_that_match_are_tied_one_to_one(target):
    mesh = MESHES["matching quadrilaterals"]
    upper = mesh.upper if target == "facets" else np.unique(mesh.upper)[::-1]
    pairs = mesh.pairs(target=upper)
    count = len(mesh.coordinates) // 2
    x = np.random.default_rng(2).standard_normal((2, count, 3))
    expected = np.einsum("kab,kb->ka", pairs.frames, x[0] - x[1])
    np.testing.assert_allclose(x.ravel() @ pairs.W, expected.ravel(), atol=1e-13)
    assert [list(nodes) for nodes in pairs.nodes] == [[k] for k in range(count)]
    np.testing.assert_array_equal(pairs.gap, 0.0)


@pytest.mark.oracle
def test_two_node_sets_with_a_normal_and_areas():
    x = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 0.01], [1, 0, 0.02], [9, 0, 0]], float)
    dofs = np.array([[0, -1, 1], [2, -1, 3], [4, -1, 5], [6, -1, 7], [8, -1, 9], [-1, -1, -1]])
    pairs = rom.contact_pairs(
        x, dofs, [2, 1, 0], [3, 4], tolerance=0.1, normal=[0, 0, 2], area=[3, 2, 1], tangents=1,
        n_dofs=12,
    )  # fmt: skip
    np.testing.assert_array_equal(pairs.unpaired, [2])
    np.testing.assert_array_equal(pairs.area, [2, 1])
    np.testing.assert_allclose(pairs.gap, [0.02, 0.01])
    expected = np.zeros((12, 4))
    expected[[2, 3, 0, 1], range(4)] = 1.0
    expected[[8, 9, 6, 7], range(4)] = -1.0
    np.testing.assert_array_equal(pairs.W.toarray(), expected)


@pytest.mark.oracle
def test_gaps_are_distances_along_the_normal():
    np.testing.assert_allclose(MESHES["with a gap"].pairs().gap, 0.05, rtol=1e-12)
    np.testing.assert_array_equal(surfaces(gap=-0.02).pairs().gap, 0.0)
    rounded = surfaces(gap=0.0)
    rounded.coordinates = np.round(rounded.coordinates, 7)
    np.testing.assert_array_equal(rounded.pairs().gap, 0.0)


def test_frames_follow_the_normal_and_the_tangent():
    mesh = surfaces()
    mesh.coordinates = mesh.coordinates @ mesh.turn  # flat, the normal is z
    for tangent, axis in ((None, 0), ([0.0, 3.0, 1.0], 1)):
        frames = mesh.pairs(tangent=tangent).frames
        np.testing.assert_allclose(
            frames[:, 0], np.tile(np.eye(3)[axis], (len(frames), 1)), atol=1e-9
        )
        np.testing.assert_allclose(
            frames[:, 2], np.tile([0.0, 0.0, 1.0], (len(frames), 1)), atol=1e-9
        )
        np.testing.assert_allclose(np.linalg.det(frames), 1.0)


def test_nodes_beyond_the_target_are_unpaired():
    mesh = surfaces((10, 2), (3, 3))
    mesh.coordinates[~mesh.is_lower] += 0.45 * mesh.turn[:, 0]
    pairs = mesh.pairs()
    along = mesh.coordinates @ mesh.turn[:, 0]
    beyond = np.flatnonzero(mesh.is_lower & (along < 0.45 - 0.04))
    np.testing.assert_array_equal(pairs.unpaired, beyond)
    assert len(pairs.area) + len(beyond) == mesh.is_lower.sum()


@pytest.mark.oracle
def test_patches_are_means_by_area():
    mesh = MESHES["quadrilaterals on triangles"]
    pairs = mesh.pairs()
    labels = (pairs.position @ mesh.turn[:, 0] > 0.6).astype(int)
    found = pairs.gathered(labels)
    x = np.random.default_rng(3).standard_normal(mesh.coordinates.size)
    relative = (x @ pairs.W).reshape(-1, 3)  # all frames are the same
    for patch in (0, 1):
        own = labels == patch
        mean = pairs.area[own] @ relative[own] / pairs.area[own].sum()
        np.testing.assert_allclose((x @ found.W).reshape(-1, 3)[patch], mean, atol=1e-13)
        assert found.area[patch] == pytest.approx(pairs.area[own].sum())
        np.testing.assert_array_equal(found.nodes[patch], np.flatnonzero(own))
    halves = surfaces((30, 20)).pairs().gathered(7)
    np.testing.assert_allclose(halves.area, 1.0 / 7.0, rtol=0.03)  # bisected


@pytest.mark.oracle
def test_a_law_on_areas_has_stiffness_and_preload_by_area():
    law = rom.FrictionalContact.on_areas(
        [1.0, 2.0],
        mu=0.3,
        tangential_stiffness=5,
        normal_stiffness=[7, 8],
        pressure=10,
        tangents=1,
    )
    assert (law.preload, law.tangential_stiffness) == ((10.0, 20.0), (5.0, 10.0))
    assert law.normal_stiffness == (7.0, 16.0)


def test_what_is_held_on_both_sides_is_no_contact():
    mesh = MESHES["quadrilaterals on triangles"]
    edge = np.flatnonzero(mesh.coordinates @ mesh.turn[:, 0] < 1e-9)
    dofs = mesh.dofs.copy()
    dofs[edge] = -1
    pairs = rom.contact_pairs(mesh.coordinates, dofs, mesh.lower, mesh.upper, tolerance=0.1)
    np.testing.assert_array_equal(pairs.unpaired, edge[mesh.is_lower[edge]])
    assert np.linalg.matrix_rank(pairs.W.toarray()) == 3 * len(pairs.area)


MESH = MESHES["quadrilaterals on triangles"]
NODES, OTHERS = np.unique(MESH.lower), np.unique(MESH.upper)
FLIPPED = np.array([MESH.lower[0], MESH.lower[1, ::-1]])
TWICE = MESH.dofs.copy()
TWICE[1, 0] = 5
AREAS = {"area": [1.0, 2.0], "mu": 0.3, "tangential_stiffness": 1.0, "normal_stiffness": 1.0}


def pairing(dofs):
    return lambda: rom.contact_pairs(MESH.coordinates, dofs, MESH.lower, MESH.upper, tolerance=0.1)


REFUSED = {
    **{message: lambda changed=changed: MESH.pairs(**changed) for message, changed in {
        "surface: node 99 is unknown; coordinates has nodes 0 to 43": {"surface": [0, 99]},
        "surface: facet 1 has a node twice": {"surface": [[0, 1, 5, 4], [0, 1, 1, 4]]},
        "surface: facets 0 and 1 have opposite normals": {"surface": FLIPPED},
        "target: node 2 is also in surface": {"target": [2, 30]},
        "target: the facets near surface do not face it": {"target": MESH.upper[:, ::-1]},
        "target: node 20 is the nearest to both nodes 0 and 1": {
            "surface": [0, 1], "target": [20], "area": 1.0, "normal": [0, 0, 1], "tolerance": 2.0},
        "normal: is required because neither": {"surface": NODES, "target": OTHERS, "area": 1.0},
        "normal: lies in the plane of facet 0 of surface": {"normal": MESH.turn[:, 0]},
        "area: is required because surface has no facets": {"surface": NODES},
        "tolerance: must be a positive distance": {"tolerance": 0.0},
        "n_dofs: must be at least 132, because dofs has DOF 131": {"n_dofs": 44},
    }.items()},
    "tolerance: no node of surface is within 0.1 m of target": surfaces(gap=0.5).pairs,
    "dofs: DOF 5 occurs twice": pairing(TWICE),
    "dofs: all nodes where surface meets target are fixed": pairing(0 * MESH.dofs - 1),
    "area: must": lambda: rom.FrictionalContact.on_areas(**AREAS | {"area": [1.0, 0.0]}),
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_bad_input_is_one_line_that_names_the_argument(message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        REFUSED[message]()
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)
