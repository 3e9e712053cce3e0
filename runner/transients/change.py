"""How fast the amplitudes of a run change: watched at its communication points."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_list
from slipmode.rom.slow.slow_flow import inputs_of, rates, slow_flow
from slipmode.rom.slow.transient import (
    LARGEST_CHANGE,
    change_per_cycle,
    friction_threshold,
    said_change,
)
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.schedule import LIMIT_SCALE, rate_of
from slipmode.runner.trajectory import scripted

_APART = 10.0  # cycles: fast changes nearer to each other are one


class SlowChange:
    """`change_per_cycle` of the slow flow of a plan."""

    def __init__(self, plan: Plan, model: Model) -> None:
        self._plan = plan
        self._flow = slow_flow(model, plan.excited.force_patterns)
        self.threshold = friction_threshold(model.reduced, model.law)

    def at(self, amplitude: Complexes, angle: Floats, first: int, stride: int = 1) -> Floats:
        """At the starts of steps from number `first` on, (steps, modes); 1 outside the table.

        Of every `stride`-th step.

        Parameters
        ----------
        amplitude, angle : (steps, modes) ndarray
        """
        excited, schedule = self._plan.excited, self._plan.schedule
        steps = slice(first, first + stride * len(amplitude), stride)
        script = scripted(excited, schedule, steps)
        inputs = inputs_of(
            *(script.force, script.frequency, script.force_rate, script.frequency_rate, angle)
        )
        names = [LIMIT_SCALE, rate_of(LIMIT_SCALE)]
        inputs["limit_scale"], inputs["limit_scale_rate"] = schedule.inputs(names, steps).T
        try:
            rate = rates(self._flow, inputs, amplitude)
        except SlipmodeError:
            return np.ones(amplitude.shape)
        threshold = self.threshold * inputs["limit_scale"][:, np.newaxis]
        return change_per_cycle(rate, script.frequency, amplitude, threshold)


class ChangeRecord:
    """Where amplitudes changed fast, and how fast at most."""

    def __init__(self, plan: Plan) -> None:
        self._modes = plan.excited.modes
        self._longest = 2 * np.pi / plan.excited.reduced.carrier.min()
        self._most = np.zeros(len(self._modes))
        self._fast: list[tuple[float, float]] = []

    def add(self, change: Floats, time: Floats) -> None:
        """Changes (steps, modes) in steps between times (steps + 1,)."""
        self._most = np.maximum(self._most, change.max(axis=0, initial=0.0))
        for k in np.flatnonzero(np.any(change > LARGEST_CHANGE, axis=1)):
            start, end = float(time[k]), float(time[k + 1])
            if self._fast and start - self._fast[-1][1] <= _APART * self._longest:
                start = self._fast.pop()[0]
            self._fast.append((start, end))

    def __str__(self) -> str:
        said = said_change(self._modes, self._most)
        if not self._fast:
            return f"{said}, never above {LARGEST_CHANGE:.0%}"
        listed = short_list((f"{a:g} to {b:g} s" for a, b in self._fast))
        return f"{said}, above {LARGEST_CHANGE:.0%} from {listed}"
