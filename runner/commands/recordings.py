"""`slipmode replay`, `info`, `doctor`, `recover`, `export`, and `slipmode cache`."""

from __future__ import annotations

import sys
import threading
import webbrowser
from argparse import Namespace
from contextlib import suppress
from math import inf
from pathlib import Path

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.table import disk_cache
from slipmode.runner.commands import Argument, Command, print_next
from slipmode.runner.recording.check import doctor, info
from slipmode.runner.recording.export import export
from slipmode.runner.recording.load import Selection
from slipmode.runner.recording.recover import recover
from slipmode.runner.view.replay import in_browser, replay


def commands() -> dict[str, Command]:
    """Return the commands for recordings."""
    file = Argument("file", type=Path, help="an .mcap recording")
    topics = Argument(
        "--topics",
        nargs="+",
        type=lambda words: words.split(","),
        default=[],
        metavar="TOPIC",
        help="channels, with commas or spaces between them (all)",
    )
    save = "write an .rrd file instead of opening a viewer"
    screenshot = "write a picture of the end, without a window"
    headless = "never open a window: --save or --screenshot only"
    web = "serve it to a browser of this machine, until Ctrl-C (at a free port)"
    written = "file to write: .npz, .csv or .parquet"
    return {
        "replay": Command(
            _replay,
            "replay logs/two-mode.mcap --start 1400 --speed 5 --loop",
            file,
            Argument("--start", type=float, default=-inf, metavar="T", help="show from T [s] on"),
            Argument("--end", type=float, default=inf, metavar="T", help="show up to T [s]"),
            topics,
            Argument("--speed", type=float, metavar="X", help="play X simulated seconds a second"),
            Argument("--loop", action="store_true", help="play, and begin again at the end"),
            Argument("--save", type=Path, metavar="RRD", help=save),
            Argument("--screenshot", type=Path, metavar="PNG", help=screenshot),
            Argument("--headless", action="store_true", help=headless),
            Argument("--web", nargs="?", type=int, const=0, metavar="PORT", help=web),
        ),
        "info": Command(_info, "info logs/two-mode.mcap", file),
        "doctor": Command(_doctor, "doctor logs/two-mode.mcap", file),
        "recover": Command(
            _recover,
            "recover logs/two-mode.mcap -o whole.mcap",
            file,
            Argument("-o", "--output", type=Path, required=True, help="the .mcap to write"),
        ),
        "export": Command(
            _export,
            "export logs/two-mode.mcap -o energy.csv --topics /energy",
            file,
            Argument("-o", "--output", type=Path, required=True, help=written),
            topics,
        ),
        "cache": Command(
            _cache,
            "cache --clear",
            Argument("--clear", action="store_true", help="remove them all"),
        ),
    }


def _topics(options: Namespace) -> list[str]:
    return [topic for words in options.topics for topic in words if topic]


def _replay(options: Namespace) -> int:
    from slipmode.runner.view.views import Playing  # Rerun takes a while to import

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
    if options.save:
        print_next("rerun", options.save)
    return 0


def _info(options: Namespace) -> int:
    print(info(options.file).text())
    print_next("slipmode", "replay", options.file)
    return 0


def _doctor(options: Namespace) -> int:
    complaints = doctor(options.file)
    for complaint in complaints:
        print(f"{options.file}: {complaint}", file=sys.stderr)
    if complaints:
        return 1
    print(f"{options.file}: sound")
    print_next("slipmode", "replay", options.file)
    return 0


def _recover(options: Namespace) -> int:
    print(recover(options.file, options.output).text())
    print(options.output)
    print_next("slipmode", "replay", options.output)
    return 0


def _export(options: Namespace) -> int:
    for path in export(options.file, options.output, _topics(options)):
        print(path)
    reader = {".npz": "numpy.load", ".csv": "pandas.read_csv"}
    print(f"next:  read it with {reader.get(options.output.suffix, 'pandas.read_parquet')}")
    return 0


def _cache(options: Namespace) -> int:
    entries = disk_cache.entries()
    size = sum(entries.values()) / disk_cache.MIB
    print(disk_cache.folder())
    if options.clear:
        disk_cache.clear()
        print(f"  removed {len(entries)} files, {size:.1f} MiB")
    else:
        most = disk_cache.bound() / disk_cache.MIB
        print(f"  {len(entries)} files, {size:.1f} of at most {most:g} MiB")
        print_next("slipmode", "cache", "--clear")
    return 0
