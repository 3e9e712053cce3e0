"""Code blocks of the pages run, in order, in an empty folder; commands and options are real."""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import pytest

from slipmode.runner.cli import main, read_options

DOCS = Path(__file__).parents[2] / "docs"
BLOCK = re.compile(
    r"^```(?:\{code-block\} )?(\w+)\n(?::caption: (\S+)\n\n)?(.*?)^```$", re.MULTILINE | re.DOTALL
)
# Commands that open a window or measure for minutes: `may_run` says which arguments avoid that.
LONG = ("validate",)


@dataclass(frozen=True)
class Block:
    """A code block; a file of that name if it has a caption."""

    language: str
    caption: str
    text: str


def blocks(page):
    """The code blocks of a page, in order."""
    found = BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))
    return [Block(*each) for each in found]


def commands(text):
    """The lines of a shell block, without comments; what continues with a backslash is one."""
    lines = text.replace("\\\n", " ").splitlines()
    stripped = (re.sub(r"\s+#.*", "", line).strip() for line in lines)
    return [line for line in stripped if line and not line.startswith("#")]


def may_run(arguments):
    """Whether a slipmode command ends by itself, soon and without a window."""
    if arguments[0] == "replay":
        return any(option in arguments for option in ("--save", "--headless"))
    return arguments[0] not in LONG and "--live" not in arguments


def run_command(line):
    """Run a slipmode command; the others a shell runs, with slipmode's folder on its path."""
    words = shlex.split(line)
    if words[0] == "slipmode":
        if may_run(words[1:]):
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                assert main(words[1:]) == 0, line
    else:
        path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
        subprocess.run(["sh", "-c", line], env=os.environ | {"PATH": path}, check=True)


PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
SLOW = ["guide/curves.md", "guide/loops.md", "guide/saved-models.md"]
LONG_TUTORIALS = "blade-flutter bladed-disk choosing measured-decays own-beam studies"
SLOW += [f"tutorials/{page}.md" for page in LONG_TUTORIALS.split()]
TUTORIALS = [page for page in PAGES if any(b.language == "python" for b in blocks(page))]
NOT_OURS = ("make", "pip", ".venv/bin/python", "cp", "rerun")


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.slow] * (page in SLOW)) for page in TUTORIALS],
)
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "page"}
    for number, block in enumerate(blocks(page)):
        if block.caption:
            (tmp_path / block.caption).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            exec(compile(block.text, f"{page}, block {number}", "exec"), names)
        elif block.language == "sh":
            for line in commands(block.text):
                if shlex.split(line)[0] not in ("make", "pip"):
                    run_command(line)


@pytest.mark.parametrize("page", PAGES)
def test_commands_of_a_page_are_there_with_their_options(page):
    for block in blocks(page):
        if block.language != "sh":
            continue
        for line in commands(block.text):
            words = shlex.split(line)
            if words[0] == "slipmode":
                read_options(words[1:])
            elif words[0] == "make":
                makefile = (DOCS.parent / "Makefile").read_text(encoding="utf-8")
                assert re.search(rf"^{words[1]}:", makefile, re.MULTILINE), line
            elif words[0] == "pip":
                project = (DOCS.parent / "pyproject.toml").read_text(encoding="utf-8")
                for extra in re.findall(r"\[([\w,]+)\]", line):
                    for name in extra.split(","):
                        assert re.search(rf"^{name} = \[", project, re.MULTILINE), line
            else:
                assert words[0] in NOT_OURS, line
