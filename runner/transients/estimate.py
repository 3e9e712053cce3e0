"""The estimated transient error of a run, at its communication points."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import short_list
from slipmode.rom.slow.slow_flow import inputs_of, rates, slow_flow
from slipmode.rom.slow.transient import TransientError, said_error
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.transients import slow_time_error
from slipmode.runner.transients.motion import scripted


class RunError:
    """`TransientError` of a plan, relative to the amplitude range of its friction table."""

    def __init__(self, plan: ModesPlan, model: Model) -> None:
        self._plan = plan
        self._flow = slow_flow(model, plan.excited.force_patterns)
        self._estimate = TransientError.of(*plan.excited.contacts)
        self._shift = AppliedForces.of(model.reduced, plan.excited.force_patterns).shift

    def at(
        self,
        amplitude: Complexes,
        angle: Floats,
        first: int,
        stride: int = 1,
        rate: Complexes | None = None,
    ) -> Floats:
        """Return the error at the starts of steps, (steps, modes); 1 outside the friction table.

        `stride` is the difference of the numbers of the steps. `rate` is da/dt, by default from
        the slow flow. All of them are (steps, modes).
        """
        steps = slice(first, first + stride * len(amplitude), stride)
        script = scripted(self._plan.excited, self._plan.schedule, steps)
        if rate is None:
            inputs = inputs_of(
                script.force, script.frequency, script.force_rate, script.frequency_rate, angle
            )
            inputs["limit_scale"] = script.scale
            inputs["limit_scale_rate"] = script.scale_rate
            try:
                rate = rates(self._flow, inputs, amplitude)
            except SlipmodeError:
                return np.ones(amplitude.shape)
        scale = script.scale[:, np.newaxis]
        acting = (amplitude + self._shift * script.force) / scale
        error = self._estimate.at(rate / scale, script.frequency, acting)
        return np.asarray(error / np.array(self._plan.amplitude))


class ErrorRecord:
    """The largest transient error of slow time in a run, and when it exceeds the allowed one."""

    def __init__(self, plan: ModesPlan) -> None:
        self._scene, self._modes = plan.scene, plan.excited.modes
        # intervals fewer than ten cycles apart are reported as one
        self._gap = 20.0 * np.pi / plan.excited.reduced.carrier.min()
        self._largest = np.zeros(len(self._modes))
        self._above: list[tuple[float, float]] = []

    def add(self, error: Floats, time: Floats) -> None:
        """Add errors (steps, modes) in steps between times (steps + 1,)."""
        self._largest = np.maximum(self._largest, error.max(axis=0, initial=0.0))
        allowed = self._scene.model.transient_error
        for k in np.flatnonzero(np.any(error > allowed, axis=1)):
            start, end = float(time[k]), float(time[k + 1])
            if self._above and start - self._above[-1][1] <= self._gap:
                start = self._above.pop()[0]
            self._above.append((start, end))

    def finding(self) -> Finding:
        """Return the event for the recording: a warning if the error exceeds the allowed one."""
        largest = said_error(self._modes, self._largest)
        if not self._above:
            return Finding("transients", "slow time", largest)
        listed = short_list(f"{a:g} to {b:g} s" for a, b in self._above)
        return slow_time_error(self._scene, f"{largest} from {listed}")
