"""An .rrd file, which Rerun opens when a run is under way, holds all of it."""

import subprocess
import sys

import numpy as np
import pytest
from rrd import RERUN, verified

from slipmode.rom import SlipmodeError
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header
from slipmode.runner.view import rerun_file
from slipmode.runner.view.rerun_file import RerunFile
from slipmode.runner.view.rerun_sink import RerunSink

HEADER = Header(title="Run", scene_text='title = "Run"\n')
CHANNELS = [channels.modes(), channels.contact(0)]

WATCHED_RUN = """
import sys
from slipmode import runner

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "rerun":
            print(len(runner.read(sys.argv[1] + "/one-mode.mcap").channels["/modes"][1]))

sys.meta_path.insert(0, Watch())
runner.run("one-mode", sys.argv[1])
"""


def record(kind, path):
    with kind(path, HEADER, CHANNELS) as sink:
        sink.event(0.0, "info", "started")
        time, values = np.array([0.0, 1.0]), np.ones((2, 6))
        sink.write("/modes", time, values)
        time += 2.0  # what was written stays as it was
        sink.write("/modes", time, 3.0 * values)
        values[:] = np.nan
        sink.write("/contact/0", [0.0, 1.0], [[0.15, 0.0, -2.0], [-0.1, 0.0, 1.0]])
        sink.event(3.0, "warning", "finished")
    sink.close()
    return path


def test_rerun_is_imported_once_samples_are_on_disk(tmp_path):
    command = [sys.executable, "-P", "-c", WATCHED_RUN, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 0
    assert verified(tmp_path / "one-mode.rrd")


@pytest.mark.parametrize("seconds", [0.0, 1e9])  # opened by the first write, by closing
def test_the_file_is_that_of_a_sink(tmp_path, monkeypatch, seconds):
    monkeypatch.setattr(rerun_file, "LATE_SECONDS", seconds)
    late = record(RerunFile, tmp_path / "late.rrd")
    at_once = record(RerunSink, tmp_path / "at_once.rrd")
    assert verified(late)
    compared = subprocess.run(
        [RERUN, "rrd", "compare", "--unordered", late, at_once], capture_output=True, text=True
    )
    assert compared.returncode == 0, compared.stderr


def test_paths_that_cannot_be_written_are_refused_at_once(tmp_path):
    with pytest.raises(SlipmodeError, match="is a directory"):
        RerunFile(tmp_path, HEADER, CHANNELS)
    with pytest.raises(FileNotFoundError):
        RerunFile(tmp_path / "missing" / "run.rrd", HEADER, CHANNELS)


def test_what_rerun_cannot_write_is_an_error_when_it_is_opened():
    sink = RerunFile("/dev/full", HEADER, CHANNELS)
    with pytest.raises(OSError, match="/dev/full"):
        sink.close()
