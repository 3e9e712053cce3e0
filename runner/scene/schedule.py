"""A scene's scripts as steps of the component: values and rates at the start of each step.

Nothing is stored per step: values are computed from the breakpoints when a slice of the steps is
requested.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipmode.fmu.inputs import rate_of
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.runner.scene.keys import Window
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import Scene

# Of a step: closer points are one. Multiples are rounded by 1e-16 of the time, in up to 1e7 steps.
_SAME = 1e-9


class _Stretches(NamedTuple):
    """Stretches in which all scripts are straight lines, (stretches + 1,) each."""

    start: Floats  # Their starts, and the end [s]
    number: NDArray[np.int64]  # The numbers of these communication points
    regular: NDArray[np.int64]  # The multiple of the step that follows each start


@frozen
class Schedule:
    """Communication points and the inputs between them.

    Steps and points are numbered from 0. Slices select some of them.
    """

    scripts: Mapping[str, Script]  # Per input ("force_A", ...)
    # duration, step: The points are 0, the end, every breakpoint of a script, and the multiples of
    # the step that coincide with none of these [s]
    duration: float
    step: float
    points: tuple[float, ...] = ()  # More communication points [s]
    followers: tuple[str, ...] = ()  # Modes that follow the frequency of another, without inputs

    @property
    def scripted(self) -> tuple[str, ...]:
        """Names of the inputs that scripts set, and of their rates."""
        names = [name for name in self.scripts if name[-1] not in self.followers]
        return (*names, *map(rate_of, names))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return int(self._stretches.number[-1])

    def time(self, points: slice = slice(None)) -> Floats:
        """Return communication points [s], (points,)."""
        number = np.arange(*points.indices(self.steps + 1))
        stretch = np.searchsorted(self._stretches.number, number, side="right") - 1
        inside = number - self._stretches.number[stretch]
        regular = self.step * (self._stretches.regular[stretch] + inside - 1)
        return np.where(inside == 0, self._stretches.start[stretch], regular)

    def numbers(self, times: Floats) -> NDArray[np.int64]:
        """Return the numbers of the communication points at times [s]; between two, the later."""
        starts, number, regular = self._stretches
        stretch = np.searchsorted(starts, times + _SAME * self.step, side="right") - 1
        at_start = times - starts[stretch] <= _SAME * self.step
        inside = self._next_multiple(times, after=False) - regular[stretch] + 1
        return np.asarray(number[stretch] + np.where(at_start, 0, inside))

    def durations(self, steps: slice = slice(None)) -> Floats:
        """Return the lengths of steps [s], (steps,)."""
        first, end, _ = steps.indices(self.steps)
        return np.diff(self.time(slice(first, max(end, first) + 1)))

    def inputs(self, names: Sequence[str], steps: slice = slice(None)) -> Floats:
        """Return inputs of a component at the start of steps, after jumps, (steps, names)."""
        starts = self.time(slice(*steps.indices(self.steps)))
        return np.column_stack([self._input(name, starts) for name in names])

    def at_points(self, names: Sequence[str], points: slice = slice(None)) -> Floats:
        """Return values at communication points, after jumps, (points, names)."""
        first, end, _ = points.indices(self.steps + 1)
        values = self.inputs(names, slice(first, end))
        if end <= self.steps:
            return values
        last = slice(self.steps - 1, self.steps)
        return np.vstack((values, self.at_ends(names, last)))

    def at_ends(self, names: Sequence[str], steps: slice = slice(None)) -> Floats:
        """Return values at the end of steps, before jumps, (steps, names)."""
        rates = self.inputs([rate_of(name) for name in names], steps)
        return np.asarray(self.inputs(names, steps) + rates * self.durations(steps)[:, np.newaxis])

    def frequencies(self, modes: Sequence[str]) -> tuple[Floats, Floats]:
        """Return forcing frequencies [rad/s] at both ends of every stretch, (stretches, modes)."""
        names, straight = [f"frequency_{mode}" for mode in modes], self.stretches()
        return straight.inputs(names), straight.at_ends(names)

    def frequency_range(self, modes: Sequence[str]) -> tuple[Floats, Floats]:
        """Return the least and the largest forcing frequency of each mode [rad/s], (modes,)."""
        return self.extremes([f"frequency_{mode}" for mode in modes])

    def stretches(self) -> Schedule:
        """Return the schedule with steps from breakpoint to breakpoint."""
        return replace(self, step=self.duration)

    @property
    def breaks(self) -> Floats:
        """Start, breakpoints and end [s]: the communication points of `stretches`."""
        return self._stretches.start

    def retimed(self, durations: Floats) -> Schedule:
        """Return the schedule whose stretches have other durations [s], (stretches,).

        Inputs have the same values at the ends of stretches: ramps get faster or slower.
        """
        straight, names = self.stretches(), list(self.scripts)
        ends = np.append(0.0, np.cumsum(durations))
        times = tuple(np.repeat(ends, 2)[1:-1].tolist())
        values = np.stack((straight.inputs(names), straight.at_ends(names)), axis=1)
        columns = values.reshape(-1, len(names)).T.tolist()
        scripts = {n: Script(times, tuple(v)) for n, v in zip(names, columns, strict=True)}
        end = float(ends[-1])
        return replace(straight, scripts=scripts, duration=end, step=end, points=times)

    def at_breaks(self, times: Floats) -> Floats:
        """Return times, where rounding separates them from breakpoints the breakpoints [s]."""
        breaks, middle = self.breaks, 0.5 * (self.breaks[:-1] + self.breaks[1:])
        nearest = breaks[np.searchsorted(middle, times)]
        return np.where(np.abs(times - nearest) <= _SAME * self.duration, nearest, times)

    def around(self, names: Sequence[str], times: Floats, *, after: bool) -> Floats:
        """Return inputs just before or just after times in the schedule, (times, names)."""
        at = self.at_breaks(times)
        from_left = at >= self.duration if after else at > 0.0
        scripts = [self._script(name) for name in names]
        return np.column_stack(
            [np.where(from_left, each.value_before(at), each.value(at)) for each in scripts]
        )

    def mean_frequency(self, modes: Sequence[str]) -> list[float]:
        """Return the forcing frequency of each mode [rad/s], a mean weighted by the amplitude."""
        straight = self.stretches()
        lengths = straight.durations()
        means = []
        for mode in modes:
            names = [f"frequency_{mode}", f"force_{mode}"]
            start, end = straight.inputs(names), straight.at_ends(names)
            if not (start[:, 1].any() or end[:, 1].any()):
                start[:, 1] = end[:, 1] = 1.0
            reference = start[0, 0]  # so that the mean of a constant is this constant
            (f0, w0), (f1, w1) = start.T, end.T
            middle = 0.5 * (w0 + w1)
            moment = (f0 - reference) * w0 + (f1 - reference) * w1
            moment += 4.0 * (0.5 * (f0 + f1) - reference) * middle  # Simpson's rule is exact
            means.append(float(reference + lengths @ moment / 6.0 / (lengths @ middle)))
        return means

    def extremes(self, names: Sequence[str]) -> tuple[Floats, Floats]:
        """Return the least and the largest value of each input, (names,); jumps included."""
        straight = self.stretches()
        reached = np.vstack((straight.inputs(names), straight.at_ends(names)))
        return reached.min(axis=0), reached.max(axis=0)

    def sample_times(self, window: Window) -> Floats:
        """Return equally spaced times over a window [s], also its ends.

        A period of the highest forcing frequency in the window has `samples_per_period` of them.
        """
        frequencies = [s for name, s in self.scripts.items() if name.startswith("frequency_")]
        fastest = max(script.range(window.start, window.end)[1] for script in frequencies)
        periods = (window.end - window.start) * fastest / (2 * np.pi)
        count = max(int(np.ceil(periods * window.samples_per_period)), 1)
        return np.linspace(window.start, window.end, count + 1)

    def _input(self, name: str, starts: Floats) -> Floats:
        script = self._script(name.replace("_rate", ""))
        return script.rate(starts) if is_rate(name) else script.value(starts)

    def _script(self, name: str) -> Script:
        constant = Script.constant(1.0) if name == "limit_scale" else None
        script = self.scripts.get(name, constant)
        assert script is not None
        return script

    @cached_property
    def _stretches(self) -> _Stretches:
        breaks = {b for script in self.scripts.values() for b in script.breaks} | {*self.points}
        inner = {b for b in breaks if 0 < b < self.duration}
        start = np.array(sorted({0.0, self.duration, *inner}))
        first = self._next_multiple(start[:-1], after=True)
        end = self._next_multiple(start[1:], after=False)
        number = np.append(0, np.cumsum(np.maximum(end - first, 0) + 1))
        return _Stretches(start, number, np.append(first, 0))

    def _next_multiple(self, time: Floats, *, after: bool) -> NDArray[np.int64]:
        """Return the least k for which k steps lie after each time, or not before it."""
        k = np.floor(time / self.step).astype(np.int64)[:, np.newaxis] + np.arange(-1, 3)
        distance = self.step * k - time[:, np.newaxis]
        earlier = distance <= _SAME * self.step if after else -distance > _SAME * self.step
        return np.asarray(k[:, 0] + earlier.sum(axis=1))


def is_rate(name: str) -> bool:
    """Return whether an input is the rate of another."""
    return "_rate" in name


def make_schedule(scene: Scene, natural: Mapping[str, float]) -> Schedule:
    """Return the steps of a scene for the modes in `natural`, {"A": omega_A, ...}.

    A mode without forcing of its own has zero force at its natural frequency, or at a multiple of
    the frequency of A.
    """
    scripts = {"limit_scale": scene.limit_scale} if scene.limit_scale else {}
    followers: tuple[str, ...] = ()
    zero = Script.constant(0.0)
    for mode, frequency in natural.items():
        forcing = scene.forcing.get(mode)
        scripts[f"force_{mode}"] = forcing.amplitude if forcing else zero
        scripts[f"frequency_{mode}"] = forcing.frequency if forcing else Script.constant(frequency)
        scripts[f"phase_{mode}"] = forcing.phase if forcing else zero
    if scene.modes.ratio is not None:
        scripts["frequency_B"] = scripts["frequency_A"].scaled(float(scene.modes.ratio))
        followers = ("B",)
    return Schedule(scripts, scene.run.duration, scene.run.step, followers=followers)
