"""The processes of a Dask cluster: a local one, or any whose scheduler has an address."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.runner.messages import one_line

_log = logging.getLogger("slipmode.study")

_ANSWERS = 10.0  # [s] in which a scheduler has to answer, and workers have to connect
# Public settings of Dask for the processes that are started here. They switch off what it records
# for its developers (`make bench-study` measures the speed-up).
SETTINGS: dict[str, Any] = {
    "distributed.admin.low-level-log-length": 10,  # messages, with tasks and results in them
    "distributed.worker.profile.enabled": False,  # a thread that stops tasks 100 times a second
    "distributed.admin.tick.interval": "1s",  # checks whether an event loop is late
    "distributed.admin.system-monitor.interval": "5s",  # readings of processor and memory
}


def prepare_workers() -> None:
    """Start the process that workers are copied from; it imports while the client goes on.

    Only on Linux: other systems have no fork server, or libraries that must not be copied once
    they are loaded (macOS).
    """
    if sys.platform != "linux":
        return
    from multiprocessing import forkserver

    # Dask gives each worker one thread of BLAS, but only after the fork, which is too late
    threads = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    own = {name: "1" for name in threads if name not in os.environ}
    forkserver.set_forkserver_preload(
        ["distributed.nanny", "slipmode.runner.study.workers.foreman"]
    )
    os.environ.update(own)
    try:
        forkserver.ensure_running()
    finally:
        for name in own:
            del os.environ[name]


@contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """Yield a client of processes that work on tasks.

    Raises SlipmodeError if a scheduler does not answer, or has no workers.
    """
    distributed, config = extra("distributed", "study"), extra("dask.config", "study")
    settings = dict(SETTINGS)
    if sys.platform == "linux":
        settings["distributed.worker.multiprocessing-method"] = "forkserver"
    with _quiet(), config.set(settings):
        if scheduler is not None:
            with _connected(distributed, scheduler) as client:
                yield client
            return
        with (
            distributed.LocalCluster(
                n_workers=workers or os.cpu_count() or 1,
                threads_per_worker=1,
                dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            ) as local,
            distributed.Client(local) as client,
        ):
            yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress Dask's own page of messages about lost connections; an error of ours is raised."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _connected(distributed: Any, scheduler: str) -> Iterator[Any]:
    try:
        client = distributed.Client(scheduler, timeout=_ANSWERS, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise SlipmodeError(
            f"scheduler: {scheduler} does not answer ({one_line(error)}); start one with "
            "`dask scheduler`"
        ) from None
    with client:
        if not client.nthreads():
            _log.warning("waiting %.0f s for workers at %s", _ANSWERS, scheduler)
            try:
                client.wait_for_workers(1, timeout=_ANSWERS)
            except TimeoutError:
                raise SlipmodeError(
                    f"scheduler: {scheduler} has no workers; start one with "
                    f"`dask worker {scheduler}`"
                ) from None
        yield client
