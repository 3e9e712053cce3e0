"""From an Abaqus deck to a scene: two lapped bars, and the Brake-Reuss beam where its deck is."""

import importlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from elastic.lapped_deck import write_lapped_deck

from slipmode import rom, runner
from slipmode.rom import ContactProblem, Discretisation, combination_resonances
from slipmode.runner import validate
from slipmode.runner.commands.mode_table import mode_table

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
    with pytest.warns(rom.ValidityWarning, match="of its friction limit"):
        rest = rom.preload(lap.structure, lap.law, lap.bolts)
    assert rest.normal_force.sum() == pytest.approx(4000.0, rel=1e-6)
    reduced = rom.reduce(lap.structure, (example.A,), law=rest.law)
    _, omega, damping = example.backbone(reduced, rest.law, 2e-7, decades=1)
    assert reduced.frequency == pytest.approx([10932.68], rel=1e-5)
    assert omega[0] == pytest.approx(reduced.frequency[0], rel=1e-6)  # all stuck
    assert damping[0] == pytest.approx(reduced.modal_damping[0] / (2 * omega[0]), rel=1e-4)
    np.testing.assert_allclose(omega[-2:], [10865.7, 10692.3], rtol=1e-3)
    np.testing.assert_allclose(damping[-2:], [0.0179, 0.0331], rtol=2e-2)


@pytest.mark.parametrize("grid", [(32, 8), pytest.param((64, 16), marks=pytest.mark.slow)])
def test_two_modes_slide_the_lap_in_both_directions(example, lap, grid):
    """Sliders that other phase lines brought on lay beyond their limit: steps had no solution."""
    rest = rom.preload(lap.structure, lap.law, lap.bolts, warned=False)
    reduced = rom.reduce(lap.structure, (6, 7), law=rest.law, smallest_response=1e-2)
    resonances = combination_resonances(reduced.carrier, even=reduced.even)
    points = np.array([[2e-7, 2e-7], [6e-7, 6e-7]])
    problem = ContactProblem.of(reduced, rest.law, resonances)
    found = problem.on(Discretisation(*grid), 1e-3, points[0]).solve(points)
    assert found.residual.max() <= 1e-3
    # with 126 nonresonant modes instead of 21 they are 0.2 % larger
    expected = [[2.672 - 1.753j, 2.810 - 2.244j], [20.00 - 4.005j, 32.77 - 13.88j]]
    assert found.marched.max() <= 32 * grid[0]  # 30; 40 if what sliders remember only marches on
    errors = np.abs(found.S - expected) / np.abs(expected)
    assert errors.max() < (0.02 if grid == (32, 8) else 2e-3)
    assert np.all(found.power > 0.0)
    roughly = problem.on(Discretisation(*grid), 1e-2, points[0]).solve(points)
    assert roughly.residual.max() <= 1e-2
    assert roughly.marched.max() <= 20 * grid[0]  # 17; 150 once more on a way from small motion


@pytest.mark.slow
def test_frequencies_on_patches_of_the_modes_fall_short_by_the_square_of_their_error(
    example, deck
):
    """Bending modes of the bars; patches hold less than the 21 contacts that they gather."""
    joined = sys.modules["bolted_bodies"].bodies(deck)
    ends = (deck.surfaces["bots"], deck.surfaces["tops"])
    fine = rom.contact_pairs(deck.coordinates, joined.dofs, *ends, tolerance=1e-4)

    def stuck(pairs):
        K, per_area = joined.stiffness + 400.0 * joined.mass, {"mu": 0.1, "normal_stiffness": 1e12}
        law = rom.FrictionalContact.on_areas(pairs.area, tangential_stiffness=1e12, **per_area)
        found = rom.modes(rom.Structure(joined.mass, K, contact=pairs.W), law, 9).states["stuck"]
        return found.frequency[[6, 7]], found.shapes[:, [6, 7]]

    exact, shapes = stuck(fine)
    for tolerance in (0.5, 0.25, 0.15):
        patches = rom.motion_patches(fine, shapes, tolerance)
        assert patches.patch.max() < 20
        low = 1.0 - stuck(fine.gathered(patches.patch))[0] / exact
        assert np.all(low > 0.05 * patches.error**2)
        assert np.all(low < 0.2 * patches.error**2)  # 0.16


def test_modes_of_a_scene_are_those_under_its_static_force(example, deck, lap, tmp_path):
    """Bars that are pried apart at an end of the lap: contacts that open hold nothing there."""
    pried = lap.bolts.copy()
    for z, force in ((-0.01, -2000.0), (0.01, 2000.0)):
        (node,) = np.flatnonzero(np.isclose(deck.coordinates, [0.12, 0.01, z]).all(axis=1))
        pried[lap.bodies.dofs[node, 2]] += force
    rest = rom.preload(lap.structure, lap.law, pried, warned=False)
    assert np.any(rest.state == 2)
    expected = rom.reduce(lap.structure, (6, 7), law=rest.law).frequency
    closed = rom.reduce(lap.structure, (6, 7), law=lap.law).frequency
    assert np.all(expected < 0.98 * closed)
    path = example.write(replace(lap, bolts=pried), tmp_path, expected[0])
    table = mode_table(str(path))
    np.testing.assert_allclose(table.states["stuck"].frequency[[6, 7]], expected, rtol=1e-9)


