"""`slipmode fmu --ssp`, read back by FMPy's SSP library, which validates by the schemas."""

import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Component, find_components, get_connections, read_ssd, read_ssv
from fmpy.validation import validate_fmu
from fmu_exchange import SceneFmu

from slipmode.__main__ import main
from slipmode.fmu.imported import Imported
from slipmode.runner import load_scene, run
from slipmode.runner.fmi.ssp import Part, write_ssp


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Packages by version of the standard; None: the version that is exported by default."""
    folder = tmp_path_factory.mktemp("ssp")

    @cache
    def export(fmi):
        path = folder / f"{fmi}.ssp"
        options = ["-o", str(path), "--range", "1", *(["--fmi", str(fmi)] if fmi else [])]
        assert main(["fmu", "one-mode", "--ssp", *options]) == 0
        return path

    return export


@pytest.fixture(params=[2, 3])
def package(request, exported):
    return exported(request.param)


def test_it_reads_back(package):
    ssd = read_ssd(str(package), validate=True)
    assert ssd.name == load_scene("one-mode").title
    (component,) = find_components(ssd.system)
    assert isinstance(component, Component) and component.source == "resources/one-mode.fmu"
    # Importers write 0 to input connectors that nothing is connected to
    assert {c.kind for c in component.connectors} == {"output"}
    assert {"A_abs", "contact_0_x"} <= {c.name for c in component.connectors}
    assert ssd.system.connectors == ssd.system.connections == []
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


def test_fmpy_runs_it_as_the_scene(exported, shipped_scene):
    """Without edits and arguments: from the start values, under the force of the scene."""
    rows = simulate_ssp(str(exported(None)), stop_time=800.0, step_size=1.0)
    found = rows["structure.A_re"] + 1j * rows["structure.A_im"]
    expected = shipped_scene("one-mode").read().channels["/modes"][2][1:, :2]
    expected = expected[:, 0] + 1j * expected[:, 1]
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


def test_fmpy_drives_an_input_and_reads_an_output_of_the_system(exported, tmp_path):
    with zipfile.ZipFile(exported(None)) as archive:
        fmu = Path(archive.extract("resources/one-mode.fmu", tmp_path))
    pairs = [("force", "structure.force_A"), ("structure.A_abs", "amplitude")]
    path = write_ssp(fmu, load_scene("one-mode"), tmp_path / "driven.ssp", (), pairs)
    system = read_ssd(str(path), validate=True).system
    assert {c.name: c.kind for c in system.connectors} == {"force": "input", "amplitude": "output"}
    ((start,),) = (b.parameterValues[0].parameters for b in system.parameterBindings)
    assert (start.name, float(start.value), start.unit) == ("force", 0.15, "N")
    rows = simulate_ssp(str(path), stop_time=50.0, step_size=1.0, input={"force": lambda t: 0.1})
    with Imported(fmu) as stepped:
        for k in range(50):
            stepped.set_inputs(force_A=0.1 if k else 0.0)  # FMPy starts connections at 0
            stepped.do_step(float(k), 1.0)
        assert rows["amplitude"][-1] == pytest.approx(stepped.outputs()["A_abs"], rel=1e-12)


FMI2 = """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
<CoSimulation modelIdentifier="m"/>
<ModelVariables>
<ScalarVariable name="gear" valueReference="0" causality="input" variability="discrete">
<Integer start="3"/></ScalarVariable>
<ScalarVariable name="ratio" valueReference="1" causality="parameter" variability="tunable">
<Real start="2.5"/></ScalarVariable>
<ScalarVariable name="label" valueReference="2" causality="parameter" variability="fixed">
<String start="a &lt; b"/></ScalarVariable>
<ScalarVariable name="limit" valueReference="3" causality="local" variability="constant">
<Integer start="9"/></ScalarVariable>
<ScalarVariable name="engaged" valueReference="4" causality="output" variability="discrete"
initial="calculated"><Boolean/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="5"/></Outputs>
<InitialUnknowns><Unknown index="5"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>"""

FMI3 = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="g">
<CoSimulation modelIdentifier="m"/>
<ModelVariables>
<Float64 name="time" valueReference="9" causality="independent" variability="continuous"/>
<Int32 name="gear" valueReference="0" causality="input" start="3"/>
<Float64 name="ratio" valueReference="1" causality="parameter" variability="tunable" start="2.5"/>
<Float64 name="gains" valueReference="2" causality="parameter" variability="tunable" start="1 2">
<Dimension start="2"/></Float64>
<UInt64 name="long" valueReference="3" causality="parameter" variability="tunable"
start="18446744073709551615"/>
<Boolean name="engaged" valueReference="4" causality="output" variability="discrete"/>
</ModelVariables>
<ModelStructure><Output valueReference="4"/><InitialUnknown valueReference="4"/></ModelStructure>
</fmiModelDescription>"""


@pytest.mark.parametrize("description", [FMI2, FMI3])
def test_other_fmus_may_have_variables_of_any_type_and_no_units(exported, tmp_path, description):
    with zipfile.ZipFile(exported(None)) as archive:
        fmu = Path(archive.extract("resources/one-mode.fmu", tmp_path))
    other = tmp_path / "gearbox.fmu"
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("modelDescription.xml", description)
    beside = [Part("gearbox", other, {"ratio": 4.0})]
    pairs = [("gear", "gearbox.gear"), ("gearbox.engaged", "engaged")]
    path = write_ssp(fmu, load_scene("one-mode"), tmp_path / "two.ssp", beside, pairs)
    system = read_ssd(str(path), validate=True).system  # also validates the parameter sets
    gearbox = next(each for each in find_components(system) if each.name == "gearbox")
    assert {c.name: c.kind for c in gearbox.connectors} == {"gear": "input", "engaged": "output"}
    ends = {(a.name, b.name) for a, b in get_connections(system)}
    assert ends == {("gear", "gear"), ("engaged", "engaged")}
    (binding,) = gearbox.parameterBindings
    given = {p.name: (p.type, p.value) for p in binding.parameterValues[0].parameters}
    assert given.pop("label", ("String", "a < b")) == ("String", "a < b")
    assert given == {"gear": ("Integer", "3"), "ratio": ("Real", "4.0")}
