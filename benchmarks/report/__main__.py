"""Print the tables of the report and write its picture: python -m benchmarks.report [--quick]."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from benchmarks.measure import one_thread
from benchmarks.peers.first_order import HAS_CVODE
from benchmarks.report.picture import draw
from benchmarks.report.summary import as_markdown, write
from benchmarks.report.tasks import FULL, QUICK, accuracy_tasks, speed_tasks
from benchmarks.report.text import render


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure everything: five minutes, or one with --quick."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("logs"), help="folder (logs)")
    parser.add_argument("--quick", action="store_true", help="fewer cases, methods and settings")
    parser.add_argument(
        "--docs", action="store_true", help="write the table of README.md and the guide anew"
    )
    options = parser.parse_args(arguments)
    scope = QUICK if options.quick else FULL
    speed, accuracy = speed_tasks(scope), accuracy_tasks(scope)
    with one_thread():
        found = [task() for task in tqdm([*speed, *accuracy], unit=" tasks", desc="report")]
    sections, structures = found[: len(speed)], found[len(speed) :]
    print(render(sections, structures))
    if not HAS_CVODE:
        print("no CVODE: scikit-sundae is missing; pip install 'slipmode[benchmarks]'")
    print(draw(sections, options.output))
    if options.docs:
        write(as_markdown(sections))


if __name__ == "__main__":
    main()
