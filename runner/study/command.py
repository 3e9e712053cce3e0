"""`slipmode study`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from slipmode.rom.errors import SlipmodeError


def add_study_command(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add it; `command(name, call, help, example)` makes a parser."""
    study = command(
        "study",
        _study,
        "a scene many times with other values, on all cores or a Dask cluster",
        "study damper.toml -o logs --workers 4",
    )
    study.add_argument("file", type=Path, help="a study file")
    study.add_argument("-o", "--output", type=Path, default=Path("logs"), help="folder (logs)")
    where = study.add_mutually_exclusive_group()
    where.add_argument("--workers", type=_count, help="processes on this machine (one per core)")
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask scheduler: tcp://10.0.0.1:8786"
    )


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"must be a whole number > 0, got {text!r}")
    return int(text)


def _study(options: argparse.Namespace) -> int:
    from slipmode.runner.study.study import run_study
    from slipmode.runner.study.summary.summary import summarise

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
    return 0
