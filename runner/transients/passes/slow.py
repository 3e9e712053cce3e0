"""A pass of one or two modes in slow time, and at full order where slow time has large errors.

A stretch at full order begins at the communication point at which the estimated transient error
exceeds the allowed one, or before the point at which the plan has a stretch. It begins from the
motion of slow time, at t = 0 from the start of the scene.
Slow time goes on at the first point after a window in which the estimate stays below the part
`SETTLED` of the allowed error, both at full order and in the slow flow from its amplitudes.
"""

from __future__ import annotations

import logging
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from slipmode.fmu import Component, Steppable, StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS, reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.slow.transient import said_error
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.transients import SETTLED
from slipmode.runner.recording import channels
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.band import SampleBand
from slipmode.runner.transients.energy import SlowBalance
from slipmode.runner.transients.errors import FrictionErrors, TransientErrors
from slipmode.runner.transients.full_order import FullOrder, SlowPart, Stretch
from slipmode.runner.transients.motion import (
    FastMotion,
    carrier_phases,
    slow_trajectory,
    torus_motion,
)
from slipmode.runner.transients.passes.loop import ComponentPass, Destination

_PERIODS_PER_BLOCK = 1e5  # between recordings: less than a second of work even if steps are long
_FRICTION_ESTIMATES = 4096  # in a run, about: of the error by friction, some ms in all

_log = logging.getLogger("slipmode.run")


