"""What studies cost on a cluster, scheduler, workers and client each a process: make bench-study.

The cluster is set up as one that a study starts by itself.

Whatever else runs on a machine takes from times by the clock, not from those of the processor.
Where each process has a core to itself, a study takes as long as the busiest of them works; on two
cores at least half of what all of them do.

What a task costs is told by many of one sample each, which take some ms: to long ones would count
what client and scheduler do each second, such as heartbeats and writing results. What Dask itself
needs of that is measured by as many tasks with nothing in them that keep a worker as long: each
of them needs a message, a transition and a result all the same.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipmode.rom.extras import extra
from slipmode.runner.study import tasks
from slipmode.runner.study.cluster import SETTINGS
from slipmode.runner.study.foreman import most_at_once
from slipmode.runner.study.study import run_study
from slipmode.runner.study.tasks import AT_ONCE

_SIZES = (100, 1_000, 10_000, 100_000)
_COMPARED = 60_000  # samples of the study that one and two workers do ...
_FEW = 200  # ... without what this many take
_MIB = 1024.0**2
_TURNS = 3
_TASKS = 1_000  # of one sample each ...
_FIRST = 100  # ... without what so many take
_SAMPLED = 0.2  # [s] between looks at memory
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


@dataclass(frozen=True)
class Cost:
    """Of a study: seconds by the clock and of processors, tasks, largest memory [MiB].

    Processors and memory are of the client, the scheduler, and each worker.
    """

    clock: float
    seconds: tuple[float, ...]
    memory: tuple[float, ...]
    tasks: int

    def beyond(self, less: Cost) -> Cost:
        """What this takes more than another study: without what it takes to start one."""
        seconds = tuple(a - b for a, b in zip(self.seconds, less.seconds, strict=True))
        return Cost(self.clock - less.clock, seconds, self.memory, self.tasks - less.tasks)

    @property
    def least(self) -> float:
        """Seconds that it takes on two cores with nothing else on them."""
        return max(*self.seconds, sum(self.seconds) / 2.0)

    @property
    def overhead(self) -> float:
        """Of client and scheduler for a task [s]."""
        return (self.seconds[0] + self.seconds[1]) / self.tasks


def main(arguments: list[str] | None = None) -> None:
    """Print the tables; sizes may be given."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=_SIZES, help="samples")
    sizes = parser.parse_args(arguments).sizes
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study_cost(1, _FEW + 1, folder)  # the table is in the cache from then on
        one, two = (
            study_cost(workers, _COMPARED, folder).beyond(study_cost(workers, _FEW, folder))
            for workers in (1, 2)
        )
        print(
            f"two-mode scene, steady, {_COMPARED - _FEW} more samples than {_FEW}: seconds of "
            "the processor"
        )
        print(f"{'workers':>8} {'client':>8} {'scheduler':>10} {'workers':>14} {'clock':>8}")
        for cost in (one, two):
            client, scheduler, *each = cost.seconds
            words = ", ".join(f"{seconds:.1f}" for seconds in each)
            print(f"{len(each):8} {client:8.1f} {scheduler:10.1f} {words:>14} {cost.clock:8.1f}")
        print(
            f"2 workers are {one.least / two.least:.2f} times 1 on two cores of their own, "
            f"{one.clock / two.clock:.2f} times by the clock"
        )
        ours, theirs = overheads(folder)
        print(
            f"client and scheduler need {1e3 * ours:.2f} ms for each task, and for empty ones of "
            f"that length {1e3 * theirs:.2f} ms: {1e3 * (ours - theirs):.2f} ms are of the study"
        )
        print(f"\n{'samples':>8} {'clock':>8} {'client':>12} {'scheduler':>12}")
        for size in sizes:
            cost = study_cost(2, size, folder)
            client, scheduler, *_ = cost.memory
            print(
                f"{size:8} {cost.clock:7.1f}s {client:8.0f} MiB {scheduler:8.0f} MiB", flush=True
            )


def study_cost(workers: int, samples: int, folder: Path, at_once: int = AT_ONCE) -> Cost:
    """A study on a cluster of its own, from its start to its results."""
    path = folder / f"{samples}-by-{at_once}-on-{workers}.toml"
    path.write_text(_STUDY.format(samples=samples), encoding="utf-8")
    return _cost(workers, "run", path, folder, at_once)


