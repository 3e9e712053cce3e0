"""`slipmode fmu` and `slipmode run --fmu`: a scene and its FMU are the same simulation."""

import importlib.util
import zipfile
from dataclasses import replace
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_exchange import SceneFmu
from fmu_fixtures import DISCARD, FMI_ERRORS, instance, unpacked
from lxml import etree

from slipmode import runner
from slipmode.__main__ import main
from slipmode.runner import export_fmu, load_scene, shipped_scenes

SHIPPED = [
    pytest.param(name, marks=[] if name == "one-mode" else [pytest.mark.slow])
    for name in shipped_scenes()
    if load_scene(name).tabulated
]
# The other one runs with `make test-all`.
ONE_VERSION = pytest.mark.parametrize(
    "fmi", [3, pytest.param(2, marks=pytest.mark.slow)], indirect=True
)


def channels(recording):
    """{topic: (time, values)}"""
    return {topic: data[1:] for topic, data in recording.read().channels.items()}


def variables_of(path):
    return {v.name: v for v in fmpy.read_model_description(path).modelVariables}


def differences(found, expected):
    """Largest difference of each column, relative to its largest value."""
    return np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)


@pytest.mark.oracle
@pytest.mark.parametrize("name", SHIPPED)
def test_integrators_of_importers_agree_with_the_run_of_the_scene(name, tmp_path):
    """Co-Simulation, and Model Exchange by an adaptive and by a fixed-step method."""
    scene = load_scene(name).in_slow_time()  # as an FMU
    driven = SceneFmu(export_fmu(scene, tmp_path / f"{name}.fmu", headroom=1.0), scene)
    read = channels(runner.run(scene, tmp_path))
    (time, modes), (_, energy) = read["/modes"], read["/energy"]
    expected = np.column_stack((modes[:, : len(driven.names) - 1], energy[:, 2]))
    assert np.abs(expected).max(axis=0).min() > 0.0
    # the damper begins to slip within a few communication steps
    fixed = driven.step * (0.1 if name == "wedge-damper" else 1.0)
    for way in (driven.co_simulated(), driven.exchanged(), driven.exchanged(fixed)):
        np.testing.assert_allclose(way[0], time, rtol=1e-9)
        assert differences(way[1], expected).max() < 1e-4


@ONE_VERSION
def test_a_recording_through_an_fmu_has_the_bits_of_the_run(fmi, tmp_path, shipped_scene):
    path = export_fmu("two-mode", tmp_path / f"für FMI {fmi}.fmu", fmi, headroom=1.0)
    expected = channels(shipped_scene("two-mode"))
    found = channels(runner.run("two-mode", tmp_path / "through", fmu=path))
    assert set(found) == set(expected)
    for topic, (time, values) in expected.items():
        np.testing.assert_array_equal(found[topic][0], time)
        np.testing.assert_array_equal(found[topic][1], values)


# Range and start values


def forced(scene, factor):
    """The scene under more force."""
    forcing = {
        mode: replace(force, amplitude=force.amplitude.scaled(factor))
        for mode, force in scene.forcing.items()
    }
    return replace(scene, forcing=forcing)


def test_the_declared_forces_are_where_the_table_ends(tmp_path):
    """To 1 %: so far the FMU goes, and no further. It starts as the scene."""
    scene = load_scene("one-mode")
    path = export_fmu(scene, tmp_path / "scene.fmu")
    declared = variables_of(path)
    most, now = float(declared["force_A"].max), float(declared["force_A"].start)
    assert now == scene.forcing["A"].amplitude.value(0.0) and 1.1 * now < most
    assert float(declared["force_A"].min) == -most
    frequency = scene.forcing["A"].frequency.value(0.0)
    assert float(declared["frequency_A"].min) < frequency < float(declared["frequency_A"].max)
    SceneFmu(path, forced(scene, most / now)).co_simulated()
    with pytest.raises(FMI_ERRORS) as refused:
        SceneFmu(path, forced(scene, 1.02 * most / now)).co_simulated()
    assert refused.value.status == DISCARD


