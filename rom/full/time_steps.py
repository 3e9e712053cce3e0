"""Equal time steps from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen

_ROUNDING = 1e-9  # distance of equal times, relative to a step
_MOST_STEPS = 1e12


@dataclass(frozen=True)
class Run:
    """`samples` times `every` equal steps inside one segment of the excitation."""

    segment: int
    begin: float  # [s]
    step: float  # [s]
    samples: int
    every: int
    sampled: bool  # False if it ends at the start of a segment that is no sample time


@frozen
class Schedule:
    """The runs through all samples."""

    time: Floats  # (samples,) [s]
    samples_start: bool  # whether the first sample is the start itself
    runs: list[Run]

    @classmethod
    def plan(
        cls, time: Floats, begin: float, longest: float, segments: Floats, refine: int = 1
    ) -> Self:
        """Schedule steps of at most `longest` [s] from `begin`, each divided by `refine`.

        `time` are sample times (samples,), or the end (), for a sample at every undivided step. No
        step crosses the start of a segment of the excitation (segments,).
        """
        end = float(time.max())
        if (end - begin) / longest > _MOST_STEPS:
            raise SlipmodeError(
                f"step: must reach the end in at most {_MOST_STEPS:g} steps, got {longest:g} s"
            )
        inside = segments[(segments > begin) & (segments < end)]
        if time.ndim == 0:
            parts = [
                np.linspace(a, b, _steps(b - a, longest) + 1)[1:]
                for a, b in pairwise([begin, *inside.tolist(), end])
            ]
            time = np.concatenate([[begin], *parts])
        rounding = _ROUNDING * longest
        samples_start = bool(time[0] - begin <= rounding)
        ahead = time[1:] if samples_start else time
        next_sample = np.append(ahead, np.inf)[np.searchsorted(ahead, inside - rounding)]
        ends = np.concatenate((ahead, inside[next_sample > inside + rounding]))
        order = np.argsort(ends, kind="stable")
        knots, is_sample = np.append(begin, ends[order]), order < ahead.size
        segment = np.searchsorted(segments, 0.5 * (knots[:-1] + knots[1:])) - 1
        runs = []
        for i, j in _equal_stretches(knots, is_sample, segment):
            begin, stretch = float(knots[i]), float(knots[j] - knots[i]) / (j - i)
            every = _steps(stretch, longest) * refine
            step, sampled = stretch / every, bool(is_sample[i])
            runs.append(Run(int(segment[i]), begin, step, j - i, every, sampled))
        return cls(time, samples_start, runs)


def _equal_stretches(
    knots: Floats, is_sample: np.ndarray, segment: np.ndarray
) -> list[tuple[int, int]]:
    """Return first and last knot of successive equal stretches of one segment between samples."""
    length = np.diff(knots)
    rounding = _ROUNDING * length[1:] + 8 * np.finfo(float).eps * np.abs(knots[1:-1])
    joins = (
        (np.abs(np.diff(length)) <= rounding)
        & (np.diff(segment) == 0)
        & is_sample[1:]
        & is_sample[:-1]
    )
    ends = [0, *(np.flatnonzero(~joins) + 1).tolist(), length.size]
    return [(i, j) for i, j in pairwise(ends) if j > i]


def _steps(duration: float, longest: float) -> int:
    """Return the least number of steps not above `longest`, but for rounding."""
    return max(int(np.ceil(duration / longest * (1 - _ROUNDING))), 1)


def checked_times(times: ArrayLike, begin: float, excitation_start: float) -> Floats:
    """Return sample times (samples,), or the end (), that a motion from `begin` can have."""
    time = np.asarray(times, dtype=float)
    if time.size == 0 or time.ndim > 1 or not np.all(np.isfinite(time)):
        raise SlipmodeError("times: must be finite, increasing numbers, or the end [s]")
    if np.any(np.diff(np.atleast_1d(time)) <= 0):
        raise SlipmodeError("times: must be increasing")
    if not begin >= excitation_start:
        raise SlipmodeError(
            f"start: must not lie before the excitation starts, {excitation_start:g} s"
        )
    if time.min() < begin or (time.ndim == 0 and time <= begin):
        raise SlipmodeError(f"times: must not lie before the start, {begin:g} s")
    return time
