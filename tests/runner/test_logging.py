"""Diagnostics go through the standard library's log, and are silent unless someone listens."""

import importlib.util
import logging
import subprocess
import sys
from pathlib import Path

import pytest

from slipmode.runner.cli import main

WORK = (
    "import logging, slipmode.rom\nlogging.getLogger('slipmode.cache').warning('something is odd')"
)


def python(code):
    return subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)


def test_nothing_is_shown_by_default():
    done = python(WORK)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_who_listens_hears():
    done = python(f"import logging\nlogging.basicConfig()\n{WORK}")
    assert done.stderr == "WARNING:slipmode.cache:something is odd\n"


def test_a_command_shows_warnings_in_a_line_each(capsys, monkeypatch):
    def warn(options):
        for level in ("info", "warning"):
            getattr(logging.getLogger("slipmode.cache"), level)("%s of it", level)
        return 0

    monkeypatch.setattr("slipmode.runner.cli._scenes", warn)
    for _ in range(2):  # no handler is left behind
        assert main(["scenes"]) == 0
        printed = capsys.readouterr()
        assert (printed.out, printed.err) == ("", "slipmode: warning of it\n")


@pytest.mark.parametrize("package", ["rom", "fmu", "runner"])
def test_the_packages_say_that_they_are_typed(package):
    assert (
        Path(importlib.util.find_spec(f"slipmode.{package}").origin).parent / "py.typed"
    ).is_file()
