"""FMUs behind the names of the component, and `slipmode run --fmu`."""

import os
import shutil
import zipfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from time import sleep

import numpy as np
import pytest
from fmpy import fmi1, read_model_description
from fmpy.simulation import instantiate_fmu
from fmu_fixtures import FORCE_PATTERNS, START, VERSIONS, component
from mcap.reader import make_reader

from slipmode import fmu, runner
from slipmode.__main__ import main
from slipmode.fmu.archive.resources import identity
from slipmode.fmu.imported import Imported
from slipmode.rom import SlipmodeError
from slipmode.runner import export_fmu, parse_scene

MODE_B = """
title = "One mode, exact Coulomb, a growing force"
[structure]
model = "two-mass"
[friction]
law = "coulomb"
limit = 2.0
[modes]
A = 0
B = 1
[forcing.B]
dof = 1
amplitude = [[0, 0.1], [50, 0.3]]
frequency = [[0, 1.6], [80, 1.7]]
[initial]
B = [0.3, -0.2]
[run]
duration = 80.0
step = 1.3
tolerance = 1e-7
[log]
rerun = false
"""


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def raw(recording, topic="/modes"):
    with recording.mcap.open("rb") as file:
        return [(m.log_time, m.data) for _, _, m in make_reader(file).iter_messages(topic)]


def every_message(recording):
    """{topic: [(time, data)]}, read in one pass."""
    messages = defaultdict(list)
    with recording.mcap.open("rb") as file:
        for _, channel, m in make_reader(file).iter_messages():
            messages[channel.topic].append((m.log_time, m.data))
    return messages


def mode_b(*changes):
    text = MODE_B
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return replace(parse_scene(text, "."), name="mode-b")


@pytest.mark.parametrize("scene", ["two-mode", "force-step"])
def test_the_recording_is_that_of_the_component(scene, fmi, tmp_path, shipped_scene):
    path = export_fmu(scene, tmp_path / f"{scene} für FMI {fmi}.fmu", fmi, headroom=1.0)
    inside = shipped_scene(scene)
    through = runner.run(scene, tmp_path / "through", fmu=path)
    assert len(raw(inside)) == inside.steps + 1
    expected, found = every_message(inside), every_message(through)
    for topic in inside.read().channels:
        assert found[topic] == expected[topic] != [], topic
    with through.mcap.open("rb") as file:
        metadata = {m.name: m.metadata for m in make_reader(file).iter_metadata()}
    assert metadata["run"]["fmu"] == path.name


def test_the_scene_rules_whatever_the_fmu_starts_with(fmi, tmp_path):
    """One mode, exact Coulomb, initial amplitudes; an FMU of the same model, started otherwise."""
    scene = mode_b()
    other = mode_b(("B = [0.3, -0.2]", "B = [0.1, 0.1]"), ("1e-7", "1e-4"))
    plan = runner.make_plan(scene)
    other = replace(other, model=replace(other.model, amplitude=(1.0, plan.amplitude[0])))
    scene = replace(scene, model=replace(scene.model, amplitude=(1.0, plan.amplitude[0])))
    path = export_fmu(other, tmp_path / "other.fmu", fmi, headroom=1.0)
    inside = runner.run(scene, tmp_path / "inside")
    assert raw(runner.run(scene, tmp_path / "through", fmu=path)) == raw(inside)


def test_a_run_that_stops_is_recorded_as_far(fmi, tmp_path):
    scene = mode_b(("[log]", "[model]\namplitude = [1.0, 0.8]\n[log]"))
    path = export_fmu(scene, tmp_path / "small.fmu", fmi, headroom=1.0)
    messages, recordings = [], []
    for where, through in (("inside", None), ("through", path)):
        with pytest.raises(fmu.StoppedError) as stop:
            runner.run(scene, tmp_path / where, fmu=through)
        messages.append(str(stop.value))
        recordings.append(runner.read(tmp_path / where / "mode-b.mcap"))
    inside, through = recordings
    for topic, (_, time, values) in inside.channels.items():
        np.testing.assert_array_equal(through.channels[topic][1], time)
        np.testing.assert_array_equal(through.channels[topic][2], values)
    assert messages[0].partition(": ")[0] in messages[1]  # stopped at t = ...
    assert messages[1].startswith("small.fmu: stopped at t = ")
    assert "outside the friction table" in messages[1]
    assert through.events[-1].message == messages[1]


