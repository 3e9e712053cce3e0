"""slipmode replay --web: the viewer for browsers is served."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from slipmode.__main__ import main


@pytest.fixture
def served(shipped_scene):
    """The command, and the address that it prints."""
    recording = shipped_scene("two-mode")
    slipmode = str(Path(sys.executable).parent / "slipmode")
    command = (slipmode, "replay", str(recording.mcap), "--web")
    quiet = os.environ | {"BROWSER": "true"}  # the command that stands for a browser
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=quiet) as process:
        yield process, process.stdout.readline().strip()
        process.send_signal(signal.SIGINT)  # so that it ends its viewer too
        process.wait(30.0)


def port(address):
    return int(re.match(r"http://127\.0\.0\.1:(\d+)/\?url=rerun", address)[1])


def listens(number):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", number)) == 0


def test_it_is_served_until_it_is_interrupted(served):
    process, address = served
    assert listens(port(address))
    process.send_signal(signal.SIGINT)
    assert process.wait(30.0) == 0
    assert not listens(port(address))


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--web", "70000"), "a port is from 0 to 65535, got 70000"),
        (("--web", "--save", "x.rrd"), "--web goes without"),
    ],
)
def test_what_cannot_be_served_is_refused_in_one_line(options, complaint, shipped_scene, capsys):
    assert main(["replay", str(shipped_scene("two-mode").mcap), *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line
