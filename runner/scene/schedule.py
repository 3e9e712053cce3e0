"""A scene's scripts as steps of the component: values and rates at the start of each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.runner.scene.scene import Scene
from slipmode.runner.scene.script import Script

_QUIET = Script.constant(0.0)
_ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Schedule:
    """Communication points and the inputs between them.

    Attributes
    ----------
    time : (steps + 1,) ndarray
        Communication points [s], from 0; a breakpoint of any script is one of them.
    values, rates : dict of str to (steps,) ndarray
        Per input ("force_A", ...) its value right of each step's start and its slope.
    """

    time: Floats
    values: dict[str, Floats]
    rates: dict[str, Floats]

    __repr__ = short_repr

    @cached_property
    def durations(self) -> Floats:
        """Length of each step [s], (steps,)."""
        return np.diff(self.time)

    def inputs(self, names: Sequence[str], steps: slice = _ALL) -> Floats:
        """Inputs of a component in some steps, (steps, len(names)), in the order of its names."""
        columns = []
        for name in names:
            quantity, mode = name.rsplit("_", 1)
            if name.startswith("limit_scale"):  # no scene scales the friction limits
                columns.append(np.full(self.durations[steps].size, float(name == "limit_scale")))
            elif quantity.endswith("_rate"):
                columns.append(self.rates[f"{quantity.removesuffix('_rate')}_{mode}"][steps])
            else:
                columns.append(self.values[name][steps])
        return np.column_stack(columns)

    def mean_frequency(self, modes: Sequence[str]) -> list[float]:
        """Forcing frequency of each mode [rad/s], its mean weighted by the force amplitude."""
        middle = 0.5 * self.durations
        means = []
        for mode in modes:
            frequency, force = (
                self.values[f"{name}_{mode}"] + self.rates[f"{name}_{mode}"] * middle
                for name in ("frequency", "force")
            )
            weight = self.durations * (force if force.any() else 1.0)
            means.append(float(np.average(frequency, weights=weight)))
        return means

    def forces(self, modes: Sequence[str]) -> tuple[Complexes, Complexes]:
        """Force exp(i phase) at the start and at the end of each step, (steps, modes)."""

        def turned(mode: str, later: Floats | float) -> Complexes:
            force, phase = (
                self.values[f"{name}_{mode}"] + self.rates[f"{name}_{mode}"] * later
                for name in ("force", "phase")
            )
            return np.asarray(force * np.exp(1j * phase))

        start, end = (
            np.column_stack([turned(mode, later) for mode in modes])
            for later in (0.0, self.durations)
        )
        return start, end

    def largest_force(self, modes: Sequence[str]) -> Floats:
        """Largest force of each mode at the start or end of a step, (modes,)."""
        largest = []
        for mode in modes:
            start, rate = self.values[f"force_{mode}"], self.rates[f"force_{mode}"]
            end = start + rate * self.durations
            largest.append(max(np.abs(start).max(), np.abs(end).max()))
        return np.array(largest)

    def first_step(self) -> Schedule:
        """The schedule up to the end of its first step."""
        values, rates = (
            {name: column[:1] for name, column in columns.items()}
            for columns in (self.values, self.rates)
        )
        return Schedule(self.time[:2], values, rates)

    def at_points(self, names: Sequence[str], points: slice = _ALL) -> Floats:
        """Values at some communication points, (points, len(names)), right of jumps."""
        first, end, _ = points.indices(self.time.size)
        columns = [self.values[name][first:end] for name in names]
        if end == self.time.size:
            last = [self.values[n][-1] + self.rates[n][-1] * self.durations[-1] for n in names]
            columns = [np.append(c, value) for c, value in zip(columns, last, strict=True)]
        return np.column_stack(columns)


def make_schedule(scene: Scene, natural: dict[str, float]) -> Schedule:
    """Steps of a scene for the modes in `natural`, {"A": omega_A, ...}.

    A mode without forcing of its own has zero force at its natural frequency.
    """
    scripts: dict[str, Script] = {}
    for mode, frequency in natural.items():
        forcing = scene.forcing.get(mode)
        scripts[f"force_{mode}"] = forcing.amplitude if forcing else _QUIET
        scripts[f"frequency_{mode}"] = forcing.frequency if forcing else Script.constant(frequency)
        scripts[f"phase_{mode}"] = forcing.phase if forcing else _QUIET
    time = _communication_points(scene.run.duration, scene.run.step, scripts)
    starts = time[:-1]
    return Schedule(
        time,
        {name: script.value(starts) for name, script in scripts.items()},
        {name: script.rate(starts) for name, script in scripts.items()},
    )


def _communication_points(duration: float, step: float, scripts: dict[str, Script]) -> Floats:
    """0, the end, every breakpoint, and the multiples of the step that coincide with none."""
    breaks = {b for script in scripts.values() for b in script.breaks if 0 < b < duration}
    fixed = np.array(sorted({0.0, duration, *breaks}))
    regular = step * np.arange(np.ceil(duration / step))
    after = np.clip(np.searchsorted(fixed, regular), 1, fixed.size - 1)
    nearest = np.minimum(np.abs(regular - fixed[after - 1]), np.abs(fixed[after] - regular))
    return np.union1d(fixed, regular[nearest > 1e-9 * step])
