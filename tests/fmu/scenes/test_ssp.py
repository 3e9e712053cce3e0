"""`slipmode fmu --ssp`, read back by FMPy's SSP library, which validates by the schemas."""

import zipfile

import numpy as np
import pytest
from fmpy.ssp.ssd import Component, find_components, get_connections, read_ssd, read_ssv
from fmpy.validation import validate_fmu
from fmu_exchange import SceneFmu

from slipmode.runner import load_scene, run
from slipmode.runner.cli import main


@pytest.fixture(scope="module", params=[2, 3])
def package(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("ssp") / "one.ssp"
    options = ["-o", str(path), "--fmi", str(request.param), "--range", "1"]
    assert main(["fmu", "one-mode", "--ssp", *options]) == 0
    return path


def test_it_reads_back(package):
    ssd = read_ssd(str(package), validate=True)
    assert ssd.name == load_scene("one-mode").title
    (component,) = find_components(ssd.system)
    assert isinstance(component, Component) and component.source == "resources/one-mode.fmu"
    kinds = {c.name: c.kind for c in component.connectors}
    assert kinds["force_A"] == "input" and kinds["contact_0_x"] == "output"
    assert {c.name: c.kind for c in ssd.system.connectors} == kinds
    pairs = {(a.name, b.name) for a, b in get_connections(ssd.system)}
    assert pairs == {(name, name) for name in kinds}
    units = {unit.name for unit in ssd.units}
    assert {"N", "rad/s", "m/s", "W"} <= units


def test_the_start_values_are_those_of_the_scene(package, tmp_path):
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    values = read_ssv(str(tmp_path / "resources" / "start.ssv"), validate=True)
    start = {parameter.name: parameter for parameter in values.parameters}
    forcing = load_scene("one-mode").forcing["A"]
    assert float(start["force_A"].value) == forcing.amplitude.value(0.0)
    assert float(start["frequency_A"].value) == forcing.frequency.value(0.0)
    assert {"damping_A", "tolerance", "contact_wanted", "A_re"} <= set(start)


def test_its_fmu_runs_as_the_scene(package, tmp_path):
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    path = tmp_path / "resources" / "one-mode.fmu"
    assert validate_fmu(str(path)) == []
    fmi = 2 if b'fmiVersion="2.0"' in zipfile.ZipFile(path).read("modelDescription.xml") else 3
    scene = load_scene("one-mode")
    _, found = SceneFmu(path, scene, fmi).co_simulated()
    expected = run(scene, tmp_path).read().channels["/modes"][2][:, :2]
    assert np.abs(found[:, :2] - expected).max() < 1e-5 * np.abs(expected).max()
