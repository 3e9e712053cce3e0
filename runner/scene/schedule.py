"""A scene's scripts as steps of the component: values and rates at the start of each step.

Nothing is kept per step: what is asked for of some steps is computed for those, from the
breakpoints of the scripts and the length of a step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.short_repr import short_repr
from slipmode.runner.scene.scene import Scene
from slipmode.runner.scene.script import Script

LIMIT_SCALE = "limit_scale"

_QUIET = Script.constant(0.0)
_UNSCALED = Script.constant(1.0)
_ALL = slice(None)
_SAME = 1e-9  # of a step: communication points so near are one


@dataclass(frozen=True, eq=False)
class Schedule:
    """Communication points and the inputs between them.

    Steps and points are numbered from 0; of all of them, a slice says which are meant.

    Attributes
    ----------
    scripts : mapping of str to Script
        Per input ("force_A", ...).
    duration, step : float
        The points are 0, the end, every breakpoint of a script, and the multiples of the step
        that coincide with none of these [s].
    """

    scripts: Mapping[str, Script]
    duration: float
    step: float

    __repr__ = short_repr

    @property
    def steps(self) -> int:
        """How many steps there are."""
        return int(self._stretches.number[-1])

    def time(self, points: slice = _ALL) -> Floats:
        """Communication points [s], (points,)."""
        number = np.arange(*points.indices(self.steps + 1))
        stretch = np.searchsorted(self._stretches.number, number, side="right") - 1
        inside = number - self._stretches.number[stretch]
        regular = self.step * (self._stretches.regular[stretch] + inside - 1)
        return np.where(inside == 0, self._stretches.start[stretch], regular)

    def durations(self, steps: slice = _ALL) -> Floats:
        """Length of steps [s], (steps,)."""
        first, end, _ = steps.indices(self.steps)
        return np.diff(self.time(slice(first, max(end, first) + 1)))

    def inputs(self, names: Sequence[str], steps: slice = _ALL) -> Floats:
        """Inputs of a component at the start of steps, (steps, len(names)), right of jumps."""
        starts = self.time(slice(*steps.indices(self.steps)))
        return np.column_stack([self._input(name, starts) for name in names])

    def at_points(self, names: Sequence[str], points: slice = _ALL) -> Floats:
        """Values at communication points, (points, len(names)), right of jumps."""
        first, end, _ = points.indices(self.steps + 1)
        values = self.inputs(names, slice(first, end))
        if end <= self.steps:
            return values
        last = slice(self.steps - 1, self.steps)
        return np.vstack((values, self.at_ends(names, last)))

    def at_ends(self, names: Sequence[str], steps: slice = _ALL) -> Floats:
        """Values at the end of steps, (steps, len(names)), left of jumps."""
        rates = [rate_of(name) for name in names]
        grown = self.inputs(rates, steps) * self.durations(steps)[:, np.newaxis]
        return np.asarray(self.inputs(names, steps) + grown)

    def forces(self, modes: Sequence[str], steps: slice = _ALL) -> tuple[Complexes, Complexes]:
        """Force exp(i phase) at the start and at the end of steps, (steps, modes)."""
        quantities = ("force", "phase")
        names = [[f"{quantity}_{mode}" for mode in modes] for quantity in quantities]
        start, end = (
            phasor(force, phase)
            for force, phase in (
                [at(name, steps) for name in names] for at in (self.inputs, self.at_ends)
            )
        )
        return start, end

    def stretches(self) -> Schedule:
        """The same from breakpoint to breakpoint: every input is a straight line in a step."""
        return replace(self, step=self.duration)

    def mean_frequency(self, modes: Sequence[str]) -> list[float]:
        """Forcing frequency of each mode [rad/s], its mean weighted by the force amplitude."""
        straight = self.stretches()
        lengths = straight.durations()
        means = []
        for mode in modes:
            names = [f"frequency_{mode}", f"force_{mode}"]
            start, end = straight.inputs(names), straight.at_ends(names)
            if not (start[:, 1].any() or end[:, 1].any()):
                start[:, 1] = end[:, 1] = 1.0
            reference = start[0, 0]  # so that the mean of a constant is that constant
            (f0, w0), (f1, w1) = start.T, end.T
            middle = 0.5 * (w0 + w1)
            moment = (f0 - reference) * w0 + (f1 - reference) * w1
            moment += 4.0 * (0.5 * (f0 + f1) - reference) * middle  # Simpson's rule is exact
            means.append(float(reference + lengths @ moment / 6.0 / (lengths @ middle)))
        return means

    def extremes(self, names: Sequence[str]) -> tuple[Floats, Floats]:
        """Least and largest value of each input, both sides of a jump counted, (names,)."""
        straight = self.stretches()
        reached = np.vstack((straight.inputs(names), straight.at_ends(names)))
        return reached.min(axis=0), reached.max(axis=0)

    def _input(self, name: str, starts: Floats) -> Floats:
        script = self.scripts.get(name.replace("_rate", ""))
        if script is None:  # limits that nothing scripts are those of the model
            script = {LIMIT_SCALE: _UNSCALED}[name.replace("_rate", "")]
        return script.rate(starts) if is_rate(name) else script.value(starts)

    @cached_property
    def _stretches(self) -> _Stretches:
        breaks = {b for script in self.scripts.values() for b in script.breaks}
        inner = {b for b in breaks if 0 < b < self.duration}
        start = np.array(sorted({0.0, self.duration, *inner}))
        first = self._regular_from(start[:-1], after=True)
        end = self._regular_from(start[1:], after=False)
        number = np.append(0, np.cumsum(np.maximum(end - first, 0) + 1))
        return _Stretches(start, number, np.append(first, 0))

    def _regular_from(self, time: Floats, *, after: bool) -> NDArray[np.int64]:
        """Least k whose multiple of the step lies after each time, or just not before it."""
        k = np.floor(time / self.step).astype(np.int64)[:, np.newaxis] + np.arange(-1, 3)
        apart = self.step * k - time[:, np.newaxis]
        least = _SAME * self.step
        earlier = apart <= least if after else -apart > least
        return np.asarray(k[:, 0] + earlier.sum(axis=1))


@dataclass(frozen=True, eq=False)
class _Stretches:
    """Where the scripts are straight lines.

    Attributes
    ----------
    start : (stretches + 1,) ndarray
        Their starts, and the end [s].
    number : (stretches + 1,) ndarray
        Of these among the communication points.
    regular : (stretches + 1,) ndarray
        The multiple of the step that follows each start.
    """

    start: Floats
    number: NDArray[np.int64]
    regular: NDArray[np.int64]


def rate_of(name: str) -> str:
    """What the rate of an input is called: force_rate_A of force_A, limit_scale_rate."""
    return f"{name}_rate" if name == LIMIT_SCALE else name.replace("_", "_rate_")


def is_rate(name: str) -> bool:
    """Whether an input is the rate of another."""
    return "_rate" in name


def make_schedule(scene: Scene, natural: Mapping[str, float]) -> Schedule:
    """Steps of a scene for the modes in `natural`, {"A": omega_A, ...}.

    A mode without forcing of its own has zero force at its natural frequency.
    """
    scripts = {LIMIT_SCALE: scene.limit_scale} if scene.limit_scale else {}
    for mode, frequency in natural.items():
        forcing = scene.forcing.get(mode)
        scripts[f"force_{mode}"] = forcing.amplitude if forcing else _QUIET
        scripts[f"frequency_{mode}"] = forcing.frequency if forcing else Script.constant(frequency)
        scripts[f"phase_{mode}"] = forcing.phase if forcing else _QUIET
    return Schedule(scripts, scene.run.duration, scene.run.step)
