"""The tasks of a study, handed out to a Dask client; their results."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from logging.handlers import BufferingHandler
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import Model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.runner.messages import one_line, warnings_to
from slipmode.runner.study.compute import compute
from slipmode.runner.study.design import Design
from slipmode.runner.study.mistuned_samples import compute_mistuned
from slipmode.runner.study.sample_outputs import Batch
from slipmode.runner.study.scene_keys import is_limit, is_load
from slipmode.runner.study.scene_model import Samples, SceneModel, without_loads

# Samples of a task. To hand a task out costs some ms, which is little per sample at these sizes
# (`make bench-study`); smaller ones spread the work better.
AT_ONCE = 500


@dataclass(frozen=True)
class Task:
    """Samples from `start` to before `stop`; `group` is the range of samples with their model."""

    start: int
    stop: int
    group: tuple[int, int]


def make_tasks(samples: Samples, design: Design) -> Iterator[Task]:
    """Yield all batches of a study, in the order of its samples."""
    outputs = samples.outputs
    most = 5 if outputs.recording else 50 if outputs.runs or outputs.mistuned else AT_ONCE
    changes = [0] if outputs.mistuned else np.flatnonzero(_changes(samples, design)).tolist()
    starts = [*changes, design.samples]
    for first, end in pairwise(starts):
        for start in range(first, end, most):
            yield Task(start, min(start + most, end), (first, end))


def _changes(samples: Samples, design: Design) -> NDArray[np.bool_]:
    """Return which samples have another model than the sample before."""
    changes = np.zeros(design.samples, dtype=bool)
    changes[0] = True
    for key, column in zip(design.keys, design.columns, strict=True):
        if not (is_limit(key) or is_load(key)):
            changes[1:] |= [bool(a != b) for a, b in zip(column[1:], column[:-1], strict=True)]
    if any(map(is_limit, design.keys)):
        # only a common factor on all limits keeps the model
        before = None
        for first in range(0, design.samples, 4096):  # scenes in memory at once
            block = design.part(slice(first, first + 4096))
            for k, content in enumerate(samples.contents(block), start=first):
                now = without_loads(content)
                changes[k] |= now != before
                before = now
    return changes


@dataclass(frozen=True, eq=False)
class _Work:
    """Samples of a task that a worker computes."""

    task: Task
    batch: Batch  # The results of all samples of the task so far
    places: Sequence[int]  # The samples at work, by their places in the task
    step: int = 0  # The friction table that they are computed on, see `SceneModel.model`


@dataclass(frozen=True, eq=False)
class _Noted:
    """The value of a function, and the warnings that it issued."""

    value: Any
    warnings: frozenset[str]


class Foreman:
    """Hands out tasks, repeats samples on larger friction tables, and passes on what is done."""

    def __init__(self, client: Any, samples: Samples, design: Design) -> None:
        self._client = client
        self._samples = samples
        self._design = design
        # per group of samples: futures of their SceneModel, and of its models from step to step
        self._shared: dict[tuple[int, int], list[Any]] = {}
        self._at_work: dict[str, _Work] = {}
        self.lost = ""  # Why a task has no results, if that may be otherwise in another run
        self._warned: dict[str, tuple[str, int]] = {}

    @property
    def warnings(self) -> Iterable[tuple[str, int]]:
        """The first warning of each kind, and the number of samples with such a warning."""
        return self._warned.values()

    def work_on(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, Batch]]:
        """Yield each task with its results, as the `distributed.Client` completes them.

        Tasks that fail because of disk, memory or workers are left out, see `lost`.

        Raises SlipmodeError if the connection to the scheduler is lost.
        """
        completed = extra("distributed", "study").as_completed(loop=self._client.loop)
        # enough that no worker waits, few enough for memory
        most = 3 * max(2, len(self._client.nthreads()))
        for task in tasks:
            count = task.stop - task.start
            batch = Batch.empty(self._samples.outputs, self._samples.modes, count)
            completed.add(self._submit(_Work(task, batch, range(count))))
            groups = {work.task.group for work in self._at_work.values()}
            self._shared = {k: each for k, each in self._shared.items() if k in groups}
            while len(self._at_work) >= most:
                yield from self._collect(completed)
        while self._at_work:
            yield from self._collect(completed)

    def _submit(self, work: _Work) -> Any:
        submit, group = partial(self._client.submit, _noted, pure=False), work.task.group
        numbers = work.task.start + np.array(work.places)
        part = self._design.part(numbers)
        if self._samples.outputs.mistuned:
            future = submit(_compute_mistuned, self._samples, part)
            self._at_work[future.key] = work
            return future
        if group not in self._shared:
            of_group = self._design.part(slice(*group))
            self._shared[group] = [submit(SceneModel.of, self._samples, of_group)]
        futures = self._shared[group]
        while len(futures) < work.step + 2:
            futures.append(submit(SceneModel.model, futures[0], len(futures) - 1))
        future = submit(_compute, futures[0], futures[work.step + 1], part, numbers)
        self._at_work[future.key] = work
        return future

    def _collect(self, completed: Any) -> Iterator[tuple[Task, Batch]]:
        """Yield the next result, if there is one; repeat samples outside the table on the next."""
        future = next(completed)
        work = self._at_work.pop(future.key)
        outside: list[int] = []
        if future.status == "finished":
            try:
                noted = future.result()
            except OSError as reason:  # the connection broke after the task was finished
                raise _lost_connection() from reason
            found, may_grow = noted.value
            work.batch.put(work.places, found)
            outside = [place for place in work.places if work.batch.outside[place]]
            if not may_grow or work.step >= 10:  # the range is then 1024 times that of the plan
                why = "the amplitudes grow without bound; give structure.damping a value > 0"
                for place in outside:
                    own = f"{work.batch.reason[place]}; leave out model.amplitude to find it"
                    work.batch.reason[place] = f"forcing: {why}" if may_grow else own
                outside = []
            self._count(noted.warnings, len(work.places) - len(outside))
        elif future.status == "error":
            error, distributed = future.exception(), extra("distributed", "study")
            if isinstance(error, OSError | MemoryError | distributed.KilledWorker):
                self.lost = one_line(error)
                return
            for place in work.places:
                work.batch.reason[place] = one_line(error)
        else:
            raise _lost_connection()
        if outside:
            completed.add(self._submit(replace(work, places=outside, step=work.step + 1)))
        else:
            yield work.task, work.batch

    def _count(self, warnings: Iterable[str], samples: int) -> None:
        """Add warnings of samples. Equal words before the colon make one kind of warning."""
        for kind, line in {each.split(": ")[0]: each for each in sorted(warnings)}.items():
            first, count = self._warned.get(kind, (line, 0))
            self._warned[kind] = first, count + samples


def _lost_connection() -> SlipmodeError:
    goes_on = "repeat the command to continue; the samples computed so far are kept"
    return SlipmodeError(f"scheduler: the connection is lost; {goes_on}")


def _noted(function: Callable[..., Any], *arguments: Any) -> _Noted:
    """Return the value of a function with its warnings and the warnings of its arguments."""
    kept = BufferingHandler(sys.maxsize)
    with warnings_to(kept):
        value = function(*(each.value if isinstance(each, _Noted) else each for each in arguments))
    before = (each.warnings for each in arguments if isinstance(each, _Noted))
    return _Noted(value, frozenset(each.getMessage() for each in kept.buffer).union(*before))


def _compute_mistuned(samples: Samples, design: Design) -> tuple[Batch, bool]:
    """Return the results of samples, which have no tables."""
    return compute_mistuned(samples, design), False


def _compute(
    shared: SceneModel, model: Model, design: Design, numbers: NDArray[np.intp]
) -> tuple[Batch, bool]:
    """Return the results of samples, and whether there are larger tables."""
    with np.errstate(all="ignore"):
        scenes = shared.samples.scenes(design)
        return compute(shared, model, scenes, numbers.tolist()), shared.may_grow
