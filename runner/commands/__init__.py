"""Behind the command line: what commands share.

recordings.py      replay, info, doctor, recover, export
mode_table.py      modes
command_words.py   messages in the words of the command line
"""

from argparse import ArgumentParser
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple


class Argument(NamedTuple):
    """Names and options of an argument, as `ArgumentParser.add_argument` takes them."""

    names: tuple[str, ...]
    options: dict[str, Any]


# `add(name, function, summary, example, *arguments)` adds a command and returns its parser
AddCommand = Callable[..., ArgumentParser]


def argument(*names: str, **options: Any) -> Argument:
    """Return an argument from the parameters of `ArgumentParser.add_argument`."""
    return Argument(names, options)


SCENE = argument("scene", help="a scene file, or the name of a shipped scene")
OUTPUT = argument("-o", "--output", type=Path, default=Path("logs"), help="folder (logs)")
