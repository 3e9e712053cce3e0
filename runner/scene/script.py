"""A scripted scalar: a force amplitude, frequency or phase over slow time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal, Self, overload

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError


@dataclass(frozen=True)
class Script:
    """A piecewise linear function of time, constant before and after its breakpoints.

    Two breakpoints at the same time are a jump; the function is continuous from the right,
    so at the jump itself it has the second value.

    Attributes
    ----------
    times : tuple of float
        Breakpoint times [s], ascending, at most two alike.
    values : tuple of float
        The value at each breakpoint.

    Raises
    ------
    SlipmodeError
        If the breakpoints are none, unsorted or more than two at one time.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

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
                raise SlipmodeError(f"at most two breakpoints (a jump) at one time, t = {first:g}")
        if len(self.times) > 1 and not np.isfinite(self._slopes).all():
            raise SlipmodeError("breakpoints too close in time for the change between them")

    @classmethod
    def constant(cls, value: float) -> Self:
        """The same value at all times."""
        return cls((0.0,), (value,))

    @classmethod
    def through(cls, breakpoints: Sequence[Sequence[float]]) -> Self:
        """Through [[t, value], ...]."""
        return cls(tuple(t for t, _ in breakpoints), tuple(value for _, value in breakpoints))

    def scaled(self, factor: float) -> Self:
        """The same script of values that are a factor larger."""
        return (
            self if factor == 1.0 else replace(self, values=tuple(factor * v for v in self.values))
        )

    @overload
    def value(self, t: float) -> float: ...
    @overload
    def value(self, t: Floats) -> Floats: ...
    def value(self, t: float | Floats) -> float | Floats:
        """The value at `t`; right of the jump where there is one. Same shape as `t`."""
        return self._at(t, "right")

    @overload
    def value_before(self, t: float) -> float: ...
    @overload
    def value_before(self, t: Floats) -> Floats: ...
    def value_before(self, t: float | Floats) -> float | Floats:
        """The limit from the left at `t`; differs from `value` at a jump only."""
        return self._at(t, "left")

    @overload
    def rate(self, t: float) -> float: ...
    @overload
    def rate(self, t: Floats) -> Floats: ...
    def rate(self, t: float | Floats) -> float | Floats:
        """The slope just right of `t` [1/s]; jumps do not count. Same shape as `t`."""
        return _like(t, self._slopes[np.searchsorted(self._points[0], t, side="right")])

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """The times at which the value jumps or the slope changes, ascending."""
        times, points = np.unique(self._points[0]), self._points[0]
        before = self._slopes[np.searchsorted(points, times, side="left")]
        after = self._slopes[np.searchsorted(points, times, side="right")]
        return tuple(sorted({*times[before != after].tolist(), *self._jumps}))

    def range(self, t0: float, t1: float) -> tuple[float, float]:
        """The least and the greatest value on [t0, t1], both sides of a jump included."""
        inside = [v for t, v in zip(self.times, self.values, strict=True) if t0 < t <= t1]
        reached = [self.value(t0), *inside, self.value(t1)]
        return min(reached), max(reached)

    @property
    def _jumps(self) -> list[float]:
        points = zip(self.times, self.values, strict=True)
        return [t for (t, v), (u, w) in pairwise(points) if t == u and v != w]

    @cached_property
    def _points(self) -> tuple[Floats, Floats]:
        """Times and values as arrays."""
        return np.array(self.times, dtype=float), np.array(self.values, dtype=float)

    @cached_property
    def _slopes(self) -> Floats:
        """The slope of each segment, the two constant ends included; 0 for a jump."""
        with np.errstate(over="ignore", invalid="ignore"):
            runs, rises = (np.diff(part) for part in self._points)
            inner = np.divide(rises, runs, out=np.zeros_like(rises), where=runs > 0.0)
        return np.concatenate(([0.0], inner, [0.0]))

    def _at(self, t: float | Floats, side: Literal["left", "right"]) -> float | Floats:
        if len(self.times) == 1:  # as in most samples of a study, which are many
            value = float(self.values[0])
            return np.full(t.shape, value) if isinstance(t, np.ndarray) else value
        return _like(t, self._evaluate(t, side))

    def _evaluate(self, t: ArrayLike, side: Literal["left", "right"]) -> Floats:
        """Interpolate in the segment that holds the points next to `t` on that side."""
        times, values = self._points
        segment = np.searchsorted(times, t, side=side)
        start = np.maximum(segment - 1, 0)
        interpolated: Floats = values[start] + self._slopes[segment] * (
            np.asarray(t) - times[start]
        )
        return interpolated


def _like(t: float | Floats, result: Floats) -> float | Floats:
    """A plain float for a plain time, an array for an array."""
    return result if isinstance(t, np.ndarray) else float(result)
