"""The commands for recordings: slipmode replay, info, doctor, recover, export."""

from __future__ import annotations

import argparse
import sys
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path

from slipmode.rom.errors import SlipmodeError

AddCommand = Callable[
    [str, Callable[[argparse.Namespace], int], str, str], argparse.ArgumentParser
]


def add_recording_commands(add: AddCommand) -> None:
    """Add the commands; `add` takes name, function, summary and example of one."""
    replay = add(
        "replay",
        _replay,
        "show a recording in Rerun",
        "replay logs/two-mode.mcap --start 1400 --speed 5 --loop",
    )
    _recording_argument(replay)
    replay.add_argument(
        "--start", type=float, default=-inf, metavar="T", help="show from T [s] on"
    )
    replay.add_argument("--end", type=float, default=inf, metavar="T", help="show up to T [s]")
    _topics_argument(replay)
    replay.add_argument(
        "--speed", type=float, metavar="X", help="play X simulated seconds a second"
    )
    replay.add_argument("--loop", action="store_true", help="play, and begin again at the end")
    replay.add_argument(
        "--save", type=Path, metavar="RRD", help="write an .rrd file instead of opening a viewer"
    )
    replay.add_argument(
        "--screenshot",
        type=Path,
        metavar="PNG",
        help="write a picture of the end, without a window",
    )
    replay.add_argument(
        "--headless", action="store_true", help="never open a window: --save or --screenshot only"
    )

    replay.add_argument(
        "--web",
        nargs="?",
        type=int,
        const=0,
        metavar="PORT",
        help="serve it to a browser of this machine, until Ctrl-C (at a free port)",
    )

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
        "-o",
        "--output",
        type=Path,
        required=True,
        help="file to write: .npz, .csv or .parquet",
    )
    _topics_argument(export)


def _recording_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", type=Path, help="an .mcap recording")


def _topics_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--topics",
        nargs="+",
        type=lambda words: words.split(","),
        default=[],
        metavar="TOPIC",
        help="channels, with commas or spaces between them (all)",
    )


def _topics(options: argparse.Namespace) -> list[str]:
    return [topic for words in options.topics for topic in words if topic]


def _replay(options: argparse.Namespace) -> int:
    from slipmode.runner.recording.load import Selection
    from slipmode.runner.view.replay import in_browser, replay
    from slipmode.runner.view.views import Playing

    written = [path for path in (options.save, options.screenshot) if path]
    if options.headless and not written:
        raise SlipmodeError("--headless shows nothing by itself: give --save or --screenshot")
    playing = None
    if options.speed is not None or options.loop:
        playing = Playing(1.0 if options.speed is None else options.speed, options.loop)
    selection = Selection(_topics(options), options.start, options.end)
    if options.web is not None:
        if written or options.headless:
            raise SlipmodeError("--web goes without --save, --screenshot and --headless")
        if not 0 <= options.web < 65536:
            raise SlipmodeError(f"--web: a port is from 0 to 65535, got {options.web}")
        with (
            in_browser(options.file, selection, playing, options.web) as address,
            suppress(KeyboardInterrupt),
        ):
            print(f"{address}\nin your browser; Ctrl-C ends it", flush=True)
            webbrowser.open(address)
            threading.Event().wait()
        return 0
    for note in replay(options.file, options.save, options.screenshot, selection, playing):
        print(note, file=sys.stderr)
    for path in written:
        print(path)
    return 0


def _info(options: argparse.Namespace) -> int:
    from slipmode.runner.recording.check import info

    print(info(options.file).text())
    return 0


def _doctor(options: argparse.Namespace) -> int:
    from slipmode.runner.recording.check import doctor

    complaints = doctor(options.file)
    for complaint in complaints:
        print(f"{options.file}: {complaint}", file=sys.stderr)
    if not complaints:
        print(f"{options.file}: sound")
    return 1 if complaints else 0


def _recover(options: argparse.Namespace) -> int:
    from slipmode.runner.recording.recover import recover

    print(recover(options.file, options.output).text())
    print(options.output)
    return 0


def _export(options: argparse.Namespace) -> int:
    from slipmode.runner.recording.export import export

    for path in export(options.file, options.output, _topics(options)):
        print(path)
    return 0
