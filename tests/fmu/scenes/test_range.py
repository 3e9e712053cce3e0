"""How far the FMU of a scene goes beyond it."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest
from fmu_exchange import SceneFmu

from slipmode import runner
from slipmode.rom import SlipmodeError
from slipmode.runner import export_fmu, load_scene, make_plan, shipped_scenes
from slipmode.runner.fmi.export import largest_forces
from slipmode.runner.scene.script import Script

SHIPPED = [
    pytest.param(name, marks=[] if name == "one-mode" else [pytest.mark.slow])
    for name in shipped_scenes()
    if not load_scene(name).mistuning
]


def forced(scene, factor):
    """The scene under more force."""
    forcing = {
        mode: replace(
            force,
            amplitude=Script(
                force.amplitude.times, tuple(factor * v for v in force.amplitude.values)
            ),
        )
        for mode, force in scene.forcing.items()
    }
    return replace(scene, forcing=forcing)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_tenth_more_force_stays_inside(name, tmp_path):
    scene = load_scene(name)
    path = export_fmu(scene, tmp_path / f"{name}.fmu")
    time, rows = SceneFmu(path, forced(scene, 1.1)).co_simulated()
    assert time[-1] == scene.run.duration and np.isfinite(rows).all()


@pytest.mark.parametrize("fmi", [2, 3])
def test_inputs_declare_how_far_they_go(fmi, tmp_path):
    scene = load_scene("two-mode")
    path = export_fmu(scene, tmp_path / "scene.fmu", fmi)
    declared = {v.name: v for v in fmpy.read_model_description(path).modelVariables}
    for mode, force in (("A", 0.15), ("B", 0.25)):
        most = float(declared[f"force_{mode}"].max)
        assert float(declared[f"force_{mode}"].min) == -most
        assert 1.1 * force < most < 2.0 * force
        frequency = declared[f"frequency_{mode}"]
        assert float(frequency.min) < scene.forcing[mode].frequency.value(0.0)
        assert scene.forcing[mode].frequency.value(0.0) < float(frequency.max)


def test_the_declared_forces_are_where_the_table_ends(tmp_path):
    """To 1 %: so far the FMU goes, and no further."""
    scene = load_scene("one-mode")
    plan = make_plan(scene)
    model, _ = plan.model(contact=True, headroom=1.25)
    (most,) = largest_forces(plan, model).values()
    path = export_fmu(scene, tmp_path / "scene.fmu")
    SceneFmu(path, forced(scene, most / 0.15)).co_simulated()
    with pytest.raises(Exception, match=r"[Dd]iscard|status 2"):
        SceneFmu(path, forced(scene, 1.02 * most / 0.15)).co_simulated()


def test_what_no_force_moves_declares_no_force(tmp_path):
    """Mode B swings freely."""
    scene = load_scene("two-mode")
    scene = replace(scene, forcing={"A": scene.forcing["A"]}, initial={"B": 0.3 + 0j})
    path = export_fmu(scene, tmp_path / "scene.fmu")
    declared = {v.name: v for v in fmpy.read_model_description(path).modelVariables}
    assert declared["force_B"].max is None and declared["force_A"].max is not None


def test_runs_by_an_fmu_take_its_range(tmp_path):
    path = export_fmu("one-mode", tmp_path / "scene.fmu")
    through = runner.run("one-mode", tmp_path / "through", fmu=path)
    inside = runner.run("one-mode", tmp_path / "inside")
    assert through.model.table.amplitude_range == pytest.approx(
        1.25 * inside.model.table.amplitude_range
    )
    _, time, expected = inside.read().channels["/modes"]
    _, again, found = through.read().channels["/modes"]
    np.testing.assert_array_equal(again, time)
    tolerance = inside.plan.scene.model.tolerance  # of either table
    assert np.abs(found - expected).max() < tolerance * np.abs(expected).max()


@pytest.mark.parametrize(
    "change",
    [
        {"amplitude": (2.0, 0.8)},
        {"amplitude": (3.6, 1.8)},
        {"tolerance": 5e-3},
    ],
    ids=["smaller", "another mode farther", "another tolerance"],
)
def test_an_fmu_of_another_table_is_of_another_model(change, tmp_path):
    scene = load_scene("two-mode")
    options = replace(scene.model, amplitude=(3.6, 1.5), tolerance=1e-2)
    path = export_fmu(replace(scene, model=replace(options, **change)), tmp_path / "other.fmu")
    with pytest.raises(SlipmodeError, match="has a different model"):
        runner.run(replace(scene, model=options), tmp_path, fmu=path)


@pytest.mark.parametrize("headroom", [1.0, 1.1, 4.0 / 3.0])
def test_an_fmu_of_any_range_is_of_the_scenes_model(headroom, tmp_path):
    """Amplitude ranges are compared bit for bit."""
    scene = load_scene("one-mode")
    path = export_fmu(scene, tmp_path / "scene.fmu", headroom=headroom)
    plan = make_plan(scene)
    through = runner.run(scene, tmp_path, fmu=path)
    assert through.model.hash == plan.model(contact=True, headroom=headroom)[0].hash
