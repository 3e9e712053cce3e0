"""A scripted scalar: a force amplitude, frequency or phase over slow time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError


@dataclass(frozen=True)
class Script:
    """A piecewise linear function of time, constant before and after its breakpoints.

    Two breakpoints at the same time are a jump, at which the function has the second value. Raises
    SlipmodeError if there is no breakpoint, they are unsorted, or three have the same time.
    """

    times: tuple[float, ...]  # Breakpoint times [s], ascending, each at most twice
    values: tuple[float, ...]  # The value at each breakpoint

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.values):
            raise SlipmodeError("must have at least one breakpoint [t, value]")
        for earlier, later in pairwise(self.times):
            if later < earlier:
                raise SlipmodeError(
                    f"breakpoints must be sorted in time, got t = {later:g} after {earlier:g}"
                )
        for first, third in zip(self.times, self.times[2:], strict=False):
            if first == third:
                raise SlipmodeError(
                    f"must have at most two breakpoints (a jump) at one time, t = {first:g}"
                )
        if len(self.times) > 1 and not np.isfinite(self._slopes).all():
            raise SlipmodeError(
                "breakpoints must be further apart in time for this change of value"
            )

    @classmethod
    def constant(cls, value: float) -> Self:
        """Return the script with the same value at all times."""
        return cls((0.0,), (value,))

    @classmethod
    def through(cls, breakpoints: Sequence[Sequence[float]]) -> Self:
        """Return the script through [[t, value], ...]."""
        return cls(tuple(t for t, _ in breakpoints), tuple(value for _, value in breakpoints))

    def scaled(self, factor: float) -> Self:
        """Return the script with all values times a factor."""
        if factor == 1.0:
            return self
        return replace(self, values=tuple(factor * value for value in self.values))

    def value(self, t: ArrayLike) -> Floats:
        """Return the value at times `t`, after a jump; in the shape of `t`."""
        return self._at(t, "right")

    def value_before(self, t: ArrayLike) -> Floats:
        """Return the limit from the left at `t`; it differs from `value` at jumps only."""
        return self._at(t, "left")

    def rate(self, t: ArrayLike) -> Floats:
        """Return the slope just after `t` [1/s], without jumps; in the shape of `t`."""
        return np.asarray(self._slopes[np.searchsorted(self._points[0], t, side="right")])

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """The times at which the value jumps or the slope changes, ascending."""
        points = self._points[0]
        times = np.unique(points)
        before = self._slopes[np.searchsorted(points, times, side="left")]
        after = self._slopes[np.searchsorted(points, times, side="right")]
        pairs = pairwise(zip(self.times, self.values, strict=True))
        jumps = {t for (t, v), (u, w) in pairs if t == u and v != w}
        return tuple(sorted({*times[before != after].tolist(), *jumps}))

    def range(self, t0: float, t1: float) -> tuple[float, float]:
        """Return the least and the greatest value on [t0, t1], both sides of jumps included."""
        inside = [v for t, v in zip(self.times, self.values, strict=True) if t0 < t <= t1]
        reached = [float(self.value(t0)), *inside, float(self.value(t1))]
        return min(reached), max(reached)

    @cached_property
    def _points(self) -> tuple[Floats, Floats]:
        return np.array(self.times, dtype=float), np.array(self.values, dtype=float)

    @cached_property
    def _slopes(self) -> Floats:
        """The slope of each segment and of both constant ends; 0 for a jump."""
        with np.errstate(over="ignore", invalid="ignore"):
            runs, rises = (np.diff(part) for part in self._points)
            inner = np.divide(rises, runs, out=np.zeros_like(rises), where=runs > 0.0)
        return np.concatenate(([0.0], inner, [0.0]))

    def _at(self, t: ArrayLike, side: Literal["left", "right"]) -> Floats:
        """Interpolate in the segment of the points next to `t` on a side."""
        if len(self.times) == 1:  # as in most of the many samples of a study
            return np.full(np.shape(t), self.values[0])
        times, values = self._points
        segment = np.searchsorted(times, t, side=side)
        start = np.maximum(segment - 1, 0)
        return np.asarray(values[start] + self._slopes[segment] * (np.asarray(t) - times[start]))
