"""What studies cost on processes of this machine: make bench-study.

Wall time includes other programs on the machine; processor time does not: with a core for each
process, a study takes as long as its busiest process.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from slipmode.rom.extras import extra

_SIZES = (100, 1_000, 10_000, 60_000)
_SAMPLED = 0.2  # interval of memory samples [s]
_RUN = """
import sys
from slipmode.runner import run_study
run_study(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]))
"""
_STUDY = """
scene = "two-mode"

[set]
"model.tolerance" = 2e-3

[[vary]]
key = "forcing.A.frequency"
distribution = "uniform"
low = 0.94
high = 1.02

[[vary]]
key = "forcing.B.amplitude"
distribution = "lognormal"
median = 0.25
sigma = 0.2

[sampling]
samples = {samples}

[outputs]
steady = true
"""


class Cost(NamedTuple):
    """Wall time [s], processor times [s] and largest memory [MiB] of a study.

    Processor times and memory are of the client, and of each process that it starts.
    """

    wall: float
    seconds: list[float]
    memory: list[float]


def study_cost(workers: int, samples: int, folder: Path) -> Cost:
    """Return the cost of `run_study` in a process of its own."""
    psutil = extra("psutil", "benchmarks")
    path = folder / f"{samples}-on-{workers}.toml"
    path.write_text(_STUDY.format(samples=samples), encoding="utf-8")
    start = time.perf_counter()
    study = subprocess.Popen([sys.executable, "-c", _RUN, str(path), str(folder), str(workers)])
    client = psutil.Process(study.pid)
    seconds: dict[int, float] = {}
    memory: dict[int, float] = {}
    while study.poll() is None:
        try:
            for each in (client, *client.children(recursive=True)):
                spent = each.cpu_times()
                seconds[each.pid] = spent.user + spent.system
                size = each.memory_info().rss / 1024.0**2
                memory[each.pid] = max(memory.get(each.pid, 0.0), size)
        except psutil.Error:  # it has just ended
            pass
        time.sleep(_SAMPLED)
    assert study.returncode == 0
    wall = time.perf_counter() - start
    return Cost(wall, list(seconds.values()), list(memory.values()))


def main(arguments: list[str]) -> None:
    """Print a table of the two-mode scene with one worker and with two."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=_SIZES, help="samples")
    sizes = parser.parse_args(arguments).sizes
    print(f"{'samples':>8} {'wall':>8}  processor seconds and MiB: client, others")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study_cost(1, 99, folder)  # the table is cached from then on
        for workers in (1, 2):
            for size in sizes:
                cost = study_cost(workers, size, folder)
                each = zip(cost.seconds, cost.memory, strict=True)
                words = "".join(f"{s:8.1f} s {memory:5.0f} MiB" for s, memory in each)
                print(f"{size:8} {cost.wall:6.1f} s {words}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
