"""Diagnostics go through the standard library's log, and are silent unless someone listens."""

import importlib.util
import logging
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from slipmode.__main__ import main
from slipmode.rom import ValidityWarning
from slipmode.runner import shipped_scenes

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
        assert (printed.out, printed.err) == ("", "slipmode: warning: warning of it\n")


def test_a_command_shows_a_warning_of_python_once_in_one_line_without_a_file(capsys, monkeypatch):
    def warn(options):
        for _ in range(2):
            warnings.warn("contacts soft:\n  modes take away 5 %", ValidityWarning, stacklevel=1)
        return 0

    monkeypatch.setattr("slipmode.runner.cli._scenes", warn)
    for _ in range(2):
        assert main(["scenes"]) == 0
        printed = capsys.readouterr()
        assert printed.err == "slipmode: warning: contacts soft: modes take away 5 %\n"


def test_a_run_prints_each_warning_of_its_plan_once_before_it_runs(tmp_path, capsys):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    strained = text.replace("alpha = 0.02", "alpha = 20.0")
    assert strained != text
    scene = tmp_path / "strained.toml"
    scene.write_text(strained, encoding="utf-8")
    assert main(["plan", str(scene)]) == 0
    planned = [
        line.removeprefix("warning: ")
        for line in capsys.readouterr().out.splitlines()
        if line.startswith("warning: ")
    ]
    assert planned
    assert main(["run", str(scene), "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().err.splitlines()
    assert said == [f"slipmode: warning: {line}" for line in planned]


@pytest.mark.parametrize("package", ["rom", "fmu", "runner"])
def test_the_packages_say_that_they_are_typed(package):
    assert (
        Path(importlib.util.find_spec(f"slipmode.{package}").origin).parent / "py.typed"
    ).is_file()
