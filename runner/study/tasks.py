"""Samples in batches, the samples of a batch on one model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipmode.runner.study.design import Design
from slipmode.runner.study.scene_keys import is_limit, is_load
from slipmode.runner.study.scene_model import Samples, without_loads

# Samples of a task. To hand a task out costs some ms, which is little per sample at these sizes
# (`make bench-study`); smaller ones spread the work better.
AT_ONCE = 500
_RUNS_AT_ONCE = 50
_RECORDINGS_AT_ONCE = 5
_BLOCK = 4096  # scenes in memory at once


@dataclass(frozen=True)
class Task:
    """Samples from `start` to before `stop`; `group` is the range of samples with their model."""

    start: int
    stop: int
    group: tuple[int, int]


def make_tasks(samples: Samples, design: Design) -> Iterator[Task]:
    """Yield all batches of a study, in the order of its samples."""
    outputs = samples.outputs
    most = AT_ONCE
    if outputs.recording:
        most = _RECORDINGS_AT_ONCE
    elif outputs.runs:
        most = _RUNS_AT_ONCE
    starts = [*np.flatnonzero(_changes(samples, design)).tolist(), design.samples]
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
        for first in range(0, design.samples, _BLOCK):
            block = design.part(slice(first, first + _BLOCK))
            for k, content in enumerate(samples.contents(block), start=first):
                now = without_loads(content)
                changes[k] |= now != before
                before = now
    return changes
