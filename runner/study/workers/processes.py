"""Processes on this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from slipmode.runner.study.workers.foreman import Workers

_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


@contextmanager
def processes(count: int | None) -> Iterator[Workers]:
    """Yield workers that are processes with one BLAS thread each, one per core by default."""
    count = count or os.cpu_count() or 1
    if sys.platform == "win32":
        count = min(count, 61)  # Windows waits for no more
    others = set(multiprocessing.active_children())
    threads = {name: "1" for name in _THREADS if name not in os.environ}
    os.environ.update(threads)  # BLAS of a new process reads it once it is loaded
    pool = _new_pool(count)

    def submit(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        nonlocal pool
        try:
            return pool.submit(function, *arguments)
        except BrokenExecutor:  # a killed process ends its pool
            pool = _new_pool(count)
            return pool.submit(function, *arguments)

    try:
        yield Workers(submit, count)
    except BaseException:
        # the pool itself would wait for tasks at work, which may take minutes
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        for name in threads:
            del os.environ[name]


def _new_pool(count: int) -> ProcessPoolExecutor:
    # Other systems have no fork server, or libraries that must not be copied once they are loaded
    # (macOS).
    context = multiprocessing.get_context("forkserver" if sys.platform == "linux" else "spawn")
    if sys.platform == "linux":
        context.set_forkserver_preload(["slipmode.runner.study.workers.foreman"])
    return ProcessPoolExecutor(count, context, _prepare_worker)


def _prepare_worker() -> None:
    """Leave interruptions to the client, and end with it even if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_client, daemon=True).start()


def _end_with_client() -> None:
    client = multiprocessing.parent_process()
    assert client is not None
    client.join()
    os._exit(1)
