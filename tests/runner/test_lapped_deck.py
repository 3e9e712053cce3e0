"""From an Abaqus deck to a scene: two lapped bars, and the Brake-Reuss beam where its deck is."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from elastic.lapped_deck import write_lapped_deck

from slipmode import rom, runner

pytest.importorskip("skfem", reason="needs slipmode[fem]")
EXAMPLES = Path(__file__).parents[2] / "examples" / "bolted_joints"
PUBLISHED = Path(__file__).parents[3] / "shared" / "data" / "published"


@pytest.fixture(scope="module", name="example")
def imported_example():
    return imported("brake_reuss")


def imported(name):
    sys.path.insert(0, str(EXAMPLES))  # its siblings
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(EXAMPLES))


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


@pytest.mark.oracle
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


@pytest.mark.slow
@pytest.mark.oracle
def test_bolts_press_the_lap_and_friction_bends_its_backbone(example, lap):
    rest = rom.preload(lap.structure, lap.law, lap.bolts)
    assert rest.tangential_share.max() > 0.1
    assert rest.normal_force.sum() == pytest.approx(4000.0, rel=1e-6)
    reduced = rom.reduce(lap.structure, (example.A,), law=rest.law)
    _, omega, damping = example.backbone(reduced, rest.law, 2e-7, decades=1)
    assert omega[0] == pytest.approx(reduced.frequency[0], rel=1e-6)  # all stuck
    assert damping[0] == pytest.approx(reduced.modal_damping[0] / (2 * omega[0]), rel=1e-4)
    assert omega[-1] < 0.99 * omega[0] and damping[-1] > 3.0 * damping[0]  # slips


@pytest.mark.oracle
def test_the_scene_of_a_deck_runs(example, lap, tmp_path):
    """The answer of the stuck structure: contacts slip only where bolts load them to 90 %."""
    reduced = rom.reduce(lap.structure, (6,), law=lap.law)
    omega = reduced.frequency[0]
    path = example.write(lap, tmp_path, 0.98 * omega, force=0.1)
    recording = runner.run(path, output=tmp_path)
    amplitude = runner.load(recording.mcap)["/modes"].column("A_abs")
    node = lap.structure.labels.dof(example.end_node(lap.deck), "z")
    dynamic = (1 - 0.98**2 + 0.98j * reduced.modal_damping[0] / omega) * omega**2
    stuck = 0.5 * 0.1 * reduced.mode_shapes[node, 0] / dynamic
    assert amplitude[-1] == pytest.approx(abs(stuck), rel=1e-2)
    shape = (lap.bodies.motion @ reduced.mode_shapes[:, 0]).reshape(-1, 3)
    mesh = (lap.deck.coordinates, lap.deck.cells)
    seen = runner.MeshMotion.of_recording(recording.mcap, *mesh, [shape], lap.pairs.nodes)
    row = int(np.flatnonzero(lap.deck.number == example.end_node(lap.deck))[0])
    recorded = runner.load(recording.mcap)["/elastic"]
    (moved,) = recorded.values[np.isin(recorded.time, seen.time)].T
    assert len(moved) == 64
    # the rest, 1.0 %, is what the force does beside the mode
    np.testing.assert_allclose(seen.displacement[:, row, 2], moved, atol=0.02 * moved.max())
    share = rom.preload(lap.structure, lap.law, lap.bolts).tangential_share
    assert set(seen.state[:, share < 0.9].ravel()) == {0}
    with pytest.raises(rom.SlipmodeError, match=r"^contacts: 11 are given, and 12 recorded"):
        runner.MeshMotion.of_recording(recording.mcap, *mesh, [shape], lap.pairs.nodes[1:])


@pytest.mark.oracle
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "hertz", "states", "pressure"),
    [
        ("brb_octave-jim.inp", 165.3, (41, 43, 18), 24.7),
        ("abaqus4joints_job.inp", 166.3, (42, 38, 22), 22.7),
    ],
)
def test_published_decks_are_carried_through(
    example, tmp_path, capsys, name, hertz, states, pressure
):
    """Frequency and damping fall and rise with amplitude as the published curve of that beam."""
    deck, curve = PUBLISHED / name, PUBLISHED / "tmdsimpy_brb_epmc_flat.yaml"
    if not (deck.is_file() and curve.is_file()):
        pytest.skip(f"needs the published {name} and {curve.name}")
    example.main(deck, tmp_path)
    assert f"stuck: {hertz} Hz" in capsys.readouterr().out
    with np.load(tmp_path / "found.npz") as found:
        a, omega, damping = found["curve"]
        assert tuple(np.bincount(found["state"], minlength=3)) == states
        assert found["pressure"].max() == pytest.approx(pressure, abs=0.1)
    amplitude, reference, ratio = imported("brake_reuss_picture").published_curve(curve)
    at = [2e-5, 3.25e-5, 6.9e-5]
    fallen = np.interp(at, 2 * a, omega / (2 * np.pi)) / hertz
    np.testing.assert_allclose(fallen, np.interp(at, amplitude, reference / reference[0]), 0.01)
    ours = np.interp(at, 2 * a, damping)
    np.testing.assert_allclose(ours, np.interp(at, amplitude, ratio), rtol=0.25)
