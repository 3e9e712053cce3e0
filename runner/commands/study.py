"""`slipmode study`."""

from __future__ import annotations

from argparse import ArgumentTypeError, Namespace
from pathlib import Path

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.commands import OUTPUT, Argument, Command, print_charts
from slipmode.runner.study.study import run_study


def commands() -> dict[str, Command]:
    """Return the command."""
    workers = "processes on this machine (one per core)"
    scheduler = "of a Dask scheduler: tcp://10.0.0.1:8786"
    return {
        "study": Command(
            _study,
            "study damper.toml -o logs --workers 4",
            Argument("file", type=Path, help="a study file"),
            OUTPUT,
            either=(
                Argument("--workers", type=_count, help=workers),
                Argument("--scheduler", metavar="ADDRESS", help=scheduler),
            ),
        ),
    }


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise ArgumentTypeError(f"must be a whole number > 0, got {text!r}")
    return int(text)


def _study(options: Namespace) -> int:
    from slipmode.runner.study.summary.summary import summarise  # Rerun takes a while to import

    try:
        done = run_study(
            options.file,
            options.output,
            workers=options.workers,
            scheduler=options.scheduler,
            progress=True,
        )
    except KeyboardInterrupt:
        raise SlipmodeError("interrupted; the same command goes on from there") from None
    before = f", {done.found} of them before" if done.found else ""
    print(f"{done.study.title}: {done.samples} samples{before}, {done.failed} failed")
    print("\n".join(summarise(done)))
    if done.failed < done.samples:
        print_charts(done.path.with_suffix(".png"), done.path.with_suffix(".rrd"))
    return 0