def test_the_scene_of_a_deck_runs(example, lap, tmp_path):
    """It does not slip at this force: the answer of the stuck structure."""
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
    assert set(seen.state.ravel()) == {0}
    with pytest.raises(rom.SlipmodeError, match=r"^contacts: 11 are given, and 12 recorded"):
        runner.MeshMotion.of_recording(recording.mcap, *mesh, [shape], lap.pairs.nodes[1:])
    with pytest.raises(rom.SlipmodeError, match=r"^shapes: must be of 1 modes, .* got 2"):
        runner.MeshMotion.of_recording(recording.mcap, *mesh, [shape] * 2, lap.pairs.nodes)


def two_mode_scene(folder, contacts, force, reach):
    """On the small deck, with a coarse table of so large amplitudes."""
    deck = write_lapped_deck(folder / "lap.inp")
    path = imported("brake_reuss_two_modes").main(deck, folder, contacts, 2000.0, force)
    model = f"amplitude = {reach}\ntolerance = 5e-2"
    path.write_text(path.read_text().replace("tolerance = 2e-2", model))
    return path


@pytest.mark.slow
def test_two_modes_of_a_deck_become_a_scene(example, tmp_path):
    """Forced across and along the lap, which does not slip: the answer of the stuck structure."""
    path = two_mode_scene(tmp_path, 2, 0.15, [1.2e-7, 6e-8])
    lap = example.joint(example.read_deck(tmp_path / "lap.inp"), 2, 2000.0)
    reduced = rom.reduce(lap.structure, (6, 7), law=lap.law)
    nodes = [lap.structure.labels.dof(example.end_node(lap.deck), axis) for axis in "zy"]
    force = 0.15 * reduced.mode_shapes[nodes, [0, 1]]
    damped = 1 - example.NEAR**2 + 1j * example.NEAR * reduced.modal_damping / reduced.frequency
    recording = runner.run(path, output=tmp_path)
    modes = runner.load(recording.mcap)["/modes"]
    found = [modes.column(f"{mode}_abs")[-1] for mode in "AB"]
    stuck = np.abs(0.5 * force / (damped * reduced.frequency**2))
    np.testing.assert_allclose(found, stuck, rtol=2e-2)
    imported("brake_reuss_mesh").main(tmp_path, tmp_path / "lap.rrd", recording.mcap)
    assert (tmp_path / "lap.rrd").stat().st_size > 10_000


@pytest.mark.slow
def test_two_modes_that_slide_a_lap_move_as_at_full_order(tmp_path):
    path = two_mode_scene(tmp_path, 6, 0.3, [1.4e-7, 7e-8])
    found = validate(path, output=tmp_path)
    error = {each.subject: each for each in found.comparisons}
    assert error["modal displacement"].error < 0.025  # 0.018, of a table to 0.05
    assert error["energy dissipated by friction"].error < 0.025  # 0.017
    assert error["modal displacement"].reference_error < 1e-3


def test_a_deck_becomes_a_scene_and_pictures(example, tmp_path, capsys):
    """As it is called, on the small deck: what the bolts press, and all that is drawn of it."""
    deck = write_lapped_deck(tmp_path / "lap.inp")
    example.main(deck, tmp_path, contacts=6, bolt=2000.0, largest=2e-7)
    said = capsys.readouterr().out
    assert "pressed by 4000 N" in said
    assert "stuck: 1" in said
    with np.load(tmp_path / "found.npz") as found:
        assert found["sizes"].sum() == len(set(found["members"])) == 21
        assert found["curve"].shape == (3, 16)
    assert rom.load_structure(tmp_path / "beam.npz").n_contacts == 18
    published = tmp_path / "published.yaml"
    published.write_text(
        "modal_amplitude : [1e-8, 1e-7]\nfrequency_rad_per_s : [11e3, 10e3]\n"
        "damping_factor_frac_crit : [1e-3, 2e-2]\n"
    )
    imported("brake_reuss_picture").draw(tmp_path, tmp_path / "lap.png", published)
    assert (tmp_path / "lap.png").read_bytes().startswith(b"\x89PNG")
    for name in ("lap.rrd", "lap.vtu"):
        imported("brake_reuss_mesh").main(tmp_path, tmp_path / name)
        assert (tmp_path / name).stat().st_size > 10_000


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


@pytest.mark.parametrize("name", ["brb_octave-jim.inp", "abaqus4joints_job.inp"])
def test_bodies_of_published_decks_are_joined_and_move_as_one(example, name):
    path = PUBLISHED / name
    if not path.is_file():
        pytest.skip(f"needs the published deck {name}")
    deck = example.read_deck(path)
    assert (len(deck.ties), len(deck.equations), len(deck.loads)) == (12, 15, 6)
    motion, kept = sys.modules["bolted_bodies"].joined(deck)
    moves = rigid_motions(deck.coordinates)
    in_cells = np.repeat(np.isin(np.arange(len(deck.coordinates)), deck.cells), 3)
    np.testing.assert_allclose((motion @ moves[kept])[in_cells], moves[in_cells], atol=1e-11)
