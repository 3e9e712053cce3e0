"""`slipmode fmu`, and libraries for other platforms."""

import importlib.util
import shutil
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_fixtures import VERSIONS, instance

from slipmode.fmu.archive.cross_compiler import TARGETS, platform_binary
from slipmode.runner import load_scene, run
from slipmode.runner.cli import main
from slipmode.runner.fmu_export import export_fmu

MAGIC = {"linux": b"\x7fELF", "windows": b"MZ", "darwin": b"\xcf\xfa\xed\xfe"}


@pytest.mark.parametrize("fmi", VERSIONS)
def test_the_command_writes_an_fmu(fmi, tmp_path, capsys):
    path = tmp_path / "one mode.fmu"
    assert main(["fmu", "one-mode", "-o", str(path), "--fmi", str(fmi)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(path)
    scene = load_scene("one-mode")
    assert description.fmiVersion == f"{fmi}.0"
    assert description.modelName == scene.title
    assert float(description.defaultExperiment.stopTime) == scene.run.duration


def test_an_fmu_of_a_scene_without_scripts_runs_as_the_scene(tmp_path):
    """Nothing changes in this scene after t = 0, so the FMU needs no inputs."""
    folder = tmp_path / "scene"
    scene = load_scene("one-mode")
    path = export_fmu(scene, tmp_path / "scene.fmu")
    shutil.unpack_archive(path, folder, format="zip")
    _, time, values = run(scene, tmp_path).read().channels["/modes"]
    with instance(folder, 3) as made:
        made.start()
        for start, end in pairwise(time):
            made.step(start, end - start)
        final = made.get("A_re", "A_im", "A_abs")
    np.testing.assert_allclose(final, values[-1], rtol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("no-such-scene",), "'no-such-scene': no such scene file"),
        (("one-mode", "--platforms", "vax"), "platforms: vax is none of x86_64-linux"),
        (("one-mode", "-o", "no/such/folder/x.fmu"), "no/such/folder/x.fmu"),
    ],
)
def test_what_is_refused_is_named(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["fmu", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"slipmode: {message}")


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs ziglang")
@pytest.mark.parametrize("target", TARGETS)
def test_libraries_for_other_platforms(target):
    library = platform_binary(target)
    assert library.startswith(MAGIC[target.rpartition("-")[2]])
    for entry in (b"fmi2DoStep", b"fmi3DoStep"):
        assert entry in library
    assert b"ubsan" not in library
    if not target.endswith("darwin"):  # its linker keeps the names
        assert b"sm_component_step" not in library  # hidden, and stripped
    assert platform_binary(target) == library  # from the cache
