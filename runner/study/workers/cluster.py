"""Workers of a Dask scheduler that has an address."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import contextmanager
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.runner.messages import one_line
from slipmode.runner.study.workers.foreman import Workers

_log = logging.getLogger("slipmode.study")

_ANSWERS = 10.0  # [s] in which a scheduler has to answer, and workers have to connect


@contextmanager
def dask_workers(scheduler: str) -> Iterator[Workers]:
    """Yield the workers of a scheduler.

    Raises SlipmodeError if the scheduler does not answer, or has no workers.
    """
    distributed = extra("distributed", "dask")
    with _quiet():
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

            def submit(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
                found: Future[Any] = Future()
                of_dask = client.submit(function, *arguments, pure=False)
                of_dask.add_done_callback(lambda done: _pass_on(done, found))
                return found

            yield Workers(submit, len(client.nthreads()))


def _pass_on(done: Any, found: Future[Any]) -> None:
    """Give the result of a Dask future to another future.

    A killed worker is a BrokenExecutor, as of a pool of processes; a lost connection cancels.
    """
    try:
        error = done.exception() if done.status == "error" else None
        if error is None:
            found.set_result(done.result())
        elif isinstance(error, extra("distributed", "dask").KilledWorker):
            found.set_exception(BrokenExecutor())
        else:
            found.set_exception(error)
    except (OSError, CancelledError):
        found.set_exception(CancelledError())


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
