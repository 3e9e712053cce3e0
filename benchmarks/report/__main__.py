"""Print the tables of the report and write its picture: python -m benchmarks.report [--quick]."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from benchmarks.measure import one_thread
from benchmarks.peers.first_order import HAS_CVODE
from benchmarks.report.picture import draw
from benchmarks.report.sections import Row
from benchmarks.report.tasks import FULL, QUICK, accuracy_tasks, speed_tasks
from benchmarks.report.text import render


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure everything: five minutes, or one with --quick."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("logs"), help="folder (logs)")
    parser.add_argument("--quick", action="store_true", help="fewer cases, methods and settings")
    options = parser.parse_args(arguments)
    scope = QUICK if options.quick else FULL
    tasks = [*speed_tasks(scope), *accuracy_tasks(scope)]
    found = []
    with one_thread(), tqdm(tasks, unit=" tasks", desc="report") as bar:

        def show(row: Row) -> None:
            bar.set_postfix_str(row.name)

        for task in bar:
            found.append(task(show))
    speed = len(list(speed_tasks(scope)))
    print(render(found[:speed], found[speed:]))
    if not HAS_CVODE:
        print("no CVODE: scikit-sundae is missing; pip install 'slipmode[benchmarks]'")
    print(draw(found[:speed], options.output))


if __name__ == "__main__":
    main()
