"""Behind the command line: which commands there are, and what they share.

A module has a function `commands` that returns its commands by name; it is imported if one of
them is given, so that a command does not wait for what only others need.

run.py             run, validate
plan.py            plan
scenes.py          scenes
modes.py           modes
curves.py          curve, backbone, design
diameters.py       diameters
study.py           study
identify.py        identify
recordings.py      replay, info, doctor, recover, export, cache
command_words.py   messages in the words of the command line
"""

import shlex
import shutil
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

# For other rooms; a command imports more.
__all__ = ["SCENE", "Argument", "Command"]

# Commands by task, as the help lists them: the module of each, and what it does.
TASKS = {
    "run and look": {
        "run": ("commands.run", "run a scene and record it"),
        "replay": ("commands.recordings", "show a recording in Rerun"),
        "explore": (
            "explore.command",
            "write a scene as an HTML file that computes, with sliders",
        ),
        "plan": ("commands.plan", "what the reduced model of a scene must include, and why"),
        "validate": ("commands.run", "compare a run of a scene with full-order integration"),
        "scenes": ("commands.scenes", "list the shipped scenes"),
    },
    "analyse": {
        "modes": (
            "commands.modes",
            "modes of a scene or structure, and their motion at the contacts",
        ),
        "curve": (
            "commands.curves",
            "steady states against a frequency, a force or the friction limit",
        ),
        "backbone": ("commands.curves", "frequency and damping of a mode against its amplitude"),
        "design": (
            "commands.curves",
            "resonance peak against friction limits or preloads, and the best",
        ),
        "diameters": (
            "commands.diameters",
            "frequencies of a bladed disk by nodal diameter; Campbell diagram",
        ),
    },
    "studies": {
        "study": (
            "commands.study",
            "a scene with many other values, on all cores or a Dask cluster",
        ),
    },
    "from measurements": {
        "identify": (
            "commands.identify",
            "law, model and FMU from measured decays or sine tests; contact law from loops",
        ),
    },
    "export": {
        "fmu": ("fmi.command", "export a scene's model as an FMU"),
        "export": (
            "commands.recordings",
            "write the samples of a recording to .npz, .csv or .parquet",
        ),
    },
    "recordings and the cache": {
        "info": ("commands.recordings", "channels, units and versions of a recording"),
        "doctor": ("commands.recordings", "check a recording for damage"),
        "recover": (
            "commands.recordings",
            "write what can be read of a damaged recording to a sound one",
        ),
        "cache": (
            "commands.recordings",
            "folder and size of the cache of friction tables and reductions",
        ),
    },
}


class Argument:
    """An argument of a command, from the parameters of `ArgumentParser.add_argument`."""

    def __init__(self, *names: str, **options: Any) -> None:
        self.names, self.options = names, options


class Command:
    """A command: its function, an example, its arguments; at most one of `either` is given."""

    def __init__(
        self,
        function: Callable[[Namespace], int],
        example: str,
        *arguments: Argument,
        either: Sequence[Argument] = (),
    ) -> None:
        self.function, self.example = function, example
        self.arguments, self.either = arguments, either


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


def overview() -> Iterator[str]:
    """Yield paragraphs: what slipmode is for, the commands of each task, their help."""
    yield "Structures with dry-friction contacts, forced near two resonances."
    for task, commands in TASKS.items():
        lines = (f"    {name:9}  {summary}" for name, (_, summary) in commands.items())
        yield "\n".join([f"{task}:", *lines])
    yield "slipmode COMMAND --help shows the options of a command and an example."
