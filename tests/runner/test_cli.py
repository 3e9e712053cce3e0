"""The command line: its output, its exit status, and one line for everything it refuses."""

import re
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from importlib.metadata import version

import numpy as np
import pytest

from slipmode import fmu, rom, runner
from slipmode.rom import two_mass
from slipmode.runner import load_scene, read, shipped_scenes
from slipmode.runner.cli import _parser, main

SLIPMODE = shutil.which("slipmode", path=sysconfig.get_path("scripts"))
(COMMANDS,) = (action.choices for action in _parser()._actions if action.dest == "==SUPPRESS==")


def slipmode(*arguments, **options):
    return subprocess.run([SLIPMODE, *arguments], capture_output=True, text=True, **options)


def refusal(capsys, *arguments):
    """The one line that a command leaves on standard error when it fails."""
    assert main([str(argument) for argument in arguments]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    return line


@pytest.fixture(scope="module")
def one_mode(tmp_path_factory):
    """A recording of a shipped scene, and what the command printed."""
    folder = tmp_path_factory.mktemp("logs")
    return folder, slipmode("run", "one-mode", "-o", folder)


# Commands


def test_run_writes_the_recordings_that_it_names(one_mode):
    folder, done = one_mode
    assert done.returncode == 0
    assert not re.sub(r"^friction table: .*/s\]$|\s", "", done.stderr, flags=re.M)  # if it is slow
    assert done.stdout.startswith("One mode near resonance: 800 s\n")
    for name in ("one-mode.mcap", "one-mode.rrd"):
        assert f"  {folder / name}  (" in done.stdout
    assert read(folder / "one-mode.mcap").complete


def test_a_run_ends_with_a_command_that_a_shell_can_repeat(one_mode, tmp_path, capsys):
    copy = tmp_path / "my scene.toml"
    copy.write_text(shipped_scenes()["one-mode"].read_text())
    assert main(["run", str(copy), "-o", str(tmp_path / "my logs")]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    heading, *words = shlex.split(last)
    assert (heading, words[1:]) == ("next:", ["replay", str(tmp_path / "my logs/my scene.mcap")])


def test_replay_saves_what_the_run_recorded(one_mode, tmp_path):
    saved = tmp_path / "saved.rrd"
    done = slipmode("replay", one_mode[0] / "one-mode.mcap", "--save", saved)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{saved}\nnext:  rerun {saved}\n"
    assert saved.stat().st_size > 100_000


def test_plan_gives_a_reason_for_every_decision(capsys):
    assert main(["plan", "one-mode"]) == 0
    lines = capsys.readouterr().out.splitlines()
    subjects = {line.split("  ")[0] for line in lines}
    assert {"mode A", "friction table", "contact motion", "recording"} <= subjects
    assert all(len(line.split("  ")) >= 3 for line in lines[:-1])
    assert lines[-1].startswith("next:") and lines[-1].endswith(" run one-mode")


def test_scenes_lists_every_shipped_scene_with_its_title(capsys):
    assert main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    listed = dict(line.split(maxsplit=1) for line in lines[:-1])
    assert listed == {name: load_scene(name).title for name in shipped_scenes()}


def test_the_file_of_a_shipped_scene_can_be_copied(capsys, tmp_path):
    assert main(["scenes", "--path", "two-mode"]) == 0
    copy = shutil.copy(capsys.readouterr().out.strip(), tmp_path / "mine.toml")
    assert main(["plan", str(copy)]) == 0


@pytest.mark.parametrize("command", [(), *((command,) for command in COMMANDS)])
def test_help_ends_with_an_example_that_parses(command, capsys):
    with pytest.raises(SystemExit) as end:
        main([*command, "--help"])
    assert end.value.code == 0
    help_text = capsys.readouterr().out
    example = " ".join(help_text[help_text.rindex("example: ") :].split())
    assert example.startswith(" ".join(("example: slipmode", *command)))
    for part in example.removeprefix("example: ").split(" && "):
        if part.startswith("slipmode"):
            _parser().parse_args(shlex.split(part)[1:])


def test_the_help_lists_every_command_of_each_task_in_a_line(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 79  # measured: 79
    assert lines.index("run and look:") < lines.index("analyse:") < lines.index("export:")
    listed = [line.split(maxsplit=1) for line in lines if line.startswith("    ")]
    assert sorted(name for name, _ in listed) == sorted(COMMANDS)
    assert all(len(summary) > 20 for _, summary in listed)


def test_the_version_is_printed(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"slipmode {version('slipmode')}\n"
    assert {package.__version__ for package in (rom, fmu, runner)} == {version("slipmode")}


@pytest.mark.parametrize(
    "arguments", [(), ("frobnicate",), ("run",), ("run", "two-mode", "--speed", "9")]
)
def test_wrong_usage_ends_with_status_2(arguments, capsys):
    with pytest.raises(SystemExit) as end:
        main([*arguments])
    assert end.value.code == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err[:15]) == ("", "usage: slipmode")


@pytest.mark.parametrize(("arguments", "status"), [(("run",), 2), (("run", "no-such-scene"), 1)])
def test_the_process_ends_with_the_status(arguments, status):
    done = slipmode(*arguments)
    assert (done.returncode, done.stdout) == (status, "")
    assert done.stderr
    assert "Traceback" not in done.stderr


def test_a_refusal_names_what_there_is(capsys):
    line = refusal(capsys, "run", "no-such-scene")
    assert line.startswith("slipmode: 'no-such-scene': no such scene file; shipped scenes:")


# Refusals


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("damping = 0.01", "dampign = 0.01", "structure.dampign: .* did you mean damping?"),
        ("[forcing.A]", "[forcign.A]", "forcign: .* did you mean forcing?"),
        ("[modes]", "[modes", "TOML syntax: "),
        ("limit = 2.0", "limit = -2.0", "friction.limit: must be >= 0"),
        ("limit = 2.0", "limit = nan", "friction.limit: must be >= 0.*NaN"),
        ("limit = 2.0", "limit = [2.0, 2.0, 2.0]", "friction.limit: .*2"),
        ("alpha = 0.02", "alpha = 0", "friction.alpha: must be > 0"),
        ("frequency = 1.65", "frequency = 0.0", "forcing.B.frequency: must be > 0"),
        ("frequency = 1.65", "frequency = 0.98", "forcing.A.frequency, forcing.B.frequency: must"),
        ("amplitude = 0.15", "amplitude = -0.15", "forcing.A.amplitude: must be >= 0"),
        ("amplitude = 0.15", 'amplitude = "much"', "forcing.A.amplitude: must be a number"),
        ("dof = 1", "dof = 4", "forcing.B.dof: must be 0 to 3, got 4"),
        ("dof = 1", "dof = 0", "forcing.B: this force does no work on mode B"),
        ("dof = 1", "vector = [1.0]", "forcing.B.vector: must have 4 numbers"),
        ("B = 1\n", "B = 0\n", "modes.B: must be another mode than A"),
        ("B = 1\n", "B = 7\n", "modes: must be 0 to 1"),
        ("elastic = [0, 1]", "elastic = [0, 9]", "output.elastic: .* 9 .* 0 to 3"),
        ("[1400.0, 1450.0]", "[1400.0, 1600.0]", r"contact\[0\].window: must be"),
        ("step = 1.0", "step = 0.0", "run.step: must be > 0"),
        ("step = 1.0", "step = 1e-9", "run.step: must be at least run.duration / 1e7"),
        ("duration = 1500.0", "duration = inf", "run.duration: must be > 0"),
        ('model = "two-mass"', 'matrices = "no.npz"', "structure.matrices: no such file"),
    ],
)
def test_bad_scenes_are_refused_in_one_line_that_names_the_key(
    tmp_path, capsys, old, new, complaint
):
    text = shipped_scenes()["two-mode"].read_text()
    assert old in text
    scene = tmp_path / "scene.toml"
    scene.write_text(text.replace(old, new, 1))
    line = refusal(capsys, "run", scene, "-o", tmp_path / "logs")
    assert re.search(complaint, line), line
    assert not (tmp_path / "logs").exists()


def matrices(**changes):
    structure = two_mass()
    return {
        "mass": structure.mass,
        "stiffness": structure.stiffness,
        "contact": np.array([2, 3]),
    } | changes


def skewed(matrix):
    return matrix + np.triu(np.ones_like(matrix), 1)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"stiffness": skewed(two_mass().stiffness)}, "stiffness: .*symmetric"),
        ({"mass": skewed(two_mass().mass)}, "mass: .*symmetric"),
        ({"mass": -two_mass().mass}, "mass"),
        ({"stiffness": np.full((4, 4), np.nan)}, "stiffness: .*finite"),
        ({"stiffness": np.eye(3)}, "stiffness"),
        ({"contact": np.array([2, 9])}, "contact: .*9"),
        ({"contact": np.array([2, 2])}, "contact"),
    ],
)
def test_bad_matrices_are_refused_in_one_line_that_names_the_matrix(
    tmp_path, capsys, changes, complaint
):
    np.savez(tmp_path / "beam.npz", **matrices(**changes))
    text = shipped_scenes()["one-mode"].read_text()
    scene = tmp_path / "scene.toml"
    scene.write_text(text.replace('model = "two-mass"', 'matrices = "beam.npz"'))
    line = refusal(capsys, "plan", scene)
    assert re.search(complaint, line), line


