"""The package of two FMUs that examples/friction_control_ssp.py makes and steps."""

import importlib
import shutil
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import find_components, get_connections, read_ssd, read_ssv
from fmpy.validation import validate_fmu

from slipmode.rom import SlipmodeError
from slipmode.runner import load_scene
from slipmode.runner.fmi.ssp import Part, write_ssp

EXAMPLES = Path(__file__).parents[3] / "examples"
PEAKS = (0.9868, 2.9653, 8.8815)  # of friction_control.py: tests/runner/test_examples.py


@pytest.fixture(scope="module")
def example():
    if shutil.which("cc") is None:
        pytest.skip("no C compiler (cc)")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXAMPLES)
        yield importlib.import_module("friction_control_ssp")


@pytest.fixture(scope="module")
def controlled(example, tmp_path_factory):
    package = tmp_path_factory.mktemp("controlled") / "controlled.ssp"
    return package, example.main(package)


def test_both_fmus_reach_the_peaks_of_the_python_example(controlled):
    _, peaks = controlled
    np.testing.assert_allclose(peaks, PEAKS, rtol=5e-4)  # the controller is a step late: 2e-4


def test_it_reads_back(controlled, example, tmp_path):
    package, _ = controlled
    ssd = read_ssd(str(package), validate=True)
    sources = {c.name: c.source for c in find_components(ssd.system)}
    assert sources == {
        "structure": "resources/friction_control.fmu",
        "controller": "resources/controller.fmu",
    }
    pairs = {
        (f"{a.parent.name}.{a.name}", f"{b.parent.name}.{b.name}")
        for a, b in get_connections(ssd.system)
    }
    named = {(a if "." in a else f"system.{a}", b) for a, b in example.CONNECTIONS}
    assert pairs == named and ("system.force_A", "structure.force_A") in pairs
    assert {c.name for c in ssd.system.connectors} == {
        *("force_A", "frequency_A", "frequency_rate_A")
    }
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    values = read_ssv(str(tmp_path / "resources" / "controller.ssv"), validate=True)
    start = {p.name: float(p.value) for p in values.parameters}
    assert start["best_amplitude"] == pytest.approx(3.0, rel=0.05)
    assert start["time_constant"] == 10.0
    for path in sources.values():
        assert validate_fmu(str(tmp_path / path)) == []


def test_the_controller_refuses_what_it_cannot_do(example, controlled, tmp_path):
    """Parameters out of range, references that are none, and steps out of order."""
    path = example.build_controller(tmp_path / "controller.fmu")
    description = fmpy.read_model_description(path)
    made = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path, tmp_path / "unzipped"),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="controller",
    )
    made.instantiate()
    for references, values in (([3], [0.0]), ([4], [-1.0]), ([5], [9.0])):
        made.setReal(references, values)
        with pytest.raises(FMICallException):
            made.enterInitializationMode()
        made.reset()
    with pytest.raises(FMICallException):
        made.setReal([7], [1.0])
    made.enterInitializationMode()
    made.exitInitializationMode()
    made.doStep(0.0, 1.0)
    with pytest.raises(FMICallException):
        made.doStep(5.0, 1.0)
    made.terminate()
    made.freeInstance()


def test_connections_that_are_none_are_refused_and_named(controlled, tmp_path):
    package, _ = controlled
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    structure, controller = (
        tmp_path / f"resources/{name}.fmu" for name in ("friction_control", "controller")
    )
    for pair, wrong in (
        (("structure.nothing", "controller.amplitude"), "structure.nothing is not an output"),
        (("structure.A_abs", "controller.limit_scale"), "controller.limit_scale is not an input"),
        (("other.A_abs", "controller.amplitude"), "other.A_abs is not an output"),
        (("force", "amplitude"), "force and amplitude are both without a component"),
    ):
        with pytest.raises(SlipmodeError, match=wrong):
            write_ssp(
                structure,
                load_scene("one-mode"),
                tmp_path / "wrong.ssp",
                [Part("controller", controller)],
                [pair],
            )
