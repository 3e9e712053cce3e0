"""A run shown while it is recorded: a server without a window keeps what a viewer would get."""

import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest
from rrd import RERUN

from slipmode.__main__ import main
from slipmode.runner import read


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


def test_run_shows_the_scene_in_a_viewer_that_listens(tmp_path, server, capsys):
    command = ["run", "one-mode", "-o", str(tmp_path), "--live", server.url]
    assert main(command) == 0
    assert capsys.readouterr().err == ""
    assert server.arrived(
        "One mode near resonance", "/contact/1/friction_force", "end of the scene"
    )
    assert read(tmp_path / "one-mode.mcap").complete


@pytest.mark.slow
def test_a_viewer_that_goes_away_does_not_end_the_run(tmp_path, server):
    command = [sys.executable, "-m", "slipmode", "run", "two-mode", "-o", tmp_path]
    with subprocess.Popen([*command, "--live", server.url], stderr=subprocess.DEVNULL) as run:
        assert server.arrived("/modes")
        server.stop()
        assert run.wait(120.0) == 0
    assert read(tmp_path / "two-mode.mcap").complete


@pytest.mark.parametrize(
    ("url", "complaint"),
    [
        ([], "the viewer does not start here: "),
        (["rerun+http://127.0.0.1:1/proxy"], "no viewer at .*: start one there with the command"),
        (["http://127.0.0.1:9876"], "a viewer's URL must be like rerun.http"),
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