class SlowPass(ComponentPass):
    """Steps of a component through slow time, with stretches at full order.

    Without a `component`, it is made for the model.
    """

    def __init__(
        self,
        plan: ModesPlan,
        destination: Destination,
        model: Model,
        component: Steppable | None = None,
    ) -> None:
        energy = SlowBalance(plan, model).rows
        super().__init__(plan, destination, component or plan.component(model), energy)
        self._model = model
        self._band = None if model.samples is None else SampleBand(plan, model)
        self._error = TransientErrors(plan, model, self._columns)
        self._friction = FrictionErrors(plan, model, self._columns)
        self._allowed = plan.scene.model.transient_error
        slowest, fastest = plan.schedule.frequency_range(plan.excited.modes)
        steps_per_period = 2.0 * np.pi / float(fastest.max()) / plan.scene.run.step
        # errors, and in how many steps they are estimated once: in transients four times a cycle
        self._estimates = (
            (self._error, max(int(0.25 * steps_per_period), 1)),
            (self._friction, max(plan.schedule.steps // _FRICTION_ESTIMATES, 1)),
        )
        at_once = max(int(_PERIODS_PER_BLOCK * steps_per_period), 1)
        self.steps_per_block = min(at_once, self.steps_per_block)
        self._cycle = 2.0 * np.pi / float(slowest.min())
        self._stretches: list[Stretch] = []  # at full order; the last one may be open
        self._open: Stretch | None = None
        self._energy = 0.0  # dissipated in stretches, which the component does not know
        self._before = 0.0  # dissipated at the start of a stretch

    @cached_property
    def _full(self) -> FullOrder:
        return FullOrder(self._plan, self._model.reduced)

    def _step(self, steps: slice) -> Floats:
        if not self._plan.scene.switches:
            return super()._step(steps)
        return self._fully(steps, self._open) if self._open else self._slowly(steps)

    def _slowly(self, steps: slice) -> Floats:
        """Take steps of the slow flow until its error is too large; then a stretch begins."""
        if self._too_fast(self.last_row[np.newaxis], steps.start).any():
            self._open = self._begin()
            self._stretches.append(self._open)
            return np.empty((0, self.last_row.size))
        component = cast(Component, self._component)  # FMUs do not switch
        state, stopped = component.get_state(), None
        try:
            rows = super()._step(steps)
        except StoppedError as stop:
            rows, stopped = stop.outputs, stop
        fast = np.flatnonzero(self._too_fast(rows[:-1], steps.start + 1))
        if fast.size:
            component.set_state(state)
            rows = super()._step(slice(steps.start, steps.start + int(fast[0]) + 1))
        rows[:, self._columns.power[-1]] += self._energy
        if stopped is not None and not fast.size:
            raise stopped  # its outputs are these rows
        return rows

    def _too_fast(self, rows: Floats, first: int) -> Flags:
        """Return whether slow time has too large an error in the steps after rows, (rows,)."""
        angle = rows[:, self._columns.angle]
        error = self._error.at(self._columns.amplitudes(rows), angle, first)
        time = self._schedule.time(slice(first, first + len(rows) + 1))
        starts = [start for start, _ in self._plan.full_order]
        planned = np.diff(np.searchsorted(starts, time)) > 0
        return np.asarray(np.any(error > self._allowed, axis=1) | planned)

    def _begin(self) -> Stretch:
        """Return the stretch that starts at the present point."""
        self._before = float(self.last_row[self._columns.power[-1]])
        if self._time_at(self._point) >= self._cycle:
            return Stretch(self._full, self._full.state_on(self._model, self._trajectory()))
        self._before = 0.0  # too little motion yet for a state: from the start of the scene
        return Stretch(self._full, self._full.first())

    def _fully(self, steps: slice, stretch: Stretch) -> Floats:
        """Take steps of the open stretch, until slow time goes on."""
        first = steps.start + 1
        time = self._schedule.time(slice(first, steps.stop + 1))
        window, end = self._full.window, self._schedule.duration
        ahead = max(stretch.reached, float(time[0])) + 4.0 * window
        stretch.advance(min(ahead, end))
        known = time <= stretch.reached - 0.5 * window
        count = max(int(np.sum(known | (stretch.reached >= end))), 1)
        slow = stretch.slow(time[:count])
        back = self._end_of(stretch, slow, time[:count], first)
        count = count if back is None else back + 1
        # the component takes the same steps, for time and angles
        try:
            rows = super()._step(slice(steps.start, steps.start + count))
        except StoppedError as stop:
            none = np.empty((0, self.last_row.size))
            raise StoppedError(str(stop), stop.time, none, stop.left_table) from None
        rows[:, self._columns.parts] = slow.amplitude[:count].view(float)
        power = self._columns.power
        own = float(rows[-1, power[-1]])
        rows[:, power] = slow.power[:count]
        rows[:, power[-1]] += self._before
        if back is not None:
            cast(Component, self._component).set_amplitude(slow.amplitude[back])
            self._energy = float(rows[-1, power[-1]]) - own
            stretch.end, self._open = float(time[back]), None
            self._report(stretch, stretch.end)
        return rows

    def _end_of(self, stretch: Stretch, slow: SlowPart, time: Floats, first: int) -> int | None:
        """Return which of the points, from number `first` on, ends the stretch, if one does."""
        going_on = min(len(time), self._schedule.steps - first)  # steps that follow
        angle, _, _ = self._full.excitation.at(time[:going_on])
        amplitude, rate = slow.amplitude[:going_on], slow.rate[:going_on]
        error = self._error.at(amplitude, angle, first, rate=rate)
        error = np.maximum(error, self._error.at(amplitude, angle, first))
        stretch.error = np.maximum(stretch.error, error.max(axis=0, initial=0.0))
        window, jumps = self._full.window, self._full.jumps
        for k, now in enumerate(time[:going_on]):
            near = (jumps > now - window) & (jumps <= now + 0.5 * window)
            if np.any(error[k] > SETTLED * self._allowed) or near.any():
                stretch.last_fast = float(now)
            elif now - stretch.last_fast >= 0.5 * window <= now - stretch.start:
                return k
        return None

    def _needed(self, now: float) -> float:
        needed = super()._needed(now)
        if not self._plan.scene.switches:
            return needed
        return min(needed, now - (SPIN_UP_PERIODS + 2.0) * self._cycle)

    def _trajectory(self) -> SlowTrajectory:
        first, rows = self._kept()
        return slow_trajectory(self._plan, self._model, self._component.output_names, rows, first)

    def _stretch_numbers(self, times: Floats) -> NDArray[np.int64]:
        """Return 2 k + 1 for times (n,) in stretch k at full order, even numbers in slow time."""
        edges = [edge for stretch in self._stretches for edge in (stretch.start, stretch.end)]
        return np.searchsorted(edges, times, side="right")

    def _note(self, starts: Floats, first: int) -> None:
        """Estimate the errors at the starts of steps in slow time."""
        for errors, stride in self._estimates:
            number = first + -first % stride
            some = starts[number - first :: stride]
            if len(some):
                time = self._schedule.time(slice(number, first + len(starts), stride))
                errors.add(some, self._stretch_numbers(time) % 2 == 0, number, stride)

    def _end(self) -> None:
        plan, recorder, now = self._plan, self._recorder, self._time_at(self._point)
        if self._point == plan.schedule.steps:
            if self._open:
                self._report(self._open, now)
            largest = self._error.finding()
            recorder.event(now, largest.level, largest.reason)
            if plan.scene.model.amplitude is not None and largest.level == "warning":
                _log.warning("%s", largest.line())  # the plan does not know it
        for found in self._friction.findings():
            words = command_words(found.line())
            recorder.event(now, found.level, words)
            if found.level == "warning":
                _log.warning("%s", words)

    def _report(self, stretch: Stretch, end: float) -> None:
        """Record which stretch was at full order."""
        error = said_error(self._plan.excited.modes, stretch.error)
        words = f"full order from {stretch.start:g} to {end:g} s: {error} in slow time"
        self._recorder.event(end, "info", words)

    def _record_window(self, window: Window) -> None:
        slow = self._trajectory()

        def motion_at(times: Floats) -> tuple[FastMotion, Floats | float, Floats]:
            return self._motion(slow, times), slow.scale_at(times), carrier_phases(slow, times)

        self._record_motion(window, self._plan.excited.contacts[0], motion_at)
        self._record_end(window, slow)

    def _motion(self, slow: SlowTrajectory, times: Floats) -> FastMotion:
        """Return the motion at increasing times, from slow time or from full order."""
        numbers = self._stretch_numbers(times)
        parts = []
        for k in np.unique(numbers):
            own = times[numbers == k]
            parts.append(
                self._stretches[k // 2].motion(own) if k % 2 else self._slow_motion(slow, own)
            )
        return FastMotion.joined(parts)

    def _slow_motion(self, slow: SlowTrajectory, times: Floats) -> FastMotion:
        """Return the motion that a trajectory has at times."""
        model, moved = self._model, reconstruct(self._model, slow, times)
        elastic = moved.elastic(model, self._plan.scene.output.elastic)
        modal = moved.modal[:, : model.modes]
        return FastMotion(times, moved.displacement, moved.velocity, moved.force, modal, elastic)

    def _record_end(self, window: Window, slow: SlowTrajectory) -> None:
        """Record what is shown at the end of a window."""
        if self._is_on_torus(window):
            torus = torus_motion(self._model, slow, window.end)
            self._recorder.write(channels.TORUS, np.full(len(torus), window.end), torus)