def test_an_fmu_is_a_component(fmus, fmi, two_mode_model):
    made = component(two_mode_model)
    with Imported(fmus[fmi], START) as imported:
        assert set(imported.input_names) == set(made.input_names)
        assert set(made.output_names) <= set(imported.output_names)
        for time, force in ((0.0, 0.15), (2.5, 0.1)):
            for stepped in (made, imported):
                stepped.set_inputs(force_A=force, force_rate_B=-1e-3)
                stepped.do_step(time, 2.5)
            found = imported.outputs()
            assert {name: found[name] for name in made.output_names} == made.outputs()


def test_a_failed_step_leaves_outputs_and_a_reason(fmus, fmi):
    with Imported(fmus[fmi], START) as imported:
        inputs = np.tile([START.get(name, 0.0) for name in imported.input_names], (4, 1))
        with pytest.raises(fmu.StoppedError, match=r"stopped at t = 2 s: .*step -1 s") as stop:
            imported.run(np.array([1.0, 1.0, -1.0, 1.0]), inputs)
        assert stop.value.time == 2.0
        assert stop.value.outputs.shape == (2, len(imported.output_names))
        imported.do_step(2.0, 1.0)  # it goes on from where it stands
        assert imported.outputs()["time"] == 3.0


def test_each_hears_of_its_own_failures(fmus, fmi):
    with Imported(fmus[fmi]) as first, Imported(fmus[fmi]) as second:
        for step, imported in ((-1, first), (-2, second), (-3, first)):
            with pytest.raises(fmu.StoppedError, match=f"step {step} s"):
                imported.do_step(0.0, step)


def test_instances_of_fmpy_itself_log_after_an_import(fmus, fmi, tmp_path, capfd):
    with Imported(fmus[fmi]):
        pass
    shutil.unpack_archive(fmus[fmi], tmp_path, format="zip")
    description = read_model_description(tmp_path)
    instance = instantiate_fmu(tmp_path, description, "CoSimulation")
    with pytest.raises(fmi1.FMICallException):
        instance.doStep(0.0, -1.0)
    instance.freeInstance()
    said = capfd.readouterr().out
    assert fmi == 3 or "DoStep: not allowed" in said  # of FMI 3.0 FMPy prints nothing


def test_wrong_use_is_refused_and_named(fmus, fmi):
    with pytest.raises(SlipmodeError, match="A_abs is not among its start values: force_A"):
        Imported(fmus[fmi], {"A_abs": 1.0})
    with pytest.raises(SlipmodeError, match=r"tolerance: must be 1e-13 to 0\.01, got 1$"):
        Imported(fmus[fmi], {"tolerance": 1.0})
    with pytest.raises(SlipmodeError, match="outside the friction table"):
        Imported(fmus[fmi], {"A_re": 1e3})
    with Imported(fmus[fmi]) as imported:
        with pytest.raises(SlipmodeError, match="A_re: is not an input; inputs are force_A, "):
            imported.set_inputs(A_re=1.0)
        with pytest.raises(SlipmodeError, match="frequency_A: must be > 0"):
            imported.set_inputs(frequency_A=-1.0)
        with pytest.raises(SlipmodeError, match="time of the FMU, 0 s, got 1 s"):
            imported.do_step(1.0, 1.0)


