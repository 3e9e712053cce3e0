"""A pass of one or two modes, or waves, in slow time; stretches may be at full order."""

from __future__ import annotations

import logging

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.slow.transient import said_error
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.disk_motion import record_disk
from slipmode.runner.transients.energy import SlowBalance
from slipmode.runner.transients.estimate import ErrorRecord, RunError
from slipmode.runner.transients.friction_error import FrictionErrorRecord
from slipmode.runner.transients.hybrid import Hybrid, fast_motion, full_order_number
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    Stepper,
    carrier_phases,
    record_points,
    slow_trajectory,
    torus_motion,
)
from slipmode.runner.transients.passes.loop import Pass, Recording

_PERIODS_PER_BLOCK = 1e5  # between recordings: less than a second of work even if steps are long
_FRICTION_ESTIMATES = 4096  # in a run, about: of the error by friction, some ms in all

_log = logging.getLogger("slipmode.run")


class SlowPass(Pass[Plan]):
    """Steps of a component through slow time."""

    def __init__(self, plan: Plan, recording: Recording, component: Stepper, model: Model) -> None:
        super().__init__(plan, recording, component)
        self._model = model
        self._error = RunError(plan, model)
        self._errors, self._friction = ErrorRecord(plan), FrictionErrorRecord(plan, model)
        self._balance = SlowBalance(plan, model)
        self._reported = 0  # stretches at full order
        self._columns = OutputColumns.of(component.output_names, plan.excited.modes)
        fastest = float(plan.schedule.frequency_range(plan.excited.modes)[1].max())
        steps_per_period = 2.0 * np.pi / fastest / plan.scene.run.step
        # the transient error is estimated four times a cycle
        self._estimate_every = max(int(0.25 * steps_per_period), 1)
        self._friction_every = max(plan.schedule.steps // _FRICTION_ESTIMATES, 1)
        at_once = max(int(_PERIODS_PER_BLOCK * steps_per_period), 1)
        self.steps_per_block = min(at_once, self.steps_per_block)

    def _end(self) -> None:
        plan, recorder, now = self._plan, self._recorder, self._time_at(self._recorded - 1)
        if self._recorded > plan.schedule.steps:
            self._report_stretches(now, over=True)
            largest = self._errors.finding()
            recorder.event(now, largest.level, largest.reason)
            if plan.scene.model.amplitude is not None and largest.level == "warning":
                _log.warning("%s", largest.line())  # the plan does not know it
        for found in self._friction.findings():
            words = command_words(found.line())
            recorder.event(now, found.level, words)
            if found.level == "warning":
                _log.warning("%s", words)

    def _report_stretches(self, now: float, *, over: bool = False) -> None:
        """Record which stretches were at full order, if they have ended or the run is over."""
        if not isinstance(self._component, Hybrid):
            return
        for stretch in self._component.stretches[self._reported :]:
            if over or np.isfinite(stretch.end):
                end = min(stretch.end, now)
                error = said_error(self._plan.excited.modes, stretch.error)
                words = f"full order from {stretch.start:g} to {end:g} s: {error} in slow time"
                self._recorder.event(end, "info", words)
                self._reported += 1

    def _note(self, starts: Floats, first: int) -> None:
        """Estimate the errors at the starts of steps in slow time."""
        last = first + len(starts)
        every = self._friction_every
        number = first + -first % every
        if number < last:
            time = self._schedule.time(slice(number, last, every))
            in_slow_time = full_order_number(self._component, time) % 2 == 0
            amplitude = self._columns.amplitudes(starts[number - first :: every])
            self._friction.add(amplitude, in_slow_time, number, every)
        every = self._estimate_every
        some = starts[::every]
        amplitude, angle = self._columns.amplitudes(some), some[:, self._columns.angle]
        error = self._error.at(amplitude, angle, first, every)
        time = self._schedule.time(slice(first, last + 1))
        time = np.append(time[:-1:every], time[-1])
        error[full_order_number(self._component, time[:-1]) % 2 == 1] = 0.0
        self._errors.add(error, time)

    def _record(self, rows: Floats) -> None:
        first = self._recorded
        self._report_stretches(self._time_at(first + len(rows) - 1))
        amplitude, power = self._columns.amplitudes(rows), rows[:, self._columns.power]
        energy = self._balance.rows(power, amplitude, first)
        record_points(self._plan, self._recorder, first, amplitude.view(float), energy)

    def _record_window(self, window: Window) -> None:
        plan, model, recorder = self._plan, self._model, self._recorder
        first, rows = self._kept()
        slow = slow_trajectory(plan, model, self._component.output_names, rows, first)

        def motion_at(times: Floats) -> tuple[FastMotion, Floats | float, Floats]:
            moved = fast_motion(self._component, plan, model, slow, times)
            return moved, slow.scale_at(times), carrier_phases(slow, times)

        self._record_motion(window, plan.excited.contacts[0], motion_at)
        if plan.excited.waves is not None:
            record_disk(plan, recorder, model, slow, window)
        elif self._is_on_torus(window):
            torus = torus_motion(model, slow, window.end)
            recorder.write(channels.TORUS, np.full(len(torus), window.end), torus)
