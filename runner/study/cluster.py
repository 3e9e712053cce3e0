"""Tasks on the processes of a Dask cluster: a local one, or any whose scheduler has an address."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import Model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.runner.study.design import Design
from slipmode.runner.study.outputs.batch import Batch, compute
from slipmode.runner.study.scene_keys import Content
from slipmode.runner.study.scene_model import (
    MOST_STEPS,
    Samples,
    SceneModel,
    said,
    step_refusal,
    typical,
)
from slipmode.runner.study.tasks import Task

_log = logging.getLogger("slipmode.study")

_ANSWERS = 10.0  # [s] in which a scheduler has to, and workers have to connect
_PER_WORKER = 3  # tasks
# Of processes that are started here: what Dask keeps and looks at for its developers.
SETTINGS: dict[str, Any] = {
    "distributed.admin.low-level-log-length": 10,  # messages, tasks and results in them; not 1000
    "distributed.worker.profile.enabled": False,  # a thread that stops tasks 100 times a second
    "distributed.admin.tick.interval": "1s",  # of looks whether a loop is late; not 20 ms
    "distributed.admin.system-monitor.interval": "5s",  # of looks at processors; not 500 ms
}
# What workers import, and that BLAS has a thread in each, as Dask has it.
_PRELOADED = ["distributed.nanny", "slipmode.runner.study.cluster"]
_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")
# Elsewhere there is none, or system libraries (macOS) that may not be copied once they are loaded.
_FORKSERVER = sys.platform == "linux"


def prepare_workers() -> None:
    """Start to import what workers need, once for all of them, while the client does other things.

    In a process of its own that is copied for each (on Linux; elsewhere each imports it).
    """
    if not _FORKSERVER:
        return
    from multiprocessing import forkserver

    own = {name: "1" for name in _THREADS if name not in os.environ}
    forkserver.set_forkserver_preload(_PRELOADED)
    os.environ.update(own)
    try:
        forkserver.ensure_running()
    finally:
        for name in own:
            del os.environ[name]


@contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """A client of processes that work on tasks.

    Raises
    ------
    SlipmodeError
        If a scheduler does not answer, or has nobody to work.
    """
    distributed, config = extra("distributed", "study"), extra("dask.config", "study")
    settings = dict(SETTINGS)
    if _FORKSERVER:
        settings["distributed.worker.multiprocessing-method"] = "forkserver"
        distributed.utils._forkserver_preload_set = True  # it would import pandas, here and there
    with _quiet(), config.set(settings):
        yield from _client(distributed, workers, scheduler)


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Dask's own words of what is lost, which are a page: there is a line of ours."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _client(distributed: Any, workers: int | None, scheduler: str | None) -> Iterator[Any]:
    if scheduler is None:
        count = workers or os.cpu_count() or 1
        with (
            distributed.LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            ) as local,
            distributed.Client(local) as client,
        ):
            yield client
        return
    try:
        client = distributed.Client(scheduler, timeout=_ANSWERS, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise SlipmodeError(
            f"scheduler: {scheduler} does not answer ({said(error)}); `dask scheduler` starts one"
        ) from None
    with client:
        if not client.nthreads():
            _log.warning("waiting %.0f s for workers at %s", _ANSWERS, scheduler)
            try:
                client.wait_for_workers(1, timeout=_ANSWERS)
            except TimeoutError:
                raise SlipmodeError(
                    f"scheduler: {scheduler} has no workers; `dask worker {scheduler}` starts one"
                ) from None
        yield client


@dataclass(eq=False)
class _Group:
    """Samples of one model, while some of them are at work.

    Attributes
    ----------
    shared : future of _Shared
    models : list of future of Model
        Of each step of the ladder that a sample has asked for.
    working : int
        Tasks of it.
    """

    shared: Any
    models: list[Any] = field(default_factory=list)
    working: int = 0


@dataclass(frozen=True, eq=False)
class _Work:
    """Samples of a task that are at work on a step of the ladder.

    Attributes
    ----------
    task : Task
    batch : Batch
        What is known of all its samples.
    places : sequence of int
        Of the samples at work in the task.
    step : int
        The last that they try.
    """

    task: Task
    batch: Batch
    places: Sequence[int]
    step: int = 0


@dataclass(frozen=True, eq=False)
class _Shared:
    """What all samples of a group have: handed to each worker once, not with each task."""

    samples: Samples
    modes: Sequence[str]
    scene_model: SceneModel


@dataclass(frozen=True, eq=False)
class _Portion:
    """Samples at work: the value of each key and their numbers, as arrays.

    In lists and tuples of numbers Dask would look for futures, one by one, and keep each.
    """

    columns: tuple[NDArray[Any], ...]
    numbers: NDArray[np.intp]


class Foreman:
    """Hands out tasks, sends samples up the ladder of tables, and passes on what is finished.

    Parameters
    ----------
    client : distributed.Client
    samples : Samples
    design : Design
    modes : sequence of str
        Of the scene.
    """

    def __init__(
        self, client: Any, samples: Samples, design: Design, modes: Sequence[str]
    ) -> None:
        self._client = client
        self._samples = samples
        self._design = design
        self._modes = modes
        self._groups: dict[tuple[int, int], _Group] = {}
        self._at_work: dict[str, _Work] = {}

    def work_on(self, tasks: Iterable[Task], finished: Callable[[Task, Batch], None]) -> None:
        """All tasks; `finished` is called as each is.

        Raises
        ------
        SlipmodeError
            If the scheduler is lost, and whatever `finished` raises.
        """
        completed = extra("distributed", "study").as_completed(loop=self._client.loop)
        most = most_at_once(self._client)
        for task in tasks:
            count = task.stop - task.start
            batch = Batch.empty(self._samples, self._modes, count)
            completed.add(self._submit(_Work(task, batch, range(count))))
            for other in [key for key, group in self._groups.items() if not group.working]:
                del self._groups[other]
            while len(self._at_work) >= most:
                self._take(completed, finished)
        while self._at_work:
            self._take(completed, finished)

    def _submit(self, work: _Work) -> Any:
        task, submit = work.task, partial(self._client.submit, pure=False)
        group = self._groups.get(task.group)
        if group is None:
            columns = [column[slice(*task.group)] for column in self._design.columns]
            contents, frequencies = typical(self._samples, columns)
            shared = submit(_share, self._samples, self._modes, contents, frequencies)
            group = self._groups[task.group] = _Group(shared)
        while len(group.models) <= work.step:
            group.models.append(submit(_model, group.shared, len(group.models)))
        numbers = task.start + np.array(work.places)
        portion = _Portion(tuple(column[numbers] for column in self._design.columns), numbers)
        models = [group.models[work.step], *_made(group.models[work.step + 1 :])]
        future = submit(_compute, group.shared, models, portion)
        group.working += 1
        self._at_work[future.key] = replace(work, step=work.step + len(models) - 1)
        return future

    def _take(self, completed: Any, finished: Callable[[Task, Batch], None]) -> None:
        """What has become of samples: finished, or sent up the ladder."""
        future = next(completed)
        work = self._at_work.pop(future.key)
        outside: list[int] = []
        if future.status == "finished":
            outside = _merge(work, *future.result())
        elif future.status == "error":
            for place in work.places:
                work.batch.reason[place] = said(future.exception())
        else:
            raise SlipmodeError(
                "scheduler: was lost; what was computed stays, and the same command goes on "
                "from there"
            )
        if outside:
            completed.add(self._submit(replace(work, places=outside, step=work.step + 1)))
        else:
            finished(work.task, work.batch)
        self._groups[work.task.group].working -= 1


def most_at_once(client: Any) -> int:
    """Tasks that wait or run: enough that no worker is idle, few enough for memory."""
    return _PER_WORKER * max(2, len(client.nthreads()))


def _made(models: Sequence[Any]) -> Sequence[Any]:
    """The first of them, up to one that is not there, or never will be."""
    return list(takewhile(lambda model: model.status == "finished", models))


def _merge(work: _Work, found: Batch, may_grow: bool) -> list[int]:
    """Put results of samples in their places; the places of those for a larger table."""
    work.batch.put(work.places, found)
    outside = [place for place in work.places if work.batch.outside[place]]
    if may_grow and work.step < MOST_STEPS:
        return outside
    for place in outside:
        work.batch.reason[place] = step_refusal(may_grow, work.batch.reason[place])
    return []


def _share(
    samples: Samples, modes: Sequence[str], contents: list[Content], frequencies: dict[str, Any]
) -> _Shared:
    return _Shared(samples, modes, SceneModel.of(samples, contents, frequencies))


def _model(shared: _Shared, step: int) -> Model:
    return shared.scene_model.model(step)


def _compute(shared: _Shared, models: Sequence[Model], portion: _Portion) -> tuple[Batch, bool]:
    """Results, each of the first model that holds it; whether there may be larger tables."""
    samples, scene_model = shared.samples, shared.scene_model
    rows = Design(samples.keys, portion.columns).rows(slice(None))
    scenes, numbers = samples.scenes(rows), portion.numbers.tolist()
    batch = Batch.empty(samples, shared.modes, len(rows))
    batch.outside[:] = True
    with np.errstate(all="ignore"):
        for model in models:
            places = np.flatnonzero(batch.outside).tolist()
            if not places:
                break
            some = [scenes[k] for k in places], [numbers[k] for k in places]
            batch.put(places, compute(samples, shared.modes, scene_model, model, *some))
    return batch, scene_model.may_grow
