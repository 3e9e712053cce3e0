"""How long commands take to start: make bench-start.

Help, and the plan of each shipped scene, in a process of its own with warm caches: wall time, and
processor time (user and system), which other processes disturb less. Beside it the imports of
NumPy and SciPy alone, which every plan needs.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from statistics import median

from slipmode.runner import shipped_scenes

_REPEATS = 7


def main() -> None:
    """Measure and print, the commands in turns."""
    python = [sys.executable, "-c"]
    slipmode = [sys.executable, "-m", "slipmode"]
    commands = {
        "import NumPy": [*python, "import numpy"],
        "import SciPy": [*python, "import scipy.linalg, scipy.sparse"],
        "slipmode --help": [*slipmode, "--help"],
    }
    commands |= {f"slipmode plan {name}": [*slipmode, "plan", name] for name in shipped_scenes()}
    for command in commands.values():
        _seconds(command)  # writes bytecode and tables
    turns = [{name: _seconds(each) for name, each in commands.items()} for _ in range(_REPEATS)]
    print(f"{f'best and median of {_REPEATS} [s]':34}wall          processor")
    for name in commands:
        wall, processor = zip(*(turn[name] for turn in turns), strict=True)
        numbers = (f"{min(each):.2f}  {median(each):.2f}" for each in (wall, processor))
        print(f"{name:34}{'    '.join(numbers)}")
    if sys.dont_write_bytecode:
        print("PYTHONDONTWRITEBYTECODE is set: each start compiles the sources that it imports")


def _seconds(command: list[str]) -> tuple[float, float]:
    """Return wall time and processor time of a command [s]."""
    before, started = os.times(), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall, after = time.perf_counter() - started, os.times()
    spent = after.children_user - before.children_user
    return wall, spent + after.children_system - before.children_system


if __name__ == "__main__":
    main()
