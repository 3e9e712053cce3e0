"""Tables of the tabulated region of the amplitude plane: as exact there, refused elsewhere."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from slipmode import fmu, runner
from slipmode.rom import Coulomb, Model, SlipmodeError, Tanh, reduce, tabulate, two_mass
from slipmode.rom.contact.friction_terms import contact_terms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.errors import OutsideRegionError
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.table.cache import cached_model
from slipmode.rom.table.region import Region, corners, with_neighbours
from slipmode.runner.cli import main
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.plan import amplitude_range, table_cost
from slipmode.runner.scene.scene import parse_scene, shipped_scenes

BOTH = reduce(two_mass(beta=0.01), carrier=(0.98, 1.65))
LIMIT = (3.6, 1.5)
# up one axis to the steady state of mode A, then mode B joins: the shipped two-mode scene
PATH = np.array([(0.0, 0.0), (3.0, 0.0), (2.95, 0.5), (2.9, 0.8), (3.1, 1.25)])
REACH = np.array(LIMIT) / 32
LAW = Tanh(2.0, 0.02)


def region_tiles(path=PATH, reach=REACH):
    return Region.along(path, LIMIT, reach)


def tabulated(law=LAW, **arguments):
    return tabulate(BOTH, law, LIMIT, 1e-3, harmonics=RESPONSE_ORDER, **arguments)


@pytest.fixture(scope="module")
def part():
    return tabulated(region=region_tiles())


@pytest.fixture(scope="module")
def whole():
    return tabulated()


def points_inside(region, count):
    points = np.random.default_rng(3).random((20 * count, 2)) * LIMIT
    return points[region.holds(points)][:count]


# Which part


def test_all_that_is_within_reach_of_the_path_is_marked():
    region = region_tiles()
    share = np.linspace(0, 1, 200)[:, np.newaxis]
    along = np.concatenate([a + share * (b - a) for a, b in pairwise(PATH)])
    for side in ((0, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        nearby = along + 0.999 * REACH * side
        nearby = nearby[np.all((nearby >= 0) & (nearby <= LIMIT), axis=1)]
        assert region.holds(nearby).all()
    assert not region.holds(np.array([(1.0, 1.0), (2.0, 0.2), (0.5, 0.1)])).any()


def test_a_cell_is_in_the_region_where_a_tile_in_it_is():
    region = region_tiles()
    for halvings in range(3, 7):
        node = np.linspace(0, 1, 2**halvings + 1)
        cells = region.cells(node * LIMIT[0], node * LIMIT[1])
        for a, b in np.ndindex(cells.shape):
            inside = (
                np.stack(
                    np.meshgrid(
                        *(node[k] + (np.arange(8) + 0.5) / 8 / 2**halvings for k in (a, b))
                    ),
                    axis=-1,
                ).reshape(-1, 2)
                * LIMIT
            )
            assert cells[a, b] == region.holds(inside).any()


def test_the_nodes_around_cells():
    cells = np.zeros((4, 4), dtype=bool)
    cells[1, 2] = True
    assert np.argwhere(corners(cells)).tolist() == [[1, 2], [1, 3], [2, 2], [2, 3]]
    assert with_neighbours(corners(cells)).sum() == 16


# How exact, at what cost


@pytest.mark.parametrize("law", [Tanh(2.0, 0.1), LAW, Tanh(2.0, 0.005), Coulomb(2.0)], ids=str)
def test_it_holds_to_the_tolerance_in_the_region(law):
    part = tabulated(law, region=region_tiles())
    points = points_inside(region_tiles(), 200)
    grid = Discretisation(part.accuracy.steps, part.accuracy.lines)
    S = contact_terms(BOTH, law, points, grid, 1e-4, np.array(LIMIT) / 10).S
    apart = np.abs(part.table(points) - S) / np.abs(part.table.nodes()[..., :2]).max(axis=(0, 1))
    # asked for: 1e-3; measured, also along other paths: 0.64e-3 at the worst
    assert apart.max() < 1e-3


def test_it_takes_less_than_half_of_the_contact_problems(part, whole):
    assert part.accuracy.solved < 0.45 * whole.accuracy.solved  # measured: 0.41


def test_its_harmonics_are_those_of_the_whole(part, whole):
    points = points_inside(region_tiles(), 100).astype(complex)
    P, expected = part.harmonics.at(points), whole.harmonics.at(points)
    scale = np.abs(expected).max()
    # linear between the nodes: coarser where the grid is
    assert np.abs(P - expected).max() < 2e-2 * scale


def test_it_does_not_depend_on_the_threads():
    hashes = {tabulated(Tanh(2.0, 0.1), region=region_tiles(), threads=n).hash for n in (1, 2, 3)}
    assert len(hashes) == 1


# Nothing elsewhere


def test_it_is_refused_elsewhere(part):
    elsewhere = np.array([1.0, 1.0])
    with pytest.raises(OutsideRegionError, match="outside the tabulated region"):
        part.table(elsewhere)
    with pytest.raises(OutsideRegionError):
        part.harmonics.at(elsewhere[np.newaxis].astype(complex))
    with pytest.raises(OutsideRegionError):
        part.harmonics.truncation(elsewhere[np.newaxis].astype(complex))
    with pytest.raises(SlipmodeError, match="outside the friction table, which ends at"):
        part.table((3.7, 1.0))
    with pytest.raises(SlipmodeError, match="model: its table holds in its tabulated region only"):
        fmu.export(part, "part.fmu")


def test_a_component_stops_where_it_would_leave_it(part):
    component = fmu.Component(part, ({0: 1.0}, {1: 1.0}))
    with pytest.raises(OutsideRegionError):
        component.reset(amplitude=(1.0, 1.0))
    component.set_inputs(force_A=0.15, force_B=0.25, frequency_A=0.98, frequency_B=1.65)
    with pytest.raises(
        fmu.StoppedError, match="leave the tabulated region of the friction table"
    ) as stop:
        component.do_step(0.0, 1000.0)
    assert stop.value.left_table


def test_the_path_must_be_of_the_same_range():
    with pytest.raises(SlipmodeError, match="region: must be a part of the same range"):
        tabulate(BOTH, Tanh(2.0, 0.1), (4.0, 1.5), region=region_tiles())


def test_a_file_keeps_the_part(part, tmp_path):
    part.save(tmp_path / "part.rom")
    loaded = Model.load(tmp_path / "part.rom")
    assert loaded.hash == part.hash
    np.testing.assert_array_equal(loaded.table.region, part.table.region)
    for unfit in (part.table.region[1:], part.table.region.astype(float)):
        replace(part, table=replace(part.table, region=unfit)).save(tmp_path / "unfit.rom")
        with pytest.raises(SlipmodeError, match="region: does not fit"):
            Model.load(tmp_path / "unfit.rom")


def test_the_cache_tells_parts_apart(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPMODE_CACHE", str(tmp_path))
    arguments = (BOTH, Tanh(2.0, 0.1), LIMIT, 1e-2)
    small = region_tiles(PATH[:2])
    sources = [cached_model(*arguments, region=v)[1] for v in (None, small, region_tiles())]
    assert sources == [False, False, False]
    model, cached = cached_model(*arguments, region=small)
    assert cached
    assert model.hash == tabulate(*arguments, combinations=(), region=small).hash


# Runs

PARTS = {
    "duration = 1500.0": "duration = 600.0",
    "window = [1400.0, 1450.0]": "window = [580.0, 600.0]",
    'formulation = "consistent"': 'table = "region"',
    "rerun = true": "rerun = false",
}
SCENE = shipped_scenes()["two-mode"].read_text(encoding="utf-8")
for piece, other in PARTS.items():
    assert piece in SCENE
    SCENE = SCENE.replace(piece, other)


def scene(name, text=SCENE):
    return replace(parse_scene(text, "."), name=name)


def on_whole_table(folder):
    return runner.run(scene("whole", SCENE.replace('"region"', '"whole"')), folder)


def signals(recording):
    return {topic: values for topic, (_, _, values) in recording.read().channels.items()}


def test_a_run_on_the_region_is_that_on_the_whole_table(tmp_path):
    on_part = runner.run(scene("part"), tmp_path)
    assert on_part.model.table.region is not None
    on_whole = on_whole_table(tmp_path)
    assert on_whole.model.table.region is None
    found, expected = signals(on_part), signals(on_whole)
    for topic in ("/modes", "/energy", "/contact/0", "/contact/1"):
        scale = np.abs(expected[topic]).max(axis=0)
        assert np.all(np.abs(found[topic] - expected[topic]).max(axis=0) <= 1e-3 * scale), topic


def test_a_run_that_starts_elsewhere_needs_only_its_region(tmp_path):
    moving = SCENE.replace("[run]", "[initial]\nA = [2.0, 1.0]\nB = [0.3, 0.9]\n[run]")
    recording = runner.run(scene("moving", moving), tmp_path)
    assert recording.model.table.region is not None
    with pytest.raises(OutsideRegionError):
        recording.model.table((0.6, 1.2))


def test_a_run_that_leaves_the_part_is_that_on_the_whole_table(tmp_path, monkeypatch):
    """A dry run that saw only the first half of the path."""
    real = amplitude_range._path

    def half(*arguments):
        path, *others = real(*arguments)
        return path[: len(path) // 2], *others

    monkeypatch.setattr(amplitude_range, "_path", half)
    again = runner.run(scene("again"), tmp_path)
    assert again.model.table.region is None
    (warning,) = (d for d in again.plan.decisions if d.level == "warning")
    assert warning.subject == "tabulated region"
    assert "leave the tabulated region of the friction table at t = " in warning.reason
    monkeypatch.setattr(amplitude_range, "_path", real)
    expected = signals(on_whole_table(tmp_path))
    for topic, values in signals(again).items():
        if topic != "/events":
            np.testing.assert_array_equal(values, expected[topic])


def test_the_plan_measures_what_is_saved(tmp_path, capsys, monkeypatch):
    measured = table_cost._seconds

    def half_a_millisecond_each(model, amplitudes):
        assert measured(model, amplitudes) > 0.0
        return 0.5e-3 * len(amplitudes)

    monkeypatch.setattr(table_cost, "_seconds", half_a_millisecond_each)
    path = tmp_path / "part.toml"
    path.write_text(SCENE, encoding="utf-8")
    assert main(["plan", str(path)]) == 0
    (line,) = (s for s in capsys.readouterr().out.splitlines() if s.startswith("its tabulation"))
    solved, more, seconds, error = map(
        float,
        re.search(
            r"(\d+) contact problems .* at least (\d+) more, (\S+) s of .* found (\S+),", line
        ).groups(),
    )
    plan = runner.make_plan(runner.load_scene(path))
    whole, _ = plan.model()
    assert whole.accuracy.solved >= solved + more > 1.1 * solved
    assert seconds == pytest.approx(0.5e-3 * more, rel=0.05)  # printed to two digits
    assert 0 < error <= 1e-3


@pytest.mark.parametrize(
    ("change", "choice", "reason"),
    [
        ((), "alone", "comes near 1.% of it; a run that leaves that part is repeated"),
        (('"region"', '"whole"'), "all of the table", 'table = "region" would do without'),
        (("[[0, 0.0], [200, 0.0], [200, 0.25]]", "[[0, 0.0], [600, 0.25]]"), "alone", "near"),
    ],
)
def test_the_plan_says_what_is_tabulated(change, choice, reason):
    plan = runner.make_plan(scene("planned", SCENE.replace(*change) if change else SCENE))
    (decision,) = (d for d in plan.decisions if d.subject == "tabulated region")
    assert decision.choice == choice
    assert re.search(reason, decision.reason)
    assert (plan.region is not None) == (choice == "alone")


def test_an_fmu_does_the_steps_on_the_whole_table(tmp_path):
    path = export_fmu(scene("part"), tmp_path / "part.fmu", headroom=1.0)
    through = runner.run(scene("through"), tmp_path, fmu=path)
    assert through.model.table.region is None
    assert "an FMU has all of it" in [d.reason for d in through.plan.decisions]
    expected = signals(on_whole_table(tmp_path))
    np.testing.assert_array_equal(signals(through)["/modes"], expected["/modes"])


def test_where_the_region_is_most_of_it_all_is_tabulated(monkeypatch):
    monkeypatch.setattr("slipmode.runner.plan.plan._LARGEST_REGION", 0.1)
    plan = runner.make_plan(scene("planned"))
    assert plan.region is None
    (decision,) = (d for d in plan.decisions if d.subject == "tabulated region")
    assert "would save little" in decision.reason


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (('"region"', '"part"'), 'model.table: must be one of "whole", "region"'),
        (("[[contact]]", "amplitude = [3.6, 1.5]\n[[contact]]"), "leave out model.amplitude"),
    ],
)
def test_a_part_that_cannot_be_told_is_refused(change, complaint):
    with pytest.raises(SlipmodeError, match=complaint) as refusal:
        scene("refused", SCENE.replace(*change))
    assert len(str(refusal.value).splitlines()) == 1
