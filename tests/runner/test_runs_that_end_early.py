"""Runs that end early leave a readable recording that says why, and no lock."""

import resource
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from dataclasses import replace

import pytest
from runs import SMALL_RANGE, changed, column, replaced

from slipmode import runner
from slipmode.rom import SlipmodeError
from slipmode.runner import load_scene, shipped_scenes

SLIPMODE = shutil.which("slipmode", path=sysconfig.get_path("scripts"))


def run_to_failure(scene, folder, error):
    with pytest.raises(error) as failure:
        runner.run(scene, folder)
    return failure.value, runner.read(folder / "test.mcap")


@pytest.mark.quick
def test_a_run_that_leaves_its_table_is_readable_and_says_so(tmp_path):
    error, data = run_to_failure(changed(SMALL_RANGE), tmp_path, SlipmodeError)
    assert "amplitude |A| leaves the friction table, whose range is 2.5" in str(error)
    assert (data.damage, data.complete) == ("", False)
    assert data.events[-1].message == str(error)
    assert data.events[-1].time == data.channels["/modes"][1][-1] < 700.0
    assert 2.0 < column(data, "/modes", "A_abs")[-1] <= 2.5


def test_a_full_disk_keeps_what_was_written(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    runner.run(changed(), tmp_path)  # the cache is not what the disk has no room for
    long = changed(("duration = 700.0", "duration = 30000.0"))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_500_000, hard))
    try:
        error, data = run_to_failure(long, tmp_path, OSError)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert error.filename == str(tmp_path / "test.mcap")
    assert not data.complete
    assert 5000 < data.channels["/modes"][1].size < 30000
    assert runner.run(changed(), tmp_path).read().complete


def occupied(folder):
    (folder / "logs").write_text("a file, not a folder")


def taken_by_a_folder(folder):
    (folder / "logs" / "test.mcap").mkdir(parents=True)


def full(folder):
    (folder / "logs").mkdir()
    (folder / "logs" / "test.mcap").symlink_to("/dev/full")


@pytest.mark.parametrize(
    ("prepare", "at_fault"),
    [(occupied, "logs"), (taken_by_a_folder, "logs/test.mcap"), (full, "logs/test.mcap")],
)
def test_places_that_cannot_be_written_are_named(tmp_path, prepare, at_fault):
    prepare(tmp_path)
    with pytest.raises((SlipmodeError, OSError)) as failure:
        runner.run(changed(), tmp_path / "logs")
    assert str(tmp_path / at_fault) in str(failure.value)


@pytest.fixture(name="long_run")
def started_long_run(tmp_path):
    """A run of many minutes in another process, some megabytes into its recording."""
    text = replaced(
        shipped_scenes()["one-mode"].read_text(),
        ("duration = 800.0", "duration = 20000.0"),
        ("[750.0, 800.0]", "[100.0, 20000.0]"),
        ("samples_per_period = 128", "samples_per_period = 4096\n[log]\nrerun = false"),
    )
    (tmp_path / "long.toml").write_text(text)
    recording = tmp_path / "long.mcap"
    command = [SLIPMODE, "run", tmp_path / "long.toml", "-o", tmp_path]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as running:
        deadline = time.monotonic() + 180.0
        while not (recording.exists() and recording.stat().st_size > 4_000_000):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        try:
            yield running, recording
        finally:
            running.kill()


def test_ctrl_c_ends_a_run_with_a_readable_recording(long_run):
    running, recording = long_run
    beside = f"{recording}: another run is writing this file; wait until it ends"
    with pytest.raises(SlipmodeError, match=beside):
        runner.run(load_scene(recording.with_suffix(".toml")), recording.parent)
    running.send_signal(signal.SIGINT)
    output, errors = running.communicate(timeout=180)
    assert (running.returncode, output) == (130, "")
    assert errors.splitlines()[-1].startswith("slipmode: interrupted")
    assert "Traceback" not in errors
    data = runner.read(recording)
    assert (data.damage, data.complete) == ("", False)
    assert data.events[-1].message == "interrupted by the user"
    sizes = [data.channels[f"/contact/{i}"][1].size for i in range(2)]
    assert sizes[0] == sizes[1] > 10_000


def test_a_killed_run_is_recovered_and_leaves_no_lock(long_run):
    running, recording = long_run
    running.kill()
    running.wait()
    kept = runner.recover(recording, recording.with_name("whole.mcap")).kept
    assert kept > 10_000
    whole = runner.read(recording.with_name("whole.mcap"))
    assert whole.channels["/contact/0"][1].size > 1000
    runner.run(replace(changed(), name="long"), recording.parent)
    assert runner.read(recording).complete


def test_a_command_is_interrupted_in_one_line_while_it_imports():
    command = [sys.executable, "-X", "importtime", SLIPMODE, "scenes"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
        for line in running.stderr:
            if line.split()[-1] == "numpy.version":
                running.send_signal(signal.SIGINT)
                break
        printed = [line for line in running.stderr if not line.startswith("import time:")]
    assert running.returncode == 130
    assert printed == ["slipmode: interrupted\n"]
