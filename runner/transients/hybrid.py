"""Slow time where amplitudes change slowly, full order where they do not.

A stretch at full order begins at the communication point where an amplitude of the slow flow
changes by more than `LARGEST_CHANGE` within a cycle: from the motion that slow time has there, at
t = 0 from that of the scene. It is handed back at the first point that has no change by more than
`_SETTLED` within a window before it, neither at full order nor in the slow flow that would go on
from its amplitudes.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from slipmode.fmu import Component, Steppable, StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS, reconstruct, sum_harmonics
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.slow.transient import LARGEST_CHANGE, change_per_cycle
from slipmode.runner.plan.plan import Plan
from slipmode.runner.trajectory import slow_trajectory
from slipmode.runner.transients.change import SlowChange
from slipmode.runner.transients.full_order import FastMotion, FullOrder, SlowPart, Stretch

_SETTLED = 0.01  # change within a cycle below which the slow flow goes on; it errs by as much
_WINDOWS_AT_ONCE = 4.0  # that full order is integrated ahead
_JUMP = 1e-9  # of a force or a frequency, relative: less is rounding


class Hybrid:
    """What the runner drives in place of a component whose transients are integrated.

    It follows the schedule of its plan: `run` has to be given the steps of that, in order.

    Attributes
    ----------
    stretches : list of Stretch
        At full order, in time order; the last one may not be over.
    """

    def __init__(self, plan: Plan, model: Model) -> None:
        self._plan, self._model = plan, model
        self._component = plan.component(model)
        self.input_names = self._component.input_names
        self.output_names = self._component.output_names
        self.stretches: list[Stretch] = []
        self._change = SlowChange(plan, model)
        self._full = FullOrder(plan, model.reduced)
        modes = plan.excited.modes
        least, _ = plan.schedule.extremes([f"frequency_{mode}" for mode in modes])
        self._window = self._full.window
        self._cycle = 2.0 * np.pi / float(least.min())
        self._spin_up = (SPIN_UP_PERIODS + 2.0) * self._cycle
        self._jumps = _jumps(plan)
        self._point = 0
        self._energy = 0.0  # beyond what the component has
        self._before = 0.0  # energy at the start of a stretch
        self._open: Stretch | None = None
        column = {name: k for k, name in enumerate(self.output_names)}
        self._amplitude = [column[f"{m}_{part}"] for m in modes for part in ("re", "im")]
        self._angle = [column[f"theta_{m}"] for m in modes]
        powers = ("input_power", "dissipated_power", "dissipated_energy")
        self._powers = [column[name] for name in powers]
        self._rows = np.empty((0, len(self.output_names)))  # up to the present point
        self._first = 0  # point of the first of them

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values."""
        self._component.set_inputs(**values)

    def do_step(self, time: float, duration: float) -> None:
        """Advance by one step of the schedule."""
        inputs = self._plan.schedule.inputs(self.input_names, slice(self._point, self._point + 1))
        self.run(np.array([duration]), inputs)

    def outputs(self) -> dict[str, float]:
        """Outputs at the present time."""
        if self._point == 0:
            return self._component.outputs()
        return dict(zip(self.output_names, self._rows[-1].tolist(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """The next steps of the schedule; outputs (steps, outputs) after each."""
        if not len(self._rows):
            now = self.outputs()
            self._rows = np.array([[now[name] for name in self.output_names]])
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
        """Steps of the slow flow up to where it is too fast, where a stretch begins."""
        first = self._point
        row = self._rows[-1:]
        change = self._change.at(self._complex(row), row[:, self._angle], first)
        if np.any(change > LARGEST_CHANGE):
            self._begin()
            return np.empty((0, len(self.output_names)))
        state, stopped = self._component.get_state(), None
        try:
            rows = self._shifted(self._component.run(durations, inputs))
        except StoppedError as stop:
            rows, stopped = self._shifted(stop.outputs), stop
        change = self._change.at(self._complex(rows[:-1]), rows[:-1, self._angle], first + 1)
        fast = np.flatnonzero(np.any(change > LARGEST_CHANGE, axis=1))
        if fast.size:
            self._component.set_state(state)
            steps = slice(0, fast[0] + 1)
            rows = self._shifted(self._component.run(durations[steps], inputs[steps]))
        elif stopped is not None:  # its outputs are shifted by now
            raise stopped
        return rows

    def _begin(self) -> None:
        """Start a stretch at the present point."""
        self._before = float(self._rows[-1, self._powers[-1]])
        now = float(self._plan.schedule.time(slice(self._point, self._point + 1))[0])
        if now < self._cycle:  # the contacts have hardly moved: as from the start of the scene
            state, self._before = self._full.first(), 0.0
        else:
            names = list(self.output_names)
            trajectory = slow_trajectory(self._plan, self._model, names, self._rows, self._first)
            state = self._full.state_on(self._model, trajectory)
        self._open = Stretch(self._full, state)
        self.stretches.append(self._open)

    def _fully(self, durations: Floats, inputs: Floats) -> Floats:
        """Steps of the stretch that is open, up to where it is handed back."""
        assert self._open is not None
        stretch, first = self._open, self._point + 1
        points = slice(first, first + len(durations))
        time, end = self._plan.schedule.time(points), self._plan.schedule.duration
        ahead = max(stretch.reached, float(time[0])) + _WINDOWS_AT_ONCE * self._window
        stretch.advance(min(ahead, end))
        known = time <= stretch.reached - 0.5 * self._window
        count = max(int(np.sum(known | (stretch.reached >= end))), 1)
        slow = stretch.slow(time[:count])
        back = self._handed_back(stretch, slow, time[:count], first)
        count = count if back is None else back + 1
        # the component goes on beside: time and angles are its own
        try:
            rows = self._component.run(durations[:count], inputs[:count])
        except StoppedError as stop:
            none = np.empty((0, len(self.output_names)))
            raise StoppedError(str(stop), stop.time, none, stop.left_table) from None
        rows[:, self._amplitude] = slow.amplitude[:count].view(float)
        own = float(rows[-1, self._powers[-1]])
        rows[:, self._powers] = slow.power[:count]
        rows[:, self._powers[-1]] += self._before
        if back is not None:
            self._component.set_amplitude(slow.amplitude[back])
            self._energy = float(rows[-1, self._powers[-1]]) - own
            stretch.end, self._open = float(time[back]), None
        return rows

    def _handed_back(
        self, stretch: Stretch, slow: SlowPart, time: Floats, first: int
    ) -> int | None:
        """Which of the points, from number `first` on, ends the stretch; None: none yet."""
        angle, frequency, _ = self._full.excitation.at(time)
        threshold = self._change.threshold
        change = change_per_cycle(slow.rate, frequency, slow.amplitude, threshold)
        stretch.change = np.maximum(stretch.change, change.max(axis=0))
        going_on = min(len(time), self._plan.schedule.steps - first)  # steps that follow
        change = np.maximum(
            change[:going_on], self._change.at(slow.amplitude[:going_on], angle[:going_on], first)
        )
        for k, now in enumerate(time[:going_on]):
            near = (self._jumps > now - self._window) & (self._jumps <= now + 0.5 * self._window)
            if np.any(change[k] > _SETTLED) or near.any():
                stretch.last_fast = float(now)
            elif now - stretch.last_fast >= 0.5 * self._window <= now - stretch.start:
                return k
        return None

    def _keep(self, rows: Floats) -> None:
        """Go on to the point after rows, and drop what no stretch to come reaches back to."""
        self._point += len(rows)
        self._rows = np.vstack((self._rows, rows))
        time = self._plan.schedule.time(slice(self._first, self._point + 1))
        drop = max(int(np.searchsorted(time, time[-1] - self._spin_up)) - 1, 0)
        self._rows, self._first = self._rows[drop:], self._first + drop

    def _shifted(self, rows: Floats) -> Floats:
        """Outputs of the component with the energy that stretches took."""
        rows[:, self._powers[-1]] += self._energy
        return rows

    def _complex(self, rows: Floats) -> Complexes:
        return np.ascontiguousarray(rows[:, self._amplitude]).view(complex)


def stepper(plan: Plan, model: Model) -> Component | Hybrid:
    """What does the slow-time steps of a scene, transients as its model.transients says."""
    if plan.scene.model.transients == "hybrid":
        return Hybrid(plan, model)
    return plan.component(model)


def fast_motion(
    component: Steppable,
    plan: Plan,
    model: Model,
    trajectory: SlowTrajectory,
    times: Floats,
    *,
    summed: bool = False,
) -> FastMotion:
    """Motion at increasing times of a run: from slow time, but from full order where that ran."""
    stretches = component.stretches if isinstance(component, Hybrid) else []
    edges = [edge for stretch in stretches for edge in (stretch.start, stretch.end)]
    number = np.searchsorted(edges, times, side="right")
    parts = []
    for k in np.unique(number):
        own = times[number == k]
        if k % 2:
            parts.append(stretches[k // 2].motion(own))
            continue
        slow = (sum_harmonics if summed else reconstruct)(model, trajectory, own)
        elastic = slow.elastic(model, plan.scene.output.elastic)
        modal = slow.modal[:, : model.modes]
        parts.append(FastMotion(own, slow.displacement, slow.velocity, slow.force, modal, elastic))
    joined = (
        np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(FastMotion)
    )
    return FastMotion(*joined)


def _jumps(plan: Plan) -> Floats:
    """Times at which forces or frequencies jump [s]."""
    straight, modes = plan.schedule.stretches(), plan.excited.modes
    names = [f"frequency_{mode}" for mode in modes]
    found = np.zeros(straight.steps, dtype=bool)
    for start, end in (
        plan.excited.modal_forces(straight),
        (straight.inputs(names), straight.at_ends(names)),
    ):
        size = np.maximum(np.abs(start).max(axis=0), np.abs(end).max(axis=0))
        found[1:] |= np.any(np.abs(start[1:] - end[:-1]) > _JUMP * size, axis=1)
    return straight.time(slice(straight.steps))[found]
