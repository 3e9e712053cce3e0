"""A run shown while it is recorded: a server without a window keeps what a viewer would get."""

import os
import re
import signal
import socket
import subprocess
import time
from contextlib import suppress

import numpy as np
import pytest
import rerun as rr
from recordings import CHANNELS, HEADER, samples
from rerun.experimental import ViewerClient
from rrd import RERUN

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import read
from slipmode.runner.recording.record import McapSink, Recorder
from slipmode.runner.view import viewer
from slipmode.runner.view.rerun_sink import RerunSink
from slipmode.runner.view.viewer import Viewer, find_viewer


class Server:
    """`rerun --serve-grpc`, which writes what arrives to an .rrd file at once."""

    def __init__(self, folder):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.url = f"rerun+http://127.0.0.1:{port}/proxy"
        self.kept = folder / "arrived.rrd"
        command = [RERUN, "--serve-grpc", "--port", str(port), "--save", self.kept]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(command, **quiet, process_group=0)
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    return
            time.sleep(0.05)
        raise TimeoutError("the server does not listen")

    def arrived(self, *words):
        """Whether all of this has arrived, within some seconds."""
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            show = [RERUN, "rrd", "print", "-vvv", self.kept]
            text = subprocess.run(show, capture_output=True, text=True).stdout
            if all(word in text for word in words):
                return True
            time.sleep(0.1)
        return False

    def stop(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)
        self.process.wait()


@pytest.fixture
def server(tmp_path):
    started = Server(tmp_path)
    yield started
    started.stop()


def write_part(recorder, part):
    for topic, (times, values) in samples(2000).items():
        recorder.write(topic, times[part], values[part])


def test_batches_arrive_while_the_file_is_not_finished(tmp_path, server):
    path = tmp_path / "run.mcap"
    live = RerunSink(find_viewer(server.url), HEADER, CHANNELS, live=True)
    with Recorder([McapSink(path, HEADER, CHANNELS), live]) as recorder:
        write_part(recorder, slice(0, 1000))
        recorder.event(100.0, "info", "half of it")
        first = samples(2000)["/modes"][1][0, 4]
        assert server.arrived("/modes/amplitude_A", f"{first}", "half of it")
        assert not read(path).complete
        write_part(recorder, slice(1000, 2000))
    assert server.arrived("/loop/contact/0/now")
    assert read(path).complete


def test_run_shows_the_scene_in_a_viewer_that_listens(tmp_path, server, capsys):
    command = ["run", "one-mode", "-o", str(tmp_path), "--live", server.url]
    assert main(command) == 0
    assert capsys.readouterr().err == ""
    assert server.arrived(
        "One mode near resonance", "/contact/1/friction_force", "end of the scene"
    )
    assert read(tmp_path / "one-mode.mcap").complete


def test_a_viewer_that_goes_away_does_not_end_the_run(tmp_path, server):
    path = tmp_path / "run.mcap"
    live = RerunSink(Viewer(server.url), HEADER, CHANNELS, live=True)
    with Recorder([McapSink(path, HEADER, CHANNELS), live]) as recorder:
        write_part(recorder, slice(0, 1000))
        server.stop()
        write_part(recorder, slice(1000, 2000))
    data = read(path)
    assert data.complete
    for topic, (_, values) in samples(2000).items():
        np.testing.assert_array_equal(data.channels[topic].values, values)


def test_a_failing_viewer_is_told_of_once(server, monkeypatch, caplog):
    live = RerunSink(Viewer(server.url), HEADER, CHANNELS, live=True)

    def failing(*arguments, **options):
        raise RuntimeError("flush timed out")

    monkeypatch.setattr(rr.RecordingStream, "flush", failing)
    live.close()
    write_part(live, slice(0, 10))
    live.close()
    (line,) = caplog.messages
    assert line.endswith("flush timed out; the run goes on without the viewer")


@pytest.mark.parametrize(
    ("url", "complaint"),
    [
        ([], "the viewer does not start here: "),
        (["rerun+http://127.0.0.1:1/proxy"], "no viewer at .*: start one there with the command"),
        (["http://127.0.0.1:9876"], "a viewer's URL must be like rerun.http"),
        (["rerun+http://127.0.0.1:x/proxy"], "a viewer's URL must be like rerun.http"),
    ],
)
def test_without_a_viewer_the_run_is_recorded(tmp_path, capsys, monkeypatch, url, complaint):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    assert main(["run", "one-mode", "-o", str(tmp_path), "--live", *url]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(complaint, line)
    assert line.endswith("; recorded without it: see slipmode replay")
    assert read(tmp_path / "one-mode.mcap").complete


@pytest.mark.usefixtures("viewer")  # skipped where there is no renderer
def test_a_viewer_is_started_once_and_found_again(tmp_path, monkeypatch):
    """With a viewer that needs no window, in the place of the one that does."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        url = f"rerun+http://127.0.0.1:{probe.getsockname()[1]}/proxy"
    program, number = tmp_path / "rerun", tmp_path / "number"
    program.write_text(f'#!/bin/sh\necho $$ >> "{number}"\nexec "{RERUN}" --headless "$@"\n')
    program.chmod(0o755)
    monkeypatch.setattr(viewer, "VIEWER", str(program))
    monkeypatch.setattr(viewer, "_URL", url)
    try:
        found = find_viewer()
        assert find_viewer() == found == Viewer(url)
        with RerunSink(found, HEADER, CHANNELS, live=True) as live:
            write_part(live, slice(0, 1000))
        (shown,) = ViewerClient.connect(url).get_state().recordings
        assert shown.timelines[0].name == "time"
    except SlipmodeError as error:
        assert "the viewer does not start here" in str(error)
        pytest.skip(f"no software renderer on this machine: {error}")
    finally:
        (process,) = number.read_text().split()
        with suppress(ProcessLookupError):
            os.killpg(int(process), signal.SIGTERM)


def test_a_viewer_that_does_not_answer_is_refused():
    with pytest.raises(SlipmodeError, match="no viewer at"):
        find_viewer("rerun+http://127.0.0.1:1/proxy")
