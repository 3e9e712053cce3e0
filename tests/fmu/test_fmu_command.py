"""`slipmode fmu`, and libraries for other platforms."""

import ctypes
import importlib.util
import re
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_exchange import Master
from fmu_fixtures import VERSIONS, instance

from slipmode.__main__ import main
from slipmode.fmu.archive import binaries
from slipmode.fmu.archive import zig as zig_compiler
from slipmode.fmu.archive.binaries import TARGETS, platform_binary
from slipmode.runner import export_fmu, load_scene, run

ROOT = Path(__file__).parents[2]
DOUBLES = ctypes.POINTER(ctypes.c_double)
MAGIC = {"linux": b"\x7fELF", "windows": b"MZ", "darwin": b"\xcf\xfa\xed\xfe"}


@pytest.mark.parametrize("fmi", VERSIONS)
def test_the_command_writes_an_fmu(fmi, tmp_path, capsys):
    path = tmp_path / "one mode.fmu"
    assert main(["fmu", "one-mode", "-o", str(path), "--fmi", str(fmi)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == str(path)
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
    path = export_fmu(scene, tmp_path / "scene.fmu", headroom=1.0)
    shutil.unpack_archive(path, folder, format="zip")
    _, time, values = run(scene, tmp_path).read().channels["/modes"]
    with instance(folder, 3) as made:
        made.start()
        for start, end in pairwise(time):
            made.step(start, end - start)
        final = made.get("A_re", "A_im", "A_abs")
    np.testing.assert_allclose(final, values[-1], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["sweep", "beating", "one-mode"])
def test_explicit_euler_follows_at_the_declared_step(scene, tmp_path):
    """The simplest integrator that an importer has, in the transient that begins a scene."""
    path = export_fmu(scene, tmp_path / "scene.fmu", 2)
    folder = tmp_path / "scene"
    shutil.unpack_archive(path, folder, format="zip")
    step = float(fmpy.read_model_description(path).defaultExperiment.stepSize)
    with instance(folder, 2) as slave, instance(folder, 2, exchange=True) as made:
        Master(made).start()
        names = ("A_re", "A_im")
        states = np.empty(4 if scene == "one-mode" else 7)
        rates = np.empty_like(states)
        pointer = states.ctypes.data_as(DOUBLES), states.size
        made.fmu.getContinuousStates(*pointer)
        slave.start()
        apart, largest = 0.0, 0.0
        for k in range(round(200.0 / step)):
            made.fmu.getDerivatives(rates.ctypes.data_as(DOUBLES), rates.size)
            states += step * rates
            made.fmu.setTime((k + 1) * step)
            made.fmu.setContinuousStates(*pointer)
            slave.step(k * step, step)
            expected = slave.get(*names)
            apart = max(apart, np.abs(made.get(*names) - expected).max())
            largest = max(largest, np.abs(expected).max())
    assert largest > 0.5
    assert apart < 0.05 * largest


def start_of(path, name):
    (variable,) = (v for v in fmpy.read_model_description(path).modelVariables if v.name == name)
    return variable.start


def through(path, **inputs):
    """What an FMU says where inputs take it out of its table; None where they do not."""
    folder = path.with_suffix("")
    shutil.unpack_archive(path, folder, format="zip")
    with instance(folder, 2) as made:
        made.start(**inputs)
        try:
            made.step(0.0, 400.0)
        except fmpy.fmi1.FMICallException:
            return made.messages[-1][1]


@pytest.mark.slow
def test_an_fmu_for_larger_amplitudes_than_the_scene_s(tmp_path):
    """As the message says that those of a scene give where they end."""
    paths = {factor: tmp_path / f"{factor}.fmu" for factor in ("1", "2")}
    for factor, path in paths.items():
        arguments = ["fmu", "one-mode", "-o", str(path), "--fmi", "2"]
        assert main([*arguments, "--range", factor]) == 0
    force = 1.3 * float(start_of(paths["1"], "force_A"))
    said = through(paths["1"], force_A=force)
    assert "lower force_A, now" in said and "--range of slipmode fmu" in said
    assert through(paths["2"], force_A=force) is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("no-such-scene",), "'no-such-scene': no such scene file"),
        (("one-mode", "--range", "0.5"), "--range: must be a finite number >= 1, got 0.5"),
        (("one-mode", "--range", "nan"), "--range: must be a finite number >= 1, got nan"),
        (("one-mode", "--platforms", "vax"), "--platforms: vax must be one of x86_64-linux"),
        (("one-mode", "-o", "no/such/folder/x.fmu"), "no/such/folder/x.fmu"),
    ],
)
def test_what_is_refused_is_named(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["fmu", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"slipmode: {message}")


# Libraries for other platforms


class Zig:
    """In the place of subprocess.run: writes what was asked for, and remembers the commands."""

    def __init__(self):
        self.compiled, self.linked = {}, []

    def run(self, command, cwd, **options):
        command = list(command)
        target = Path(cwd) / command[command.index("-o") + 1]
        target.write_bytes(f"library number {len(self.linked)}".encode())
        if "-c" in command:
            (source,) = (Path(word) for word in command if word.endswith(".c"))
            self.compiled[source] = command
        else:
            self.linked.append(command)
        return subprocess.CompletedProcess(command, 0, "", "")


@pytest.fixture
def zig(tmp_path, monkeypatch):
    """A compiler that does nothing, and an empty cache."""
    made = Zig()
    monkeypatch.setenv("SLIPMODE_CACHE", str(tmp_path / "cache"))
    for module in ("binaries", "zig"):
        monkeypatch.setattr(f"slipmode.fmu.archive.{module}.extra", lambda module, name: fmpy)
    monkeypatch.setattr("slipmode.fmu.archive.zig.version", lambda name: "1.0")
    monkeypatch.setattr("slipmode.fmu.archive.zig.subprocess.run", made.run)
    return made


def in_cmake(pattern):
    """Words of the one place in CMakeLists.txt, comments apart, that fits."""
    text = re.sub(r"#.*", "", (ROOT / "CMakeLists.txt").read_text())
    (words,) = re.findall(pattern, text)
    return set(words.split())


def effective(options, kind):
    """The last of the options of a kind, which is the one that counts."""
    return [option for option in options if option.startswith(kind)][-1]


@pytest.mark.skipif(not (ROOT / "CMakeLists.txt").exists(), reason="needs the checkout")
def test_other_platforms_are_compiled_as_cmake_compiles_this_one():
    common = in_cmake(r"add_compile_options\((-O3 [^)]*)\)") - {"-Wall", "-Wextra"}
    common |= in_cmake(r"check_c_compiler_flag\((\S+) HAS_OPENMP_SIMD\)")
    assert set(zig_compiler.OPTIONS) == common
    face = r"set_source_files_properties\(\$\{fmu_sources\} PROPERTIES COMPILE_OPTIONS ([^)]*)\)"
    assert set(zig_compiler.FACE_OPTIONS) == in_cmake(face)
    assert set(zig_compiler.DEFINITIONS) - {"SM_HIDDEN"} == in_cmake(
        r"add_compile_definitions\((SM_OPENMP\w+)\)"
    )


def test_the_face_is_compiled_without_contraction_and_the_core_with(zig):
    platform_binary("aarch64-linux")
    sources = {path for path in binaries.source_files().values() if path.suffix == ".c"}
    assert set(zig.compiled) == sources
    found = {path: effective(command, "-ffp-contract=") for path, command in zig.compiled.items()}
    assert {path for path, option in found.items() if option == "-ffp-contract=off"} == {
        path for path in sources if path.is_relative_to(zig_compiler.INCLUDE_FOLDERS[0])
    }
    assert set(found.values()) == {"-ffp-contract=off", "-ffp-contract=fast"}
    (link,) = zig.linked
    assert {f"{path.stem}.o" for path in sources} <= set(link)


def test_a_library_is_compiled_once(zig):
    assert platform_binary("aarch64-linux") == platform_binary("aarch64-linux")
    assert len(zig.linked) == 1
    platform_binary("x86_64-linux")
    assert len(zig.linked) == 2


@pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b[:-3], lambda b: b[:-1] + b"?"])
def test_a_damaged_library_is_compiled_again(zig, tmp_path, damage):
    platform_binary("aarch64-linux")
    (kept,) = (tmp_path / "cache").iterdir()
    whole = kept.read_bytes()
    kept.write_bytes(damage(whole))
    assert platform_binary("aarch64-linux") == b"library number 1"
    assert platform_binary("aarch64-linux") == b"library number 1"
    assert len(zig.linked) == 2


def test_a_library_is_kept_whole_or_not_at_all(zig, tmp_path, monkeypatch):
    def cut_short(self, target):
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr(Path, "replace", cut_short)
    assert platform_binary("aarch64-linux") == b"library number 0"
    assert list((tmp_path / "cache").iterdir()) == []


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
