"""Behind the command line: what commands share.

recordings.py      replay, info, doctor, recover, export
curves.py          curve, backbone, design
diameters.py       diameters
study.py           study
scenes.py          scenes
mode_table.py      modes
command_words.py   messages in the words of the command line
"""

import shlex
import shutil
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

# The commands by task, as the help lists them.
_GROUPS = {
    "run and look": ("run", "replay", "explore", "plan", "validate", "scenes"),
    "analyse": ("modes", "curve", "backbone", "design", "diameters"),
    "studies": ("study",),
    "from measurements": ("identify",),
    "export": ("fmu", "export"),
    "recordings and the cache": ("info", "doctor", "recover", "cache"),
}


class Argument:
    """An argument of a command, from the parameters of `ArgumentParser.add_argument`."""

    def __init__(self, *names: str, **options: Any) -> None:
        self.names, self.options = names, options


# `add(name, function, summary, example, *arguments)` adds a command and returns its parser
AddCommand = Callable[..., ArgumentParser]

SCENE = Argument("scene", help="a scene file, or the name of a shipped scene")
OUTPUT = Argument("-o", "--output", type=Path, default=Path("logs"), help="folder (logs)")


def print_next(*words: str | Path) -> None:
    """Print the command to run next, quoted for a shell, as the last line of a command."""
    program, *others = map(str, words)
    if program == "slipmode" and not shutil.which(program):
        program = sys.argv[0]
    print(f"next:  {shlex.join([program, *others])}")


def print_charts(picture: Path, recording: Path) -> None:
    """Print which files to look at next: a picture, and a recording of Rerun."""
    paths = (shlex.quote(str(path)) for path in (picture, recording))
    print("next:  open {}, or in Rerun: rerun {}".format(*paths))


def overview(summaries: Mapping[str, str]) -> Iterator[str]:
    """Yield paragraphs: what slipmode is for, the commands of each task, their help."""
    yield "Structures with dry-friction contacts, forced near two resonances."
    for task, names in _GROUPS.items():
        yield "\n".join([f"{task}:", *(f"    {name:9}  {summaries[name]}" for name in names)])
    yield "slipmode COMMAND --help shows the options of a command and an example."
