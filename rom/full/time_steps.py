"""Which equal time steps lead from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr

_ROUNDING = 1e-9  # times that differ by this fraction of a step are the same time
_MOST_STEPS = 1e12


@dataclass(frozen=True)
class Run:
    """Equal steps inside one segment of the excitation: `samples` times `every` of them.

    Attributes
    ----------
    segment : int
    begin : float
        [s]
    step : float
        [s]
    samples, every : int
    sampled : bool
        False if the run ends at the start of a segment, where no sample was asked for.
    """

    segment: int
    begin: float
    step: float
    samples: int
    every: int
    sampled: bool = True


@dataclass(frozen=True, eq=False)
class Schedule:
    """The runs that lead through all samples.

    Attributes
    ----------
    time : (samples,) ndarray
        [s]
    samples_start : bool
        Whether the first sample is the start itself.
    runs : list of Run
    """

    time: Floats
    samples_start: bool
    runs: list[Run]

    __repr__ = short_repr

    @classmethod
    def plan(
        cls, time: Floats, begin: float, longest: float, segments: Floats, refine: int = 1
    ) -> Self:
        """Schedule steps of at most `longest`, each divided by `refine`.

        Parameters
        ----------
        time : (samples,) ndarray, or () ndarray
            Sample times; or the end, for a sample at every undivided step.
        begin : float
            Time of the initial state [s].
        segments : (segments,) ndarray
            Where the segments of the excitation start; a step never crosses one.
        """
        if (time.max() - begin) / longest > _MOST_STEPS:
            raise SlipmodeError(
                f"step: must reach the end in {_MOST_STEPS:g} steps, {longest:g} s"
            )
        if time.ndim == 0:
            return cls._every_step(float(time), begin, longest, segments, refine)
        samples_start = bool(time[0] - begin <= _ROUNDING * longest)
        ahead = time[1:] if samples_start else time
        inside = segments[(segments > begin) & (segments < time[-1])]
        sampled = np.abs(_nearest(ahead, inside) - inside) <= _ROUNDING * longest
        knots = np.concatenate([[begin], ahead, inside[~sampled]])
        order = np.argsort(knots, kind="stable")
        is_sample = (order <= ahead.size)[order > 0]
        pieces = _group(knots[order], is_sample, segments)
        runs = [_run(piece, longest, refine) for piece in pieces]
        return cls(time, samples_start, runs)

    @classmethod
    def _every_step(
        cls, end: float, begin: float, longest: float, segments: Floats, refine: int
    ) -> Self:
        inside = segments[(segments > begin) & (segments < end)]
        knots = np.concatenate([[begin], inside, [end]])
        runs, times = [], [np.array([begin])]
        for first, last in pairwise(knots.tolist()):
            count = _steps(last - first, longest)
            segment = int(np.searchsorted(segments, 0.5 * (first + last))) - 1
            runs.append(Run(segment, first, (last - first) / (count * refine), count, refine))
            times.append(np.linspace(first, last, count + 1)[1:])
        return cls(np.concatenate(times), True, runs)


@dataclass(frozen=True)
class _Piece:
    """`samples` equal stretches of time from `begin` to `end`."""

    segment: int
    begin: float
    end: float
    samples: int
    sampled: bool


def _group(knots: Floats, is_sample: np.ndarray, segments: Floats) -> list[_Piece]:
    """Join successive stretches that are equally long, in one segment and end at samples."""
    length = np.diff(knots)
    segment = np.searchsorted(segments, 0.5 * (knots[:-1] + knots[1:])) - 1
    rounding = _ROUNDING * length[1:] + 8 * np.finfo(float).eps * np.abs(knots[1:-1])
    joins = (
        (np.abs(np.diff(length)) <= rounding)
        & (np.diff(segment) == 0)
        & is_sample[1:]
        & is_sample[:-1]
    )
    first = np.concatenate([[0], np.flatnonzero(~joins) + 1])
    last = np.append(first[1:], length.size)
    return [
        _Piece(int(segment[i]), float(knots[i]), float(knots[j]), int(j - i), bool(is_sample[i]))
        for i, j in zip(first, last, strict=True)
        if j > i
    ]


def _run(piece: _Piece, longest: float, refine: int) -> Run:
    stretch = (piece.end - piece.begin) / piece.samples
    every = _steps(stretch, longest) * refine
    return Run(piece.segment, piece.begin, stretch / every, piece.samples, every, piece.sampled)


def _steps(duration: float, longest: float) -> int:
    """Least number of steps not above `longest`, but for rounding."""
    return max(int(np.ceil(duration / longest * (1 - _ROUNDING))), 1)


def _nearest(sorted_values: Floats, points: Floats) -> Floats:
    """The value next to each point."""
    above = np.clip(np.searchsorted(sorted_values, points), 0, sorted_values.size - 1)
    below = np.clip(above - 1, 0, None)
    is_below = points - sorted_values[below] < sorted_values[above] - points
    return np.where(is_below, sorted_values[below], sorted_values[above])


def checked_times(times: ArrayLike, begin: float, excitation_start: float) -> Floats:
    """Sample times (samples,), or the end (), as an array that a motion from `begin` can have."""
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
