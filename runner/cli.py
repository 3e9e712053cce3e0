"""The command line: parsers of the commands, warnings and refusals in one line."""

from __future__ import annotations

import gc
import logging
import sys
from argparse import REMAINDER, SUPPRESS, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module

from slipmode.rom import __version__
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.commands import TASKS, Command, overview
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.messages import warnings_to

COMMANDS = {name: where for commands in TASKS.values() for name, where in commands.items()}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, or 1 after one line on standard error with the reason."""
    gc.set_threshold(50_000)  # what imports make stays: the search for garbage in it takes 0.04 s
    options = read_options(arguments)
    try:
        with _warnings_shown():
            return int(options.function(options))
    except SlipmodeError as error:
        return _fail(command_words(str(error), vars(options)))
    except MemoryError as error:
        return _fail(f"out of memory: {error}" if str(error) else "out of memory")
    except BrokenPipeError:  # `slipmode ... | head` closes the pipe early
        sys.stdout = None
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}")
    except KeyboardInterrupt:
        print("slipmode: interrupted; a recording is readable as far as it got", file=sys.stderr)
        return 130  # what a shell reports after Ctrl-C


def read_options(arguments: Sequence[str] | None) -> Namespace:
    """Return the options of the command that the arguments name; `function` runs it."""
    parser = ArgumentParser(
        prog="slipmode",
        usage="slipmode [-h] [--version] COMMAND ...",
        description="\n\n".join(overview()),
        epilog="example: slipmode run two-mode -o logs && slipmode replay logs/two-mode.mcap",
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"slipmode {__version__}")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help=SUPPRESS)
    parser.add_argument("arguments", nargs=REMAINDER, metavar="...", help=SUPPRESS)
    given = parser.parse_args(arguments)
    return command_parser(given.command).parse_args(given.arguments)


def command_parser(name: str) -> ArgumentParser:
    """Return the parser of a command, whose module is imported."""
    module, summary = COMMANDS[name]
    command: Command = import_module(f"slipmode.runner.{module}").commands()[name]
    example = f"example: slipmode {command.example}"
    parser = ArgumentParser(prog=f"slipmode {name}", description=summary, epilog=example)
    for each in command.arguments:
        parser.add_argument(*each.names, **each.options)
    if command.either:
        group = parser.add_mutually_exclusive_group()
        for each in command.either:
            group.add_argument(*each.names, **each.options)
    parser.set_defaults(function=command.function)
    return parser


@contextmanager
def _warnings_shown() -> Iterator[None]:
    """Print each warning once, in one line on standard error, inside the context."""
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("slipmode: warning: %(message)s"))
    shown: set[str] = set()

    def is_new(record: logging.LogRecord) -> bool:
        record.msg, record.args = command_words(record.getMessage()), ()
        known = record.msg in shown
        shown.add(record.msg)
        return not known

    handler.addFilter(is_new)
    with warnings_to(handler):
        yield


def _fail(message: str) -> int:
    print(f"slipmode: {' '.join(message.split())}", file=sys.stderr)
    return 1
