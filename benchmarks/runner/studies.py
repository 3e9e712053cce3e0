"""What studies cost on a cluster of separate processes: make bench-study.

The cluster is set up like the cluster that a study starts by itself. Wall time includes other
programs on the machine; processor time does not: with a core for each process, a study takes as
long as its busiest process.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

from slipmode.rom.extras import extra
from slipmode.runner.study.study import run_study
from slipmode.runner.study.workers.cluster import SETTINGS

_SIZES = (100, 1_000, 10_000, 60_000)
_SAMPLED = 0.2  # interval of memory samples [s]
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

    Processor times and memory are of the client, the scheduler, and each worker.
    """

    wall: float
    seconds: list[float]
    memory: list[float]


def study_cost(workers: int, samples: int, folder: Path) -> Cost:
    """Return the cost of a study on a cluster of its own."""
    distributed, psutil = extra("distributed", "study"), extra("psutil", "study")
    # the processes of the cluster inherit the settings
    inherited = extra("dask.config", "study").serialize(SETTINGS)
    os.environ["DASK_INTERNAL_INHERIT_CONFIG"] = inherited
    path = folder / f"{samples}-on-{workers}.toml"
    path.write_text(_STUDY.format(samples=samples), encoding="utf-8")
    with (
        distributed.SubprocessCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=":0"
        ) as cluster,
        distributed.Client(cluster) as observer,
    ):
        observer.wait_for_workers(workers)
        numbers = (observer.run_on_scheduler(os.getpid), *observer.run(os.getpid).values())
        others = [psutil.Process(number) for number in numbers]

        def spent() -> list[float]:
            times = [process.cpu_times() for process in others]
            return [float(each.user + each.system) for each in times]

        before, start = spent(), time.perf_counter()
        client = (sys.executable, "-m", "benchmarks.runner.studies", "run", path, folder)
        study = subprocess.Popen(
            [*map(str, client), cluster.scheduler_address], stdout=subprocess.PIPE, text=True
        )
        processes = [psutil.Process(study.pid), *others]
        memory = [0.0] * len(processes)
        while study.poll() is None:
            for k, process in enumerate(processes):
                memory[k] = max(memory[k], _memory(process, psutil))
            time.sleep(_SAMPLED)
        wall = time.perf_counter() - start
        assert study.stdout is not None
        own = json.loads(study.stdout.read())
        seconds = [b - a for a, b in zip(before, spent(), strict=True)]
    return Cost(wall, [own, *seconds], memory)


def _memory(process: Any, psutil: Any) -> float:
    """Memory [MiB]; 0 of a process that has just ended."""
    try:
        return float(process.memory_info().rss / 1024.0**2)
    except psutil.NoSuchProcess:
        return 0.0


def run(path: str, folder: str, scheduler: str) -> None:
    """Run a study as a client of a scheduler, and print its processor time [s]."""
    run_study(path, folder, scheduler=scheduler)
    print(json.dumps(time.process_time()))


def main(arguments: list[str]) -> None:
    """Print a table of the two-mode scene with one worker and with two."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=_SIZES, help="samples")
    sizes = parser.parse_args(arguments).sizes
    print(
        f"{'samples':>8} {'wall':>8} {'client':>18} {'scheduler':>18}  workers: processor seconds"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study_cost(1, min(sizes) + 1, folder)  # the table is cached from then on
        for workers in (1, 2):
            for size in sizes:
                cost = study_cost(workers, size, folder)
                both = zip(cost.seconds[:2], cost.memory, strict=False)
                words = "".join(f"{s:8.1f} s {memory:5.0f} MiB" for s, memory in both)
                each = ", ".join(f"{seconds:.1f}" for seconds in cost.seconds[2:])
                print(f"{size:8} {cost.wall:6.1f} s {words}  {each}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["run"]:
        run(*sys.argv[2:])
    else:
        main(sys.argv[1:])
