"""The commands of slipmode and their options in words, from the parser itself."""

import argparse

from slipmode.runner.cli import COMMANDS, command_parser


def commands() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command by its name."""
    return {name: command_parser(name) for name in COMMANDS}


def as_markdown() -> str:
    """A section for each command: what it does, an example, a table of arguments and options."""
    return "\n\n".join(_section(name, parser) for name, parser in commands().items())


def _section(name: str, parser: argparse.ArgumentParser) -> str:
    does = f"{parser.description[:1].upper()}{parser.description[1:]}."
    example = parser.epilog.removeprefix("example: ")
    rows = [
        f"| {_argument(each)} | {each.help.replace('%%', '%').replace('|', chr(92) + '|')} |"
        for each in sorted(parser._actions, key=lambda action: bool(action.option_strings))
        if each.dest != "help"
    ]
    table = "\n".join(("| argument | meaning (default) |", "|---|---|", *rows)) if rows else ""
    return f"## `slipmode {name}`\n\n{does}\n\n```sh\n{example}\n```\n\n{table}"


def _argument(action: argparse.Action) -> str:
    """As it is typed: `SCENE`, `-o`, `--output OUTPUT`, `--span FROM TO`."""
    value = action.metavar or action.dest.upper()
    if action.choices:
        value = ", ".join(map(str, action.choices))
    words = value if isinstance(value, str) else " ".join(value)
    if action.nargs == "+":
        words = f"{words} ..."
    if action.nargs == "?":
        words = f"[{words}]"
    if not action.option_strings:
        return f"`{words}`"
    *short, last = action.option_strings
    return ", ".join(
        f"`{each}`" for each in (*short, last if action.nargs == 0 else f"{last} {words}")
    )