def test_a_run_by_an_fmu_takes_its_larger_range(tmp_path):
    path = export_fmu("one-mode", tmp_path / "scene.fmu")
    through = runner.run("one-mode", tmp_path / "through", fmu=path)
    inside = runner.run("one-mode", tmp_path / "inside")
    ranges = (each.model.table.amplitude_range for each in (through, inside))
    assert np.divide(*ranges) == pytest.approx(1.25)
    (_, found), (_, expected) = (channels(each)["/modes"] for each in (through, inside))
    tolerance = inside.plan.scene.model.tolerance  # of either table
    assert np.abs(found - expected).max() < tolerance * np.abs(expected).max()


# What the file tells importers


@pytest.mark.oracle
def test_fmpy_comes_from_the_stimuli_of_an_fmu_to_its_reference_results(tmp_path):
    """Without the scene; a sweep is two rows of stimuli."""
    scene = load_scene("sweep")
    scene = replace(scene, contact=(), run=replace(scene.run, duration=400.0))
    path = export_fmu(scene, tmp_path / "sweep.fmu")
    folder = unpacked(path, tmp_path / "sweep") / "extra" / "org.fmi-standard.fmi-ls-ref"
    (experiment,) = etree.parse(folder / "fmi-ls-manifest.xml").getroot()
    stimuli, references = (
        np.genfromtxt(folder / child.get("source"), delimiter=",", names=True)
        for child in experiment
    )
    assert stimuli["time"].tolist() == [0.0, 400.0]
    outputs = ["A_re", "A_im", "B_re", "B_im"]
    through = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=400.0,
        step_size=2.0,
        output_interval=2.0,
        input=stimuli,
        output=outputs,
    )
    for name in outputs:
        error = np.abs(through[name] - references[name]).max()
        assert error < 1e-6 * np.abs(references[name]).max()


# The command


@ONE_VERSION
@pytest.mark.parametrize(
    ("name", "sweep", "tolerance"), [("one-mode", 0.0, 1e-12), ("square-plate", 5.0 * np.pi, 1e-5)]
)
def test_the_command_writes_a_valid_fmu_that_starts_and_runs_as_the_scene(
    fmi, tmp_path, capsys, shipped_scene, name, sweep, tolerance
):
    """With rates of inputs alone; contacts of the plate have another reference frequency there."""
    path = tmp_path / "one scene.fmu"
    assert main(["fmu", name, "-o", str(path), "--fmi", str(fmi), "--range", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[0] == str(path)
    assert validate_fmu(str(path)) == []
    time, expected = channels(shipped_scene(name))["/modes"]
    modes = ("A", "A2")[: expected.shape[1] // 3]
    with instance(unpacked(path, tmp_path / "unpacked"), fmi) as made:
        made.start(frequency_rate_A=sweep)
        for start, end in pairwise(time):
            made.step(start, end - start)
        parts = [f"{mode}_{part}" for mode in modes for part in ("re", "im")]
        found = made.get(*parts, *(f"{mode}_abs" for mode in modes))
    np.testing.assert_allclose(found, expected[-1], rtol=tolerance)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs ziglang")
def test_an_fmu_for_other_platforms_has_their_libraries(tmp_path):
    platforms = {"aarch64-linux": b"\x7fELF", "x86_64-windows": b"MZ"}
    platforms["aarch64-darwin"] = b"\xcf\xfa\xed\xfe"
    path = tmp_path / "many.fmu"
    assert main(["fmu", "one-mode", "-o", str(path), "--platforms", ",".join(platforms)]) == 0
    with zipfile.ZipFile(path) as archive:
        libraries = {n: archive.read(n) for n in archive.namelist() if n.startswith("binaries/")}
    for platform, magic in platforms.items():
        (content,) = (c for n, c in libraries.items() if n.startswith(f"binaries/{platform}/"))
        assert content.startswith(magic) and b"fmi3DoStep" in content