def test_matrices_that_are_right_are_planned(tmp_path, capsys):
    np.savez(tmp_path / "beam.npz", **matrices())
    text = shipped_scenes()["one-mode"].read_text()
    (tmp_path / "scene.toml").write_text(
        text.replace('model = "two-mass"', 'matrices = "beam.npz"')
    )
    assert main(["plan", str(tmp_path / "scene.toml")]) == 0
    assert capsys.readouterr().err == ""


def missing(folder, recording):
    return ("replay", folder / "missing.mcap"), "No such file"


def cut_short_in_the_header(folder, recording):
    (folder / "cut.mcap").write_bytes(recording.read_bytes()[:100])
    return ("replay", folder / "cut.mcap", "--save", folder / "out.rrd"), "no samples are left"


def not_a_recording(folder, recording):
    (folder / "text.mcap").write_text("text")
    return ("replay", folder / "text.mcap"), "not an MCAP file"


def folder_for_a_recording(folder, recording):
    return ("replay", folder), "Is a directory"


def folder_for_a_saved_file(folder, recording):
    return ("replay", recording, "--save", folder), "is a directory"


def missing_folder_for_a_saved_file(folder, recording):
    return ("replay", recording, "--save", folder / "no" / "out.rrd"), "No such file"


def folder_for_a_scene(folder, recording):
    return ("run", folder), "no such scene file"


