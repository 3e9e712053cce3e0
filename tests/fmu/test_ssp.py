"""System structure packages, read and simulated by FMPy's SSP library, which has the schemas."""

import importlib
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import find_components, get_connections, read_ssd, read_ssv
from fmpy.validation import validate_fmu

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import load_scene
from slipmode.runner.fmi.ssp import Part, write_ssp

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module", params=[2, 3])
def package(request, tmp_path_factory):
    """The scene one-mode as a package, and the folder of its contents."""
    folder = tmp_path_factory.mktemp("ssp")
    path = folder / "scene.ssp"
    options = ["-o", str(path), "--range", "1", "--fmi", str(request.param)]
    assert main(["fmu", "one-mode", "--ssp", *options]) == 0
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder / "contents")
    return path, folder / "contents", request.param


@pytest.mark.oracle
def test_a_package_is_valid_and_starts_as_the_scene(package):
    path, contents, _ = package
    ssd = read_ssd(str(path), validate=True)
    assert ssd.name == load_scene("one-mode").title
    (component,) = find_components(ssd.system)
    # importers write 0 to input connectors that nothing is connected to
    assert {c.kind for c in component.connectors} == {"output"}
    assert {"A_abs", "contact_0_x"} <= {c.name for c in component.connectors}
    assert {"N", "rad/s", "m/s", "W"} <= {unit.name for unit in ssd.units}
    assert validate_fmu(str(contents / component.source)) == []
    values = read_ssv(str(contents / "resources" / "start.ssv"), validate=True)
    start = {parameter.name: parameter.value for parameter in values.parameters}
    forcing = load_scene("one-mode").forcing["A"]
    assert float(start["force_A"]) == forcing.amplitude.value(0.0)
    assert float(start["frequency_A"]) == forcing.frequency.value(0.0)


@pytest.mark.oracle
def test_fmpy_simulates_a_package_as_the_scene(package, shipped_scene):
    """Without edits and arguments: from the start values, under the force of the scene."""
    if package[2] == 3:
        pytest.skip("FMPy simulates packages of FMUs 2.0")
    rows = simulate_ssp(str(package[0]), stop_time=800.0, step_size=1.0)
    found = rows["structure.A_re"] + 1j * rows["structure.A_im"]
    modes = shipped_scene("one-mode").read().channels["/modes"][2][1:]
    expected = modes[:, 0] + 1j * modes[:, 1]
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


# The package of two FMUs that examples/friction_control_ssp.py makes and steps


@pytest.fixture(scope="module")
def example():
    if shutil.which("cc") is None:
        pytest.skip("no C compiler (cc)")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXAMPLES)
        yield importlib.import_module("friction_control_ssp")


@pytest.fixture(scope="module")
def controlled(example, tmp_path_factory):
    path = tmp_path_factory.mktemp("controlled") / "controlled.ssp"
    return path, example.main(path)


def test_both_fmus_reach_the_peaks_of_the_python_example(controlled, example):
    """The controller is a communication step late: 5e-4. The package has its connections."""
    path, peaks = controlled
    np.testing.assert_allclose(peaks, (0.9868, 2.9653, 8.8815), rtol=5e-4)
    system = read_ssd(str(path), validate=True).system
    pairs = {
        (f"{a.parent.name}.{a.name}", f"{b.parent.name}.{b.name}")
        for a, b in get_connections(system)
    }
    assert pairs == {(a if "." in a else f"system.{a}", b) for a, b in example.CONNECTIONS}


@pytest.mark.parametrize(
    ("pair", "reason"),
    [
        (("structure.nothing", "controller.amplitude"), "structure.nothing is not an output"),
        (("structure.A_abs", "controller.limit_scale"), "controller.limit_scale is not an input"),
        (("other.A_abs", "controller.amplitude"), "other.A_abs is not an output"),
        (("force", "amplitude"), "force and amplitude are both without a component"),
    ],
)
def test_connections_that_do_not_exist_are_refused_and_named(
    example, package, tmp_path, pair, reason
):
    beside = [Part("controller", example.build_controller(tmp_path / "controller.fmu"))]
    structure = package[1] / "resources" / "one-mode.fmu"
    with pytest.raises(SlipmodeError, match=reason):
        write_ssp(structure, load_scene("one-mode"), tmp_path / "wrong.ssp", beside, [pair])
