"""The commands for recordings: slipmode info, doctor, recover, export."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

AddCommand = Callable[
    [str, Callable[[argparse.Namespace], int], str, str], argparse.ArgumentParser
]


def add_recording_commands(add: AddCommand) -> None:
    """Add the commands; `add` takes name, function, summary and example of one."""
    info = add("info", _info, "what a recording holds", "info logs/two-mode.mcap")
    _recording_argument(info)

    doctor = add("doctor", _doctor, "whether a recording is sound", "doctor logs/two-mode.mcap")
    _recording_argument(doctor)

    recover = add(
        "recover",
        _recover,
        "make a sound recording of a damaged one",
        "recover logs/two-mode.mcap -o whole.mcap",
    )
    _recording_argument(recover)
    recover.add_argument("-o", "--output", type=Path, required=True, help="the .mcap to write")

    export = add(
        "export",
        _export,
        "write the samples of a recording for other tools",
        "export logs/two-mode.mcap -o energy.csv --topics /energy",
    )
    _recording_argument(export)
    export.add_argument(
        *("-o", "--output"), type=Path, required=True, help="file to write: .npz, .csv or .parquet"
    )
    export.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="channels (all)")


def _recording_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", type=Path, help="an .mcap recording")


def _info(options: argparse.Namespace) -> int:
    from runner.info import info

    print(info(options.file).text())
    return 0


def _doctor(options: argparse.Namespace) -> int:
    from runner.doctor import doctor

    complaints = doctor(options.file)
    for complaint in complaints:
        print(f"{options.file}: {complaint}", file=sys.stderr)
    if not complaints:
        print(f"{options.file}: sound")
    return 1 if complaints else 0


def _recover(options: argparse.Namespace) -> int:
    from runner.recover import recover

    print(recover(options.file, options.output).text())
    print(options.output)
    return 0


def _export(options: argparse.Namespace) -> int:
    from runner.export import export

    for path in export(options.file, options.output, options.topics):
        print(path)
    return 0
