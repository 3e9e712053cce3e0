"""`slipmode study`."""

from __future__ import annotations

from argparse import ArgumentTypeError, Namespace
from pathlib import Path

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.commands import OUTPUT, AddCommand, Argument, print_charts
from slipmode.runner.study.study import run_study


def add_study_command(add: AddCommand) -> None:
    """Add the command."""
    study = add(
        "study",
        _study,
        "a scene with many other values, on all cores or a Dask cluster",
        "study damper.toml -o logs --workers 4",
        Argument("file", type=Path, help="a study file"),
        OUTPUT,
    )
    where = study.add_mutually_exclusive_group()
    where.add_argument("--workers", type=_count, help="processes on this machine (one per core)")
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask scheduler: tcp://10.0.0.1:8786"
    )


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
