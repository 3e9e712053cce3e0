"""Slow time, and full order where slow time has too large a transient error.

A stretch at full order begins at the communication point at which the estimated transient error
exceeds the allowed one, or before the point at which the plan has a stretch. It begins from the
motion of slow time, at t = 0 from the start of the scene.
Slow time goes on at the first point after a window in which the estimate stays below the part
`SETTLED` of the allowed error, both at full order and in the slow flow from its amplitudes.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from slipmode.fmu import Component, StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS, reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.transients import SETTLED
from slipmode.runner.transients.estimate import RunError
from slipmode.runner.transients.full_order import FullOrder, SlowPart, Stretch
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    Stepper,
    output_row,
    slow_trajectory,
)


class Hybrid:
    """A component that integrates transients at full order.

    It follows the schedule of its plan: `run` takes the steps of this schedule, in order.
    `stretches` are at full order, in time order; the last one may be open.
    """

    def __init__(self, plan: Plan, model: Model) -> None:
        self._plan, self._model = plan, model
        self._component = plan.component(model)
        self.input_names = self._component.input_names
        self.output_names = self._component.output_names
        self.stretches: list[Stretch] = []
        self._error, self._allowed = RunError(plan, model), plan.scene.model.transient_error
        modes = plan.excited.modes
        least, _ = plan.schedule.frequency_range(modes)
        self._cycle = 2.0 * np.pi / float(least.min())
        self._spin_up = (SPIN_UP_PERIODS + 2.0) * self._cycle
        self._point = 0
        self._energy = 0.0  # dissipated in stretches, which the component does not know
        self._before = 0.0  # dissipated at the start of a stretch
        self._open: Stretch | None = None
        self._columns = OutputColumns.of(self.output_names, modes)
        self._powers = self._columns.power
        self._rows = np.empty((0, len(self.output_names)))  # up to the present point
        self._first = 0  # point of the first of them

    @cached_property
    def _full(self) -> FullOrder:
        return FullOrder(self._plan, self._model.reduced)

    @cached_property
    def _jumps(self) -> Floats:
        """Times at which forces or frequencies jump [s]."""
        straight, excited = self._plan.schedule.stretches(), self._plan.excited
        found = np.zeros(straight.steps, dtype=bool)
        for start, end in (excited.modal_forces(straight), straight.frequencies(excited.modes)):
            size = np.maximum(np.abs(start).max(axis=0), np.abs(end).max(axis=0))
            jump = np.abs(start[1:] - end[:-1]) > 1e-9 * size  # less is rounding
            found[1:] |= np.any(jump, axis=1)
        return straight.time(slice(straight.steps))[found]

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values."""
        self._component.set_inputs(**values)

    def outputs(self) -> dict[str, float]:
        """Outputs at the present time."""
        if self._point == 0:
            return self._component.outputs()
        return dict(zip(self.output_names, self._rows[-1].tolist(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Return the outputs (steps, outputs) after each of the next steps of the schedule."""
        if not len(self._rows):
            self._rows = output_row(self)
        start, last = self._point, self._point + len(durations)
        found: list[Floats] = []
        try:
            while self._point < last:
                steps = slice(self._point - start, None)
                advance = self._fully if self._open else self._slowly
                rows = advance(durations[steps], inputs[steps])
                self._keep(rows)
                found.append(rows)
        except StoppedError as stop:
            rows = np.vstack([*found, stop.outputs])
            raise StoppedError(str(stop), stop.time, rows, stop.left_table) from None
        return np.vstack(found)

    def _slowly(self, durations: Floats, inputs: Floats) -> Floats:
        """Return steps of the slow flow until its error is too large; then a stretch begins."""
        first = self._point
        row = self._rows[-1:]
        if self._too_fast(row, first).any():
            self._begin()
            return np.empty((0, len(self.output_names)))
        state, stopped = self._component.get_state(), None
        try:
            rows = self._shifted(self._component.run(durations, inputs))
        except StoppedError as stop:
            rows, stopped = self._shifted(stop.outputs), stop
        fast = np.flatnonzero(self._too_fast(rows[:-1], first + 1))
        if fast.size:
            self._component.set_state(state)
            steps = slice(0, fast[0] + 1)
            rows = self._shifted(self._component.run(durations[steps], inputs[steps]))
        elif stopped is not None:  # `_shifted` has changed its outputs in place
            raise stopped
        return rows

    def _too_fast(self, rows: Floats, first: int) -> Flags:
        """Return whether slow time has too large an error in the steps after rows, (rows,)."""
        angle = rows[:, self._columns.angle]
        error = self._error.at(self._columns.amplitudes(rows), angle, first)
        time = self._plan.schedule.time(slice(first, first + len(rows) + 1))
        starts = [start for start, _ in self._plan.full_order]
        planned = np.diff(np.searchsorted(starts, time)) > 0
        return np.asarray(np.any(error > self._allowed, axis=1) | planned)

    def _begin(self) -> None:
        """Start a stretch at the present point."""
        self._before = float(self._rows[-1, self._powers[-1]])
        now = float(self._plan.schedule.time(slice(self._point, self._point + 1))[0])
        if now < self._cycle:  # too little motion yet for a state: from the start of the scene
            state, self._before = self._full.first(), 0.0
        else:
            rows, first = self._rows, self._first
            slow = slow_trajectory(self._plan, self._model, self.output_names, rows, first)
            state = self._full.state_on(self._model, slow)
        self._open = Stretch(self._full, state)
        self.stretches.append(self._open)

    def _fully(self, durations: Floats, inputs: Floats) -> Floats:
        """Return steps of the open stretch, until slow time goes on."""
        assert self._open is not None
        stretch, first = self._open, self._point + 1
        points = slice(first, first + len(durations))
        time, end = self._plan.schedule.time(points), self._plan.schedule.duration
        ahead = max(stretch.reached, float(time[0])) + 4.0 * self._full.window
        stretch.advance(min(ahead, end))
        known = time <= stretch.reached - 0.5 * self._full.window
        count = max(int(np.sum(known | (stretch.reached >= end))), 1)
        slow = stretch.slow(time[:count])
        back = self._end_of(stretch, slow, time[:count], first)
        count = count if back is None else back + 1
        # the component takes the same steps, for time and angles
        try:
            rows = self._component.run(durations[:count], inputs[:count])
        except StoppedError as stop:
            none = np.empty((0, len(self.output_names)))
            raise StoppedError(str(stop), stop.time, none, stop.left_table) from None
        rows[:, self._columns.parts] = slow.amplitude[:count].view(float)
        own = float(rows[-1, self._powers[-1]])
        rows[:, self._powers] = slow.power[:count]
        rows[:, self._powers[-1]] += self._before
        if back is not None:
            self._component.set_amplitude(slow.amplitude[back])
            self._energy = float(rows[-1, self._powers[-1]]) - own
            stretch.end, self._open = float(time[back]), None
        return rows

    def _end_of(self, stretch: Stretch, slow: SlowPart, time: Floats, first: int) -> int | None:
        """Return which of the points, from number `first` on, ends the stretch, if one does."""
        going_on = min(len(time), self._plan.schedule.steps - first)  # steps that follow
        angle, _, _ = self._full.excitation.at(time[:going_on])
        amplitude, rate = slow.amplitude[:going_on], slow.rate[:going_on]
        error = self._error.at(amplitude, angle, first, rate=rate)
        error = np.maximum(error, self._error.at(amplitude, angle, first))
        stretch.error = np.maximum(stretch.error, error.max(axis=0, initial=0.0))
        window = self._full.window
        for k, now in enumerate(time[:going_on]):
            near = (self._jumps > now - window) & (self._jumps <= now + 0.5 * window)
            if np.any(error[k] > SETTLED * self._allowed) or near.any():
                stretch.last_fast = float(now)
            elif now - stretch.last_fast >= 0.5 * window <= now - stretch.start:
                return k
        return None

    def _keep(self, rows: Floats) -> None:
        """Keep rows as far back as a later stretch may need them, and advance the point."""
        self._point += len(rows)
        self._rows = np.vstack((self._rows, rows))
        time = self._plan.schedule.time(slice(self._first, self._point + 1))
        drop = max(int(np.searchsorted(time, time[-1] - self._spin_up)) - 1, 0)
        self._rows, self._first = self._rows[drop:], self._first + drop

    def _shifted(self, rows: Floats) -> Floats:
        """Return outputs of the component with the energy that stretches dissipated."""
        rows[:, self._powers[-1]] += self._energy
        return rows


def stepper(plan: Plan, model: Model) -> Component | Hybrid:
    """Return what takes the steps of a scene, with stretches at full order if it switches."""
    if plan.scene.switches:
        return Hybrid(plan, model)
    return plan.component(model)


def fast_motion(
    component: Stepper, plan: Plan, model: Model, trajectory: SlowTrajectory, times: Floats
) -> FastMotion:
    """Return the motion at increasing times of a run, from slow time or from full order."""
    if plan.excited.waves is not None:
        dofs = plan.scene.output.elastic
        moved = plan.excited.waves.sector.motion(model, trajectory, times, dofs)
        modal = reconstruct(model, trajectory, times).modal
        return FastMotion(times, **vars(moved), modal=modal)
    number = full_order_number(component, times)
    parts = []
    for k in np.unique(number):
        own = times[number == k]
        if k % 2:
            parts.append(cast(Hybrid, component).stretches[k // 2].motion(own))
            continue
        slow = reconstruct(model, trajectory, own)
        elastic = slow.elastic(model, plan.scene.output.elastic)
        modal = slow.modal[:, : model.modes]
        parts.append(FastMotion(own, slow.displacement, slow.velocity, slow.force, modal, elastic))
    names = [field.name for field in fields(FastMotion)]
    return FastMotion(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))


def full_order_number(component: Stepper, times: Floats) -> NDArray[np.int64]:
    """Return 2 k + 1 for times (n,) in stretch k at full order, even numbers in slow time."""
    stretches = component.stretches if isinstance(component, Hybrid) else []
    edges = [edge for stretch in stretches for edge in (stretch.start, stretch.end)]
    return np.searchsorted(edges, times, side="right")