def test_no_files_stay_behind(fmus, fmi, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with Imported(fmus[fmi]) as imported:
        assert len(list(tmp_path.iterdir())) == 1
    assert not list(tmp_path.iterdir())
    imported.close()
    with pytest.raises(SlipmodeError):
        Imported(fmus[fmi], {"A_re": 1e3})
    assert not list(tmp_path.iterdir())


def _rewritten(source, target, change):
    """A copy of an FMU, its entries {name: content} changed."""
    with zipfile.ZipFile(source) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in change(entries).items():
            archive.writestr(name, content)


def _no_library(entries):
    return {name.replace("-linux", "-vms"): content for name, content in entries.items()}


def _no_co_simulation(entries):
    text = entries["modelDescription.xml"].decode()
    start, end = text.index("<CoSimulation"), text.index("<UnitDefinitions")
    return entries | {"modelDescription.xml": (text[:start] + text[end:]).encode()}


def _other_token(entries):
    return entries | {"resources/token.txt": b"0" * 64}


def _no_description(entries):
    return {name: entries[name] for name in entries if name != "modelDescription.xml"}


def _no_energy(entries):
    text = entries["modelDescription.xml"].replace(b'"dissipated_energy"', b'"heat"')
    return entries | {"modelDescription.xml": text}


def _damaged_table(entries):
    table = entries["resources/table.npy"]
    return entries | {"resources/table.npy": table[:-8] + b"damaged!"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_no_energy, "dissipated_energy is not among its outputs: A_re, "),
        (_damaged_table, "table.npy: damaged, its checksum"),
        (_no_library, "has no library for "),
        (_no_co_simulation, "must be an FMU for Co-Simulation"),
        (_other_token, "the instantiation token is not that"),
        (_no_description, "not a readable FMU"),
    ],
)
def test_damaged_fmus_are_refused_and_named(change, message, tmp_path):
    source = export_fmu("one-mode", tmp_path / "whole.fmu")
    _rewritten(source, tmp_path / "damaged.fmu", change)
    with pytest.raises(SlipmodeError, match=f"damaged.fmu: .*{message}"):
        runner.run("one-mode", tmp_path, fmu=tmp_path / "damaged.fmu")
    assert not list(tmp_path.glob("*.mcap"))  # nothing was begun


def test_files_of_other_kinds_are_refused(tmp_path, capsys, monkeypatch, fmus):
    monkeypatch.chdir(tmp_path)
    Path("text.fmu").write_text("no zip")
    shutil.copy(fmus[3], "other.fmu")
    for name, message in (
        ("none.fmu", "none.fmu: no such FMU"),
        ("text.fmu", "text.fmu: is not an FMU, because"),
        (".", ".: is not an FMU, because"),
        ("other.fmu", "other.fmu: has a different model than the scene; export the model of the "),
    ):
        assert main(["run", "one-mode", "--fmu", name]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"slipmode: {message}")


def test_modes_of_other_names_are_refused(one_mode_model, tmp_path):
    """The right model, but the scene's mode A is the FMU's mode B."""
    plan = runner.make_plan(runner.load_scene("one-mode"))
    path = tmp_path / "b.fmu"
    fmu.export(plan.model()[0], path, plan.excited.force_patterns, mode_names=("B",))
    with pytest.raises(SlipmodeError, match=r"force_A is not among its inputs: force_B"):
        runner.run("one-mode", tmp_path, fmu=path)


def test_the_force_patterns_count(two_mode_model):
    assert identity(two_mode_model, FORCE_PATTERNS) == identity(two_mode_model, FORCE_PATTERNS)
    assert identity(two_mode_model, FORCE_PATTERNS) != identity(
        two_mode_model, ({0: 1.0}, {1: 2.0})
    )


def test_fmus_that_are_opened_in_threads_leave_the_working_directory_alone(fmus, monkeypatch):
    """FMPy goes to the library's folder and back while it loads: here it takes its time there."""
    before, load = Path.cwd(), fmi1.cdll.LoadLibrary

    def slow(path):
        sleep(0.05)
        return load(path)

    monkeypatch.setattr(fmi1.cdll, "LoadLibrary", slow)

    def opened(_):
        with Imported(fmus[3]):
            pass

    try:
        with ThreadPoolExecutor(4) as pool:
            list(pool.map(opened, range(8)))
        assert Path.cwd() == before
    finally:
        os.chdir(before)
