"""The command line: its output, its exit status, and one line for everything it refuses."""

import logging
import re
import shlex
import shutil
import subprocess
import sysconfig
from importlib.metadata import version

import pytest

from slipmode import fmu, rom, runner
from slipmode.__main__ import main
from slipmode.runner import load_scene, read, shipped_scenes

SLIPMODE = shutil.which("slipmode", path=sysconfig.get_path("scripts"))
PYTHON = re.compile(r"rom\.\w|fmu\.\w|[Tt]abulate")  # names that the command line does not have


def refusal(capsys, *arguments):
    """The one line that a command leaves on standard error when it fails."""
    assert main([str(argument) for argument in arguments]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    assert line.startswith("slipmode: ")
    return line.removeprefix("slipmode: ")


@pytest.fixture(scope="module")
def one_mode(tmp_path_factory):
    """The folder of a recording of a shipped scene, and what the command printed."""
    folder = tmp_path_factory.mktemp("logs")
    command = [SLIPMODE, "run", "one-mode", "-o", folder]
    return folder, subprocess.run(command, capture_output=True, text=True)


# Commands


def test_run_writes_the_recordings_that_it_names(one_mode):
    folder, done = one_mode
    assert done.returncode == 0
    assert not re.sub(r"^friction table: .*/s\]$|\s", "", done.stderr, flags=re.M)  # if it is slow
    assert done.stdout.startswith("One mode near resonance: 800 s\n")
    for name in ("one-mode.mcap", "one-mode.rrd"):
        assert f"  {folder / name}  (" in done.stdout
    assert read(folder / "one-mode.mcap").complete
    heading, *words = shlex.split(done.stdout.splitlines()[-1])
    assert (heading, words[1:]) == ("next:", ["replay", str(folder / "one-mode.mcap")])


def test_replay_saves_what_the_run_recorded(one_mode, tmp_path, capsys):
    saved = tmp_path / "saved.rrd"
    assert main(["replay", str(one_mode[0] / "one-mode.mcap"), "--save", str(saved)]) == 0
    assert capsys.readouterr().out == f"{saved}\nnext:  rerun {saved}\n"
    assert saved.stat().st_size > 100_000


def test_scenes_lists_the_shipped_scenes_and_where_they_are(capsys, tmp_path):
    assert main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    listed = dict(line.split(maxsplit=1) for line in lines[:-1])
    assert listed == {name: load_scene(name).title for name in shipped_scenes()}
    assert main(["scenes", "--path", "two-mode"]) == 0
    copy = shutil.copy(capsys.readouterr().out.strip(), tmp_path / "mine.toml")
    assert main(["plan", str(copy)]) == 0


def test_the_version_is_printed(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"slipmode {version('slipmode')}\n"
    assert {package.__version__ for package in (rom, fmu, runner)} == {version("slipmode")}


@pytest.mark.parametrize("arguments", [(), ("frobnicate",), ("run", "two-mode", "--speed", "9")])
def test_wrong_usage_ends_with_status_2(arguments, capsys):
    with pytest.raises(SystemExit) as end:
        main([*arguments])
    assert end.value.code == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err[:15]) == ("", "usage: slipmode")


def test_the_process_ends_with_the_status():
    done = subprocess.run([SLIPMODE, "run", "no-such-scene"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("slipmode: 'no-such-scene': no such scene file; shipped scenes:")


# Diagnostics


def test_a_run_prints_each_warning_of_its_plan_once_before_it_runs(tmp_path, capsys):
    strained = load_scene("one-mode").text.replace("alpha = 0.02", "alpha = 20.0")
    scene = tmp_path / "strained.toml"
    scene.write_text(strained.replace("rerun = true", "rerun = false"), encoding="utf-8")
    assert main(["plan", str(scene)]) == 0
    planned = [
        line.removeprefix("warning: ")
        for line in capsys.readouterr().out.splitlines()
        if line.startswith("warning: ")
    ]
    assert planned
    for _ in range(2):  # no handler is left behind
        handlers = list(logging.getLogger("slipmode").handlers)
        assert main(["run", str(scene), "-o", str(tmp_path)]) == 0
        said = capsys.readouterr().err.splitlines()
        assert said == [f"slipmode: warning: {line}" for line in planned]
        assert logging.getLogger("slipmode").handlers == handlers


# Refusals: of options in their words, of files


@pytest.mark.parametrize(
    ("command", "begins"),
    [
        ("curve --vary force", "--span: is missing; give the first and last value of force"),
        ("curve --vary frequency_A --span 0.1 1", "--span: must be 0.62"),
        ("design --mode B", "--mode: must be one that the scene forces, A"),
        ("fmu --range 0.5", "--range: must be a finite number >= 1"),
        ("diameters", "structure.sectors: is missing: nodal diameters are those of a bladed"),
    ],
)
def test_a_refusal_names_the_option_and_no_function(command, begins, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    name, *options = command.split()
    assert main([name, "one-mode", *options, "-o", str(tmp_path / "out")]) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"slipmode: {begins}")
    assert not PYTHON.search(line)


@pytest.mark.parametrize(
    ("command", "complaint"),
    [
        ("replay {folder}/cut.mcap --save {folder}/out.rrd", "no samples are left"),
        ("replay {recording} --save {folder}", "is a directory"),
        ("run one-mode -o {folder}/text.mcap", "File exists"),
        ("fmu one-mode -o {folder}/no/x.fmu", "no/x.fmu: "),
        ("scenes --path {folder}", "no such scene; scenes: beating"),
    ],
)
def test_bad_files_are_refused_by_their_name(one_mode, tmp_path, capsys, command, complaint):
    recording = one_mode[0] / "one-mode.mcap"
    (tmp_path / "cut.mcap").write_bytes(recording.read_bytes()[:100])
    (tmp_path / "text.mcap").write_text("text")
    line = refusal(capsys, *command.format(folder=tmp_path, recording=recording).split())
    assert complaint in line
    assert str(tmp_path) in line


def test_a_refused_scene_writes_nothing(tmp_path, capsys):
    text = shipped_scenes()["two-mode"].read_text()
    scene = tmp_path / "scene.toml"
    scene.write_text(text.replace("limit = 2.0", "limit = -2.0"))
    line = refusal(capsys, "run", scene, "-o", tmp_path / "logs")
    assert "scene.toml: friction.limit: must be >= 0, got -2.0" in line
    assert not (tmp_path / "logs").exists()
