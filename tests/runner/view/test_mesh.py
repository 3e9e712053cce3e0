"""A mesh as it vibrates, its contacts coloured by state: what is seen, shown, written."""

import numpy as np
import pytest
from rrd import verified

from slipmode import rom, runner
from slipmode.runner.view.mesh.motion import skin, triangles

FOUR = [[0, 1, 3, 7], [0, 1, 7, 5], [0, 5, 7, 4], [0, 3, 2, 7], [0, 6, 4, 7], [0, 2, 6, 7]]


def block(count=(3, 2, 2), size=(3.0, 1.0, 0.5)):
    """Nodes and hexahedra of a block."""
    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(size, count, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape([n + 1 for n in count])
    corners = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    cells = np.stack(
        [number[tuple(slice(c, c - 1 or None) for c in corner)] for corner in corners], -1
    )
    return nodes, cells.reshape(-1, 8)


def tetrahedra(cells):
    """Six of each hexahedron, whose corners are in binary order then."""
    binary = cells[:, [0, 1, 3, 2, 4, 5, 7, 6]]
    return binary[:, FOUR].reshape(-1, 4)


@pytest.mark.oracle
@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra"])
def test_the_skin_is_closed_and_faces_outwards(kind):
    nodes, cells = block()
    cells = cells if kind == "hexahedra" else tetrahedra(cells)
    facets = skin(cells)
    each = 1 if kind == "hexahedra" else 2
    assert len(facets) == 2 * each * (3 * 2 + 3 * 2 + 2 * 2)
    a, b, c = np.moveaxis(nodes[triangles(facets)], 1, 0)
    volume = np.einsum("kx,kx->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(1.5)
    np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0.0, atol=1e-14)


def swaying(frames=5):
    """A block that sways, with two contacts that change their state."""
    nodes, cells = block()
    time = np.linspace(0.0, 0.1, frames)
    u = 1e-6 * np.sin(20.0 * time)[:, np.newaxis, np.newaxis] * nodes[:, [2, 0, 1]]
    state = np.stack((np.arange(frames) % 3, np.full(frames, 1)), axis=1)
    return runner.MeshMotion(nodes, cells, u + 1e-7, [[0, 1], [5]], state, time)


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"cells": [[0, 1, 2, 99]]}, r"^cells: nodes must be 0 to 35"),
        ({"contacts": [[0], [36]]}, r"^contacts\[1\]: nodes must be 0 to 35"),
        ({"contacts": [[0]]}, r"^state: must be \(5, 1\), finite, got \(5, 2\)"),
        ({"state": np.full((5, 2), 3)}, r"^state: must be 0 \(stuck\), 1 \(slipping\) or 2"),
        ({"displacement": "x"}, r"^displacement: must be numbers"),
        ({"time": [0.0, 1.0, 1.0, 2.0, 3.0]}, r"^time: must be increasing"),
        ({"nodes": np.zeros((36, 2))}, r"^nodes: must be \(any, 3\), finite, got \(36, 2\)"),
    ],
)
def test_what_does_not_fit_is_named(changed, complaint):
    good = swaying()
    given = {name: getattr(good, name) for name in good.__dataclass_fields__}
    with pytest.raises(rom.SlipmodeError, match=complaint):
        runner.MeshMotion(**(given | changed))


def test_a_mesh_that_does_not_move_is_not_shown(tmp_path):
    still = swaying()
    still = runner.MeshMotion.at_rest(
        still.nodes, still.cells, 0.0 * still.nodes, still.contacts, [0, 1]
    )
    with pytest.raises(rom.SlipmodeError, match=r"^displacement: nothing moves"):
        runner.show_mesh(still, save=tmp_path / "still.rrd")


def test_rerun_gets_every_frame(tmp_path):
    from rerun.chunk import RrdReader

    motion = swaying()
    path = tmp_path / "swaying.rrd"
    runner.show_mesh(motion, save=path)
    assert verified(path)
    found = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name.endswith(("positions", "colors")) and not chunk.is_static:
                found[str(chunk.entity_path), name.split(":")[-1]] = batch.column(name).to_pylist()
    moved = np.array(found["/mesh/body", "vertex_positions"])
    assert moved.shape == (5, 4 * 32, 3)
    largest = np.linalg.norm(motion.displacement, axis=-1).max()
    shift = np.linalg.norm(moved - motion.nodes[skin(motion.cells).ravel()], axis=-1)
    expected = np.linalg.norm(motion.displacement[:, skin(motion.cells).ravel()], axis=-1)
    np.testing.assert_allclose(shift, 0.06 * 3.0 / largest * expected, atol=1e-6)
    still = np.array(found["/interface", "positions"])
    np.testing.assert_allclose(still, np.tile(motion.nodes[[0, 1, 5]], (5, 1, 1)), atol=1e-6)
    colors = np.array(found["/interface", "colors"])
    np.testing.assert_array_equal(colors[:, 0], colors[:, 1])  # of one contact
    assert len(np.unique(colors[:3, 0])) == 3
    assert len(np.unique(colors[:, 2])) == 1
    assert colors[1, 0] == colors[0, 2]  # slipping


def test_paraview_gets_every_frame(tmp_path):
    meshio = pytest.importorskip("meshio", reason="needs slipmode[mesh]")
    motion = swaying(3)
    files = runner.write_mesh(motion, tmp_path / "swaying.vtu")
    assert [file.name for file in files] == [f"swaying_00{k}.vtu" for k in range(3)]
    for k, file in enumerate(files):
        mesh = meshio.read(file)
        np.testing.assert_allclose(mesh.points, motion.nodes)
        np.testing.assert_allclose(mesh.point_data["displacement"], motion.displacement[k])
        np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], motion.cells)
        np.testing.assert_array_equal(mesh.cells_dict["vertex"].ravel(), [0, 1, 5])
        states = mesh.cell_data_dict["state"]
        assert set(states["hexahedron"]) == {-1}
        np.testing.assert_array_equal(states["vertex"], [k, k, 1])
    first = (motion.displacement[0], motion.contacts, motion.state[0])
    (alone,) = runner.write_mesh(
        runner.MeshMotion.at_rest(motion.nodes, motion.cells, *first), tmp_path / "one.vtu"
    )
    assert alone.name == "one.vtu"
    assert not list(tmp_path.glob(".slipmode*"))
    with pytest.raises(rom.SlipmodeError, match=r"^path: must end in \.vtu, got swaying\.stl"):
        runner.write_mesh(motion, tmp_path / "swaying.stl")