def overheads(folder: Path) -> tuple[float, float]:
    """Of a study's task and of an empty one [s], in turns: what else there is adds to either."""
    ours, theirs = [], []
    for turn in range(_TURNS):  # a study of other samples each: its results are there already
        few, many = (study_cost(1, n + turn, folder, 1) for n in (_FIRST, _FIRST + _TASKS))
        study = many.beyond(few)
        length = study.seconds[2] / study.tasks
        few, many = (empty_cost(1, n, length) for n in (_FIRST, _FIRST + _TASKS))
        ours.append(study.overhead)
        theirs.append(many.beyond(few).overhead)
    return min(ours), min(theirs)


def empty_cost(workers: int, count: int, seconds: float) -> Cost:
    """Tasks that do nothing, for so long each, on a cluster of its own."""
    return _cost(workers, "empty", count, seconds)


def _cost(workers: int, *client_is: Any) -> Cost:
    distributed, psutil = extra("distributed", "study"), extra("psutil", "study")
    inherited = extra("dask.config", "study").serialize(SETTINGS)
    os.environ["DASK_INTERNAL_INHERIT_CONFIG"] = inherited  # processes of a cluster are given it
    with (
        distributed.SubprocessCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=":0"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        client.wait_for_workers(workers)
        scheduler = psutil.Process(client.run_on_scheduler(_number))
        others = [scheduler, *map(psutil.Process, client.run(_number).values())]
        before = [_seconds(process) for process in others]
        start = time.perf_counter()
        study = subprocess.Popen(
            [sys.executable, "-m", _MODULE, *map(str, client_is), cluster.scheduler_address],
            stdout=subprocess.PIPE,
            text=True,
        )
        processes = [psutil.Process(study.pid), *others]
        memory = [0.0] * len(processes)
        while study.poll() is None:
            memory = [
                max(most, _memory(process, psutil))
                for most, process in zip(memory, processes, strict=True)
            ]
            time.sleep(_SAMPLED)
        clock = time.perf_counter() - start
        assert study.stdout is not None
        own = json.loads(study.stdout.read())
        after = [_seconds(process) for process in others]
        count = client.run_on_scheduler(_tasks)
    spent = [b - a for a, b in zip(before, after, strict=True)]
    return Cost(clock, (own, *spent), tuple(memory), count)


def run(path: str, folder: str, at_once: str, scheduler: str) -> None:
    """The client: a study on a scheduler; prints the seconds of its processor."""
    tasks.AT_ONCE = int(at_once)
    run_study(path, folder, scheduler=scheduler)
    print(json.dumps(time.process_time()))


def run_empty(count: int, seconds: float, scheduler: str) -> None:
    """The client: as many tasks at once as in a study; prints the same."""
    distributed = extra("distributed", "study")
    with distributed.Client(scheduler) as client:
        completed = distributed.as_completed(loop=client.loop)
        left = count
        for _ in range(min(count, most_at_once(client))):
            completed.add(client.submit(_compute, seconds, pure=False))
            left -= 1
        for future in completed:
            future.result()
            if left > 0:
                completed.add(client.submit(_compute, seconds, pure=False))
                left -= 1
    print(json.dumps(time.process_time()))


def _compute(seconds: float) -> None:
    """Nothing; `_tasks` counts it as it does those of studies."""
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def _number() -> int:
    return os.getpid()


def _seconds(process: Any) -> float:
    """Of the processor; NaN of a process that has just ended."""
    try:
        times = process.cpu_times()
    except extra("psutil", "study").NoSuchProcess:
        return float("nan")
    return float(times.user + times.system)


def _memory(process: Any, psutil: Any) -> float:
    """[MiB]; none of a process that has just ended."""
    try:
        return float(process.memory_info().rss / _MIB)
    except psutil.NoSuchProcess:
        return 0.0


def _tasks(dask_scheduler: Any) -> int:
    """How many of `_compute`, as Dask names them, there have been."""
    prefix = dask_scheduler.task_prefixes.get("compute")
    return 0 if prefix is None else int(prefix.state_counts["memory"])


_MODULE = "slipmode.runner.report.answers.studies"

if __name__ == "__main__":
    if sys.argv[1:2] == ["run"]:
        run(*sys.argv[2:])
    elif sys.argv[1:2] == ["empty"]:
        run_empty(int(sys.argv[2]), float(sys.argv[3]), sys.argv[4])
    else:
        main()
