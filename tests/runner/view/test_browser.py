"""slipmode replay --web: the recording in the viewer for browsers, seen by a real one."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from io import BytesIO
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from slipmode.__main__ import main

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
OFFLINE = ("--disable-background-networking", "--disable-component-update", "--disable-sync")
GRAPHICS = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PATIENCE = 120.0  # [s], of a busy machine without a graphics card


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


@pytest.mark.slow
def test_a_browser_draws_every_view(served):
    playwright = pytest.importorskip("playwright.sync_api", reason="needs slipmode[browser]")
    if BROWSER is None:
        pytest.skip("needs the browser chromium")
    _, address = served
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", *OFFLINE, *GRAPHICS]
        )
        page = browser.new_page(
            viewport={"width": 1600, "height": 900}, color_scheme="dark", bypass_csp=True
        )
        page.goto(address)
        deadline, drawn = time.monotonic() + PATIENCE, np.zeros(1)
        while min(drawn) < 400 and time.monotonic() < deadline:
            time.sleep(1.0)
            picture = matplotlib.image.imread(BytesIO(page.screenshot()))[..., :3]
            columns = (picture[60:700, left : left + 460] for left in (40, 560, 1090))
            drawn = [np.count_nonzero(np.ptp(part, axis=2) > 0.1) for part in columns]
        browser.close()
    assert min(drawn) >= 400
