"""From an Abaqus deck to a scene: two lapped bars, and the Brake-Reuss beam where its deck is."""

import sys
from pathlib import Path

import numpy as np
import pytest
from lapped_deck import write_lapped_deck

from slipmode import rom, runner
from slipmode.runner.mode_table import mode_table

pytest.importorskip("skfem", reason="needs slipmode[fem]")
EXAMPLES = Path(__file__).parents[2] / "examples"
PUBLISHED = Path(__file__).parents[2].parent / "shared/data/published"


@pytest.fixture(scope="module", name="example")
def imported_example():
    sys.path.insert(0, str(EXAMPLES))  # its siblings
    try:
        import brake_reuss
    finally:
        sys.path.remove(str(EXAMPLES))
    return brake_reuss


@pytest.fixture(scope="module", name="deck")
def small_deck(example, tmp_path_factory):
    return example.read_deck(write_lapped_deck(tmp_path_factory.mktemp("deck") / "lap.inp"))


@pytest.fixture(scope="module", name="lap")
def small_joint(example, deck):
    return example.joint(deck, contacts=12, bolt=2000.0)


def rigid_motions(coordinates):
    """(3 nodes, 6)."""
    turns = [np.cross(axis, coordinates) for axis in np.eye(3)]
    moves = [np.broadcast_to(axis, coordinates.shape) for axis in np.eye(3)]
    return np.stack(moves + turns, axis=-1).reshape(-1, 6)


def test_a_deck_is_read_in_its_frames(deck):
    assert deck.coordinates[:306].min(axis=0) == pytest.approx([0.0, 0.0, -0.012], abs=1e-12)
    assert deck.coordinates.max(axis=0) == pytest.approx([0.18, 0.02, 0.012], abs=1e-12)
    edges = deck.coordinates[deck.cells][:, [1, 3, 4]] - deck.coordinates[deck.cells][:, :1]
    assert np.linalg.det(edges).sum() == pytest.approx(
        2 * 0.12 * 0.02 * 0.01 + 4 * 0.012**2 * 0.002
    )
    corners = deck.coordinates[deck.surfaces["bots"]]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(outward[:, 2] > 0.0)
    assert np.all(corners[..., 2] == 0.0)


def test_a_truncated_deck_is_refused(example, tmp_path):
    path = write_lapped_deck(tmp_path / "lap.inp")
    text = path.read_text()
    path.write_text(text[: text.index("*Material")].replace("_tops_S1, S1", "_nothing, S1"))
    with pytest.raises(rom.SlipmodeError, match=r"lap\.inp: .*_nothing"):
        example.read_deck(path)


def test_joined_bodies_move_as_one_and_bolts_are_in_balance(deck, lap):
    x, joined = deck.coordinates, lap.bodies
    moves, kept = rigid_motions(x), joined.dofs.ravel()
    of_kept = np.zeros((lap.structure.n_dofs, 6))
    of_kept[kept[kept >= 0]] = moves[kept >= 0]
    in_cells = np.repeat(np.isin(np.arange(len(x)), deck.cells), 3)
    np.testing.assert_allclose((joined.motion @ of_kept)[in_cells], moves[in_cells], atol=1e-12)
    strain = np.abs(joined.stiffness @ of_kept).max() / np.abs(joined.stiffness).max()
    assert strain < 1e-13
    assert np.abs(of_kept.T @ lap.bolts).max() < 1e-9
    mass = of_kept[:, 0] @ joined.mass @ of_kept[:, 0]
    assert mass == pytest.approx(7800.0 * (2 * 0.12 * 0.02 * 0.01 + 4 * 0.012**2 * 0.002))
    free = rom.modes(lap.structure, lap.law, n=8).states["free"].hertz
    assert free[:7] == pytest.approx([3.0] * 7, rel=1e-4)  # and apart along the bolts


def test_bolts_press_the_lap_and_friction_bends_its_backbone(example, lap):
    with pytest.warns(rom.ValidityWarning, match="what friction can hold"):
        rest = rom.preload(lap.structure, lap.law, lap.bolts)
    assert rest.normal_force.sum() == pytest.approx(4000.0, rel=1e-6)
    reduced = rom.reduce(lap.structure, (example.A,), law=rest.law)
    a, omega, damping = example.backbone(reduced, rest.law, 2e-7, decades=1)
    print(reduced.frequency, a, omega, damping)


def test_the_scene_of_a_deck_runs(example, lap, tmp_path):
    path = example.write(lap, tmp_path, (0.98 * 10900.0, 0.98 * 16700.0))
    table = mode_table(str(path))
    rest = rom.preload(lap.structure, lap.law, lap.bolts, warned=False)
    expected = rom.reduce(lap.structure, (6, 7), law=rest.law).frequency
    np.testing.assert_allclose(table.states["stuck"].frequency[[6, 7]], expected, rtol=1e-9)
    recording = runner.run(path, output=tmp_path)
    print(recording)
