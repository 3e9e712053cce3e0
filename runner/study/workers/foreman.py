"""The tasks of a study, handed out to workers; their results."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass, replace
from itertools import pairwise
from logging.handlers import BufferingHandler
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import Model
from slipmode.rom.arrays import Flags
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.messages import one_line, warnings_to
from slipmode.runner.study.compute import compute
from slipmode.runner.study.design import Design
from slipmode.runner.study.mistuned_samples import compute_mistuned
from slipmode.runner.study.sample_outputs import Batch
from slipmode.runner.study.scene_keys import is_load
from slipmode.runner.study.scene_model import Samples, SceneModel, without_loads

# Samples of a task. To hand a task out costs some ms, which is little per sample at these sizes
# (`make bench-study`); smaller ones spread the work better.
AT_ONCE = 500


@dataclass(frozen=True, eq=False)
class Task:
    """Samples that are computed together, on one friction table."""

    samples: NDArray[np.intp]  # Their numbers
    group: tuple[int, int]  # The range of samples with their model
    step: int = 0  # The table, see `SceneModel.model`
    repeated: bool = False  # Whether it is computed again after a worker was killed


def make_tasks(samples: Samples, design: Design, missing: Flags) -> Iterator[Task]:
    """Yield tasks of all samples that have no results yet, in their order."""
    outputs = samples.outputs
    most = 5 if outputs.recording else 50 if outputs.runs or outputs.mistuned else AT_ONCE
    changes = [0] if outputs.mistuned else _changes(samples, design)
    for first, end in pairwise([*changes, design.samples]):
        numbers = first + np.flatnonzero(missing[first:end])
        for start in range(0, numbers.size, most):
            yield Task(numbers[start : start + most], (first, end))


def _changes(samples: Samples, design: Design) -> list[int]:
    """Return which samples have another model than the sample before."""
    differs = np.zeros(design.samples, dtype=bool)
    differs[0] = True
    for key, column in zip(design.keys, design.columns, strict=True):
        if not is_load(key):
            differs[1:] |= [bool(a != b) for a, b in zip(column[1:], column[:-1], strict=True)]
    changes, before = [], None
    for k in np.flatnonzero(differs).tolist():  # other limits may have the same model
        (content,) = samples.contents(design.part(slice(k, k + 1)))
        now = without_loads(content)
        if now != before:
            changes.append(k)
        before = now
    return changes


@dataclass(frozen=True)
class Workers:
    """Processes that compute tasks, on this machine or on others.

    `submit` takes a function and its arguments. The future has the exception of the function,
    BrokenExecutor if a worker was killed, CancelledError if the connection was lost.
    """

    submit: Callable[..., Future[Any]]
    count: int


@dataclass(frozen=True, eq=False)
class _Noted:
    """The value of a function, and the warnings that it issued."""

    value: Any
    warnings: frozenset[str]


class Foreman:
    """Hands out tasks, repeats samples on larger friction tables, and passes on what is done."""

    def __init__(self, workers: Workers, samples: Samples, design: Design) -> None:
        self._workers = workers
        self._samples = samples
        self._design = design
        # per group of samples and step: future of the SceneModel and the Model, see `_table`
        self._tables: dict[tuple[tuple[int, int], int], Future[Any]] = {}
        self._waiting: dict[Future[Any], list[Task]] = {}  # tasks by the future they wait for
        self.lost = ""  # Why a task has no results, if that may be otherwise in another run
        self._warned: dict[str, tuple[str, int]] = {}

    @property
    def warnings(self) -> Iterable[tuple[str, int]]:
        """The first warning of each kind, and the number of samples with such a warning."""
        return self._warned.values()

    def work_on(self, tasks: Iterable[Task]) -> Iterator[tuple[NDArray[np.intp], Batch]]:
        """Yield numbers of samples with their results, as the workers complete them.

        Tasks that fail because of disk, memory or workers are left out, see `lost`.

        Raises SlipmodeError if the connection to the workers is lost.
        """
        # enough that no worker waits, few enough for memory
        most = 3 * max(2, self._workers.count)
        for task in tasks:
            self._start(task)
            groups = {each.group for at_work in self._waiting.values() for each in at_work}
            self._tables = {key: each for key, each in self._tables.items() if key[0] in groups}
            while sum(map(len, self._waiting.values())) >= most:
                yield from self._collect()
        while self._waiting:
            yield from self._collect()

    def _start(self, task: Task) -> None:
        """Let a task wait for its friction table, which all tasks of its group share."""
        if self._samples.outputs.mistuned:
            self._submit(task, _compute_mistuned, self._samples)
            return
        key = task.group, task.step
        if key not in self._tables:
            shared = self._tables[task.group, 0].result()[0] if task.step else None
            of_group = self._design.part(slice(*task.group))
            self._tables[key] = self._workers.submit(
                _table, shared, self._samples, of_group, task.step
            )
        self._waiting.setdefault(self._tables[key], []).append(task)

    def _submit(self, task: Task, function: Callable[..., Any], *arguments: Any) -> None:
        """Let a task wait for its results."""
        part = self._design.part(task.samples)
        self._waiting[self._workers.submit(_noted, function, *arguments, part)] = [task]

    def _collect(self) -> Iterator[tuple[NDArray[np.intp], Batch]]:
        """Yield the next results, if there are any; submit tasks whose tables are there."""
        for future in wait(self._waiting, return_when=FIRST_COMPLETED).done:
            error = future.exception()
            for task in self._waiting.pop(future):
                if isinstance(error, CancelledError):
                    raise SlipmodeError(
                        "scheduler: the connection is lost; repeat the command to continue; the "
                        "samples computed so far are kept"
                    )
                # once more, unless the task itself may be what takes the memory
                if isinstance(error, BrokenExecutor) and not (task.repeated or self.lost):
                    if self._tables.get((task.group, task.step)) is future:
                        del self._tables[task.group, task.step]
                    self._start(replace(task, repeated=True))
                elif isinstance(error, BrokenExecutor):
                    self.lost = "a worker was killed, perhaps because memory was short"
                elif isinstance(error, OSError | MemoryError):
                    self.lost = one_line(error)
                elif error is not None:
                    outputs, count = self._samples.outputs, task.samples.size
                    batch = Batch.empty(outputs, self._samples.modes, count)
                    batch.reason[:] = [one_line(error)] * count
                    yield task.samples, batch
                elif future is self._tables.get((task.group, task.step)):
                    self._submit(task, _compute, *future.result(), task.samples)
                else:
                    yield self._finish(task, future.result())

    def _finish(self, task: Task, noted: _Noted) -> tuple[NDArray[np.intp], Batch]:
        """Return the results on a table; repeat samples outside it on the next."""
        batch, may_grow = noted.value
        outside = batch.outside
        if not may_grow or task.step >= 10:  # the range is then 1024 times the plan's range
            why = "the amplitudes grow without bound; give structure.damping a value > 0"
            for place in np.flatnonzero(outside):
                own = f"{batch.reason[place]}; leave out model.amplitude to find it"
                batch.reason[place] = f"forcing: {why}" if may_grow else own
            outside = np.zeros_like(outside)
        elif outside.any():
            self._start(replace(task, samples=task.samples[outside], step=task.step + 1))
        inside = np.flatnonzero(~outside)
        self._count(noted.warnings, inside.size)
        return task.samples[inside], batch.part(inside)

    def _count(self, warnings: Iterable[str], samples: int) -> None:
        """Add warnings of samples. Equal words before the colon make one kind of warning."""
        for kind, line in {each.split(": ")[0]: each for each in sorted(warnings)}.items():
            first, count = self._warned.get(kind, (line, 0))
            self._warned[kind] = first, count + samples


def _noted(function: Callable[..., Any], *arguments: Any) -> _Noted:
    """Return the value of a function with its warnings and the warnings of its arguments."""
    kept = BufferingHandler(sys.maxsize)
    with warnings_to(kept):
        value = function(*(each.value if isinstance(each, _Noted) else each for each in arguments))
    before = (each.warnings for each in arguments if isinstance(each, _Noted))
    return _Noted(value, frozenset(each.getMessage() for each in kept.buffer).union(*before))


def _table(
    shared: _Noted | None, samples: Samples, design: Design, step: int
) -> tuple[_Noted, _Noted]:
    """Return the SceneModel of samples, made if it is None, and its Model of a step."""
    shared = shared or _noted(SceneModel.of, samples, design)
    return shared, _noted(SceneModel.model, shared, step)


def _compute_mistuned(samples: Samples, design: Design) -> tuple[Batch, bool]:
    """Return the results of samples, which have no tables."""
    return compute_mistuned(samples, design), False


def _compute(
    shared: SceneModel, model: Model, numbers: NDArray[np.intp], design: Design
) -> tuple[Batch, bool]:
    """Return the results of samples, and whether there are larger tables."""
    with np.errstate(all="ignore"):
        scenes = shared.samples.scenes(design)
        return compute(shared, model, scenes, numbers.tolist()), shared.may_grow
