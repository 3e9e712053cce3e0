"""Samples in batches, those of a batch on one model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.runner.study.design import Design
from slipmode.runner.study.scene_keys import is_load
from slipmode.runner.study.scene_model import Samples, model_of
from slipmode.runner.study.shared_limits import is_limit

# Samples of a task: what it costs to hand it out, some ms, is then little for each.
AT_ONCE = 500
_RUNS_AT_ONCE = 50
_RECORDINGS_AT_ONCE = 5
_BLOCK = 4096


@dataclass(frozen=True)
class Task:
    """Samples from `start` to before `stop`, of the group that starts and ends there."""

    start: int
    stop: int
    group: tuple[int, int]


def make_tasks(samples: Samples, design: Design) -> Iterator[Task]:
    """All batches of a study, in the order of its samples."""
    asked = samples.asked
    most = _RECORDINGS_AT_ONCE if asked.recording else _RUNS_AT_ONCE if asked.runs else AT_ONCE
    starts = np.append(_starts(samples, design), design.samples)
    for first, end in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        for start in range(first, end, most):
            yield Task(start, min(start + most, end), (first, end))


def _starts(samples: Samples, design: Design) -> NDArray[np.intp]:
    """Samples whose model is not that of the one before."""
    changes = np.zeros(design.samples, dtype=bool)
    changes[0] = True
    limits = False
    for key, column in zip(design.keys, design.columns, strict=True):
        if is_limit(key):
            limits = True
        elif not is_load(key):
            changes[1:] |= [bool(a != b) for a, b in zip(column[1:], column[:-1], strict=True)]
    if limits:
        changes |= _other_limits(samples, design)
    return np.flatnonzero(changes)


def _other_limits(samples: Samples, design: Design) -> NDArray[np.bool_]:
    """Samples whose limits are no multiple of those before, or that tables do not scale with."""
    other = np.zeros(design.samples, dtype=bool)
    before = None
    for first in range(0, design.samples, _BLOCK):  # of all at once there may be too many
        block = slice(first, min(first + _BLOCK, design.samples))
        for k, content in enumerate(samples.contents(design.rows(block)), start=first):
            now = model_of(content)
            other[k] = now != before
            before = now
    return other