def file_for_the_output_folder(folder, recording):
    (folder / "logs").touch()
    return ("run", "one-mode", "-o", folder / "logs"), "File exists"


def folder_for_an_output_file(folder, recording):
    (folder / "one-mode.mcap").mkdir()
    return ("run", "one-mode", "-o", folder), "one-mode.mcap: is a directory"


def unknown_shipped_scene(folder, recording):
    return ("scenes", "--path", f"{folder}"), "no such scene; scenes: beating"


@pytest.mark.parametrize(
    "prepare",
    [
        missing,
        cut_short_in_the_header,
        not_a_recording,
        folder_for_a_recording,
        folder_for_a_saved_file,
        missing_folder_for_a_saved_file,
        folder_for_a_scene,
        file_for_the_output_folder,
        folder_for_an_output_file,
        unknown_shipped_scene,
    ],
    ids=lambda prepare: prepare.__name__,
)
def test_bad_files_are_refused_in_one_line_that_names_the_file(
    one_mode, tmp_path, capsys, prepare
):
    arguments, complaint = prepare(tmp_path, one_mode[0] / "one-mode.mcap")
    line = refusal(capsys, *arguments)
    assert complaint in line
    assert str(tmp_path) in line


# Ctrl-C


def test_ctrl_c_ends_a_long_run_with_a_readable_recording(tmp_path):
    text = shipped_scenes()["one-mode"].read_text()
    for old, new in [
        ("duration = 800.0", "duration = 20000.0"),
        ("[750.0, 800.0]", "[100.0, 20000.0]"),
        ("samples_per_period = 128", "samples_per_period = 4096\n[log]\nrerun = false"),
    ]:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "long.toml").write_text(text)
    recording = tmp_path / "long.mcap"
    command = [SLIPMODE, "run", tmp_path / "long.toml", "-o", tmp_path]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as running:
        wait_for(lambda: recording.exists() and recording.stat().st_size > 4_000_000)
        running.send_signal(signal.SIGINT)
        output, errors = running.communicate(timeout=90)
    assert (running.returncode, output) == (130, "")
    assert errors.splitlines()[-1].startswith("slipmode: interrupted")
    assert "Traceback" not in errors
    data = read(recording)
    assert (data.damage, data.complete) == ("", False)
    assert data.events[-1].message == "interrupted by the user"
    sizes = [data.channels[f"/contact/{i}"][1].size for i in range(2)]
    assert sizes[0] == sizes[1] > 10_000


def wait_for(condition, timeout=90.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize("reached", ["numpy.version", "scipy.sparse", "slipmode.rom.errors"])
def test_a_command_is_interrupted_in_one_line_while_it_imports(reached):
    command = [sys.executable, "-X", "importtime", SLIPMODE, "scenes"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
        for line in running.stderr:
            if line.split()[-1] == reached:
                running.send_signal(signal.SIGINT)
                break
        printed = [line for line in running.stderr if not line.startswith("import time:")]
    assert running.returncode == 130
    assert printed == ["slipmode: interrupted\n"]
