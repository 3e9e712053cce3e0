"""Runs that end early: readable, and they say why."""

import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from runs import LARGE_RANGE, SMALL_RANGE, changed, column, verified

from slipmode import runner
from slipmode.__main__ import main
from slipmode.fmu import Component
from slipmode.rom import SlipmodeError
from slipmode.runner.recording.channels import Event
from slipmode.runner.recording.record import McapSink, interrupts_held_back
from slipmode.runner.transients import hybrid


def run_to_failure(scene, folder, error):
    with pytest.raises(error) as failure:
        runner.run(scene, folder)
    return failure.value, runner.read(folder / "test.mcap")


def test_an_interrupted_run_is_readable_and_says_so(tmp_path, monkeypatch):
    taken = []
    run = Component.run

    def interrupted(self, durations, inputs):
        if taken:
            raise KeyboardInterrupt
        if len(durations) < 700:  # not the dry run of the plan, which takes all steps at once
            taken.extend(durations)
        return run(self, durations, inputs)

    monkeypatch.setattr(Component, "run", interrupted)
    monkeypatch.setattr("slipmode.runner.transients.passes._STEPS_PER_BLOCK", 256)
    _, data = run_to_failure(changed(LARGE_RANGE), tmp_path, KeyboardInterrupt)
    assert (data.damage, data.complete) == ("", False)
    assert data.channels["/modes"][1].size == len(taken) + 1 < 700
    assert data.events[-1] == Event(sum(taken), "error", "interrupted by the user")


@pytest.mark.parametrize("topic", ["/modes", "/contact/0"])
def test_ctrl_c_in_the_middle_of_a_batch_waits_for_its_end(tmp_path, monkeypatch, topic):
    write = McapSink.write

    def interrupted(self, written, time, values):
        if written == topic and len(time) > 1:
            signal.raise_signal(signal.SIGINT)
        write(self, written, time, values)

    monkeypatch.setattr(McapSink, "write", interrupted)
    handler = signal.getsignal(signal.SIGINT)
    _, data = run_to_failure(changed(), tmp_path, KeyboardInterrupt)
    assert data.damage == ""
    assert data.complete == (topic == "/contact/0")  # whose batch is the last of the run
    sizes = {name: time.size for name, (_, time, _) in data.channels.items()}
    assert sizes["/modes"] == sizes["/forcing"] == sizes["/energy"] > 1
    assert sizes["/contact/0"] == sizes["/contact/1"]
    assert signal.getsignal(signal.SIGINT) is handler


def test_a_second_ctrl_c_does_not_wait():
    with pytest.raises(KeyboardInterrupt), interrupts_held_back():
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


@pytest.mark.quick
def test_a_run_that_leaves_its_table_is_readable_and_says_so(tmp_path):
    error, data = run_to_failure(changed(SMALL_RANGE), tmp_path, SlipmodeError)
    assert "amplitude |A| leaves the friction table, whose range is 2.5" in str(error)
    assert (data.damage, data.complete) == ("", False)
    assert data.events[-1].message == str(error)
    assert data.events[-1].time == data.channels["/modes"][1][-1] < 700.0
    assert 2.0 < column(data, "/modes", "A_abs")[-1] <= 2.5


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (SlipmodeError("contact motion: not a number"), "contact motion: not a number"),
        (MemoryError("no room for it"), "MemoryError: no room for it"),
        (RuntimeError("two\nlines"), "RuntimeError: two lines"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_run_whose_reconstruction_fails_is_readable_and_says_so(
    tmp_path, monkeypatch, error, words
):
    monkeypatch.setattr("slipmode.runner.transients.passes.SAMPLES_PER_BATCH", 64)
    reconstruct, batches = hybrid.reconstruct, []

    def failing(*arguments):
        if batches:
            raise error
        batches.append(reconstruct(*arguments))
        return batches[-1]

    monkeypatch.setattr(hybrid, "reconstruct", failing)
    raised, data = run_to_failure(changed(), tmp_path, type(error))
    assert raised is error
    assert (data.damage, data.complete) == ("", False)
    assert (data.events[-1].level, data.events[-1].message) == ("error", words)
    assert data.channels["/modes"][1][-1] == data.events[-1].time == 700.0
    np.testing.assert_array_equal(column(data, "/contact/0", "x"), batches[0].displacement[:, 0])


def test_a_run_that_does_not_begin_says_so(tmp_path, monkeypatch):
    def refused(self, **inputs):
        raise SlipmodeError("frequency_A: must be > 0")

    scene = changed(LARGE_RANGE)
    runner.run(scene, tmp_path)  # the table is there
    monkeypatch.setattr(Component, "set_inputs", refused)
    _, data = run_to_failure(scene, tmp_path, SlipmodeError)
    assert not data.complete
    assert data.events == [Event(0.0, "error", "frequency_A: must be > 0")]


@pytest.mark.parametrize("error", [SlipmodeError("contact motion: no"), MemoryError()])
def test_the_command_says_in_one_line_why_the_reconstruction_failed(
    tmp_path, monkeypatch, capsys, error
):
    def failing(*arguments):
        raise error

    monkeypatch.setattr(hybrid, "reconstruct", failing)
    assert main(["run", "one-mode", "-o", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"slipmode: {error if str(error) else 'out of memory'}"
    assert not runner.read(tmp_path / "one-mode.mcap").complete
    assert verified(tmp_path / "one-mode.rrd")


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
def test_places_that_cannot_be_written(tmp_path, prepare, at_fault):
    prepare(tmp_path)
    with pytest.raises((SlipmodeError, OSError)) as failure:
        runner.run(changed(), tmp_path / "logs")
    assert str(tmp_path / Path(at_fault)) in str(failure.value)


@pytest.mark.parametrize("kept", [".mcap", ".rrd"])
def test_a_second_run_into_a_recording_that_is_being_written_is_refused(
    tmp_path, monkeypatch, kept
):
    scene = changed(
        ("mcap = true\nrerun = false\n", f"mcap = {kept == '.mcap'}\nrerun = true\n".lower())
    )
    refusals = []
    run = Component.run

    def beside(self, durations, inputs):
        if len(durations) < 700 and not refusals:  # not the dry run of the plan
            refusals.append("")  # the run beside does the same
            with pytest.raises(SlipmodeError) as refused:
                runner.run(scene, tmp_path)
            refusals.append(str(refused.value))
        return run(self, durations, inputs)

    monkeypatch.setattr(Component, "run", beside)
    monkeypatch.setattr("slipmode.runner.transients.passes._STEPS_PER_BLOCK", 256)
    runner.run(scene, tmp_path)
    assert refusals[1] == (
        f"{tmp_path / 'test'}{kept}: another run is writing this file; wait until it ends, or "
        "write to another folder"
    )
    assert verified(tmp_path / "test.rrd")
    if kept == ".mcap":
        assert runner.read(tmp_path / "test.mcap").complete
    runner.run(scene, tmp_path)  # no lock is left behind


def test_a_run_that_is_killed_leaves_no_lock(tmp_path):
    path = tmp_path / "test.mcap"
    code = (
        "import os, signal, sys; from pathlib import Path\n"
        "from slipmode.runner.recording.record import create_file\n"
        "file = create_file(Path(sys.argv[1])); file.write(b'half'); file.flush()\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-P", "-c", code, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"half"
    runner.run(changed(), tmp_path)
    assert runner.read(path).complete
