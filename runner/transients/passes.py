"""A pass through a scene, in slow time or at full order, with its recording."""

from __future__ import annotations

import logging
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

import numpy as np
from tqdm import tqdm

from slipmode.fmu import Steppable, StoppedError
from slipmode.rom import Model, Reduced
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.motion import SPIN_UP_PERIODS
from slipmode.rom.slow.transient import said_error
from slipmode.rom.validity import Finding
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.scene_plan import ScenePlan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.disk_motion import record_disk
from slipmode.runner.transients.energy import SlowBalance, full_order_balance
from slipmode.runner.transients.estimate import ErrorRecord, RunError
from slipmode.runner.transients.friction_error import FrictionErrorRecord
from slipmode.runner.transients.full_order import FullOrder, Stretch
from slipmode.runner.transients.hybrid import Hybrid, fast_motion, full_order_number
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    carrier_phases,
    output_row,
    record_contacts,
    record_findings,
    record_points,
    shares_in_words,
    slow_trajectory,
    torus_motion,
)

SAMPLES_PER_BATCH = 16384

# Steps and periods between recordings: about a millisecond of work, less than a second even if a
# step is long.
_STEPS_PER_BLOCK, _PERIODS_PER_BLOCK = 1024, 1e5
_FRICTION_ESTIMATES = 4096  # in a run, about: of the error by friction, some ms in all

_log = logging.getLogger("slipmode.run")


AnyPlan = TypeVar("AnyPlan", bound=ScenePlan)
# Fast motion at times, the factor on limits and preloads, and the phases of the carriers.
MotionAt = Callable[[Floats], tuple[FastMotion, Floats | float, Floats]]


class Pass(ABC, Generic[AnyPlan]):
    """A pass through the schedule of a plan, with its recording.

    `samples` counts the samples of fast motion so far. `seconds` is the wall time of the
    integration alone. `raise_if_interrupted` is called between batches.
    """

    def __init__(
        self, plan: AnyPlan, recorder: Recorder, raise_if_interrupted: Callable[[], None]
    ) -> None:
        self.samples, self.seconds = 0, 0.0
        self._plan = plan
        self._recorder = recorder
        self._raise_if_interrupted = raise_if_interrupted
        self._windows = plan.scene.windows

    def run(self, progress: bool) -> None:
        """Go through the scene, and record each window once its end is reached."""
        steps = self._plan.schedule.steps
        with tqdm(total=steps, unit=" steps", delay=1.0, disable=not progress) as bar:
            for done in self._advance():
                bar.update(done)
        self._recorder.event(self._plan.schedule.duration, "info", "end of the scene")

    @abstractmethod
    def _advance(self) -> Iterator[int]:
        """Integrate and record; yield the number of steps each time."""

    @abstractmethod
    def _record_window(self, window: Window) -> None:
        """Record fast motion in a window."""

    def _record_windows(self, reached: float) -> None:
        while self._windows and self._windows[0].end <= reached:
            self._record_window(self._windows.pop(0))

    def _record_motion(self, window: Window, reduced: Reduced, motion_at: MotionAt) -> None:
        """Record fast motion in a window, and the share that contacts spent in each state."""
        plan, recorder, shares = self._plan, self._recorder, []
        times = plan.schedule.sample_times(window)
        for first in range(0, times.size, SAMPLES_PER_BATCH):
            self._raise_if_interrupted()
            batch = times[first : first + SAMPLES_PER_BATCH]
            moved, scale, phases = motion_at(batch)
            if window in plan.scene.contact:
                share = record_contacts(recorder, reduced, moved, scale)
                shares += [] if share is None else [batch.size * share]
            if plan.scene.output.elastic:
                recorder.write("/elastic", batch, moved.elastic)
            if self._is_on_torus(window):
                recorder.write(channels.PHASES, batch, phases)
            self.samples += batch.size
        if shares:
            start, end = window.start, window.end
            mean = np.sum(shares, axis=0) / times.size
            recorder.write(channels.SHARE, np.array([end]), mean.reshape(1, -1))
            recorder.event(end, "info", f"{start:g} to {end:g} s: {shares_in_words(mean)}")

    def _is_on_torus(self, window: Window) -> bool:
        two = {"force_A", "force_B"} <= self._plan.schedule.scripts.keys()
        return two and window in self._plan.scene.contact


class SlowPass(Pass[Plan]):
    """Steps of a component through slow time."""

    def __init__(
        self,
        plan: Plan,
        recorder: Recorder,
        raise_if_interrupted: Callable[[], None],
        model: Model,
        component: Steppable,
    ) -> None:
        super().__init__(plan, recorder, raise_if_interrupted)
        self._model, self._component = model, component
        self._error = RunError(plan, model)
        self._errors, self._friction = ErrorRecord(plan), FrictionErrorRecord(plan, model)
        self._balance = SlowBalance(plan, model)
        self._reported = 0  # stretches at full order
        self._now = 0.0  # from the schedule: a sum of steps is rounded differently
        inputs = plan.schedule.inputs(component.input_names, slice(1))
        component.set_inputs(**dict(zip(component.input_names, inputs[0].tolist(), strict=True)))
        self._columns = OutputColumns.of(component.output_names, plan.excited.modes)
        self._rows = deque([output_row(component)])
        self._first = 0  # communication point of the first row
        reached = plan.schedule.frequency_range(plan.excited.modes)
        longest, shortest = 2 * np.pi / reached[0].min(), 2 * np.pi / reached[1].max()
        self._spin_up = SPIN_UP_PERIODS * longest
        # the transient error is estimated four times a cycle
        self._estimate_every = max(int(0.25 * shortest / plan.scene.run.step), 1)
        self._friction_every = max(plan.schedule.steps // _FRICTION_ESTIMATES, 1)
        at_once = int(_PERIODS_PER_BLOCK * shortest / plan.scene.run.step)
        self._steps_per_block = min(max(at_once, 1), _STEPS_PER_BLOCK)

    def _advance(self) -> Iterator[int]:
        plan, schedule, recorder = self._plan, self._plan.schedule, self._recorder
        (contacts, _), accuracy = plan.excited.contacts, self._model.accuracy
        summary = (
            f"{plan.scene.title}: mode {' and '.join(plan.excited.modes)}, "
            f"{contacts.n_contacts} contacts, {contacts.formulation} formulation, "
            f"table tolerance {accuracy.tolerance:g}"
        )
        recorder.event(0.0, "info", summary)
        record_findings(recorder, plan.decisions)  # `run` has printed them
        self._record(self._rows[0], 0)
        for first in range(0, schedule.steps, self._steps_per_block):
            block = slice(first, min(first + self._steps_per_block, schedule.steps))
            inputs = schedule.inputs(self._component.input_names, block)
            self._raise_if_interrupted()
            started = time.perf_counter()
            try:
                outputs = self._component.run(schedule.durations(block), inputs)
            except StoppedError as stop:
                self._keep(stop.outputs, first)
                self._report_friction()
                raise
            finally:
                self.seconds += time.perf_counter() - started
            self._keep(outputs, first)
            yield block.stop - first
        self._report_stretches(over=True)
        largest = self._errors.finding()
        recorder.event(self._now, largest.level, largest.reason)
        if plan.scene.model.amplitude is not None and largest.level == "warning":
            _log.warning("%s", largest.line())  # the plan does not know it
        self._report_friction()

    def _report_friction(self) -> None:
        """Record findings about friction so far; print warnings."""
        for found in self._friction.findings():
            words = command_words(found.line())
            self._recorder.event(self._now, found.level, words)
            if found.level == "warning":
                _log.warning("%s", words)

    def _report_stretches(self, *, over: bool = False) -> None:
        """Record which stretches were at full order, if they have ended or the run is over."""
        if not isinstance(self._component, Hybrid):
            return
        for stretch in self._component.stretches[self._reported :]:
            if over or np.isfinite(stretch.end):
                end = min(stretch.end, self._now)
                error = said_error(self._plan.excited.modes, stretch.error)
                words = f"full order from {stretch.start:g} to {end:g} s: {error} in slow time"
                self._recorder.event(end, "info", words)
                self._reported += 1

    def _keep(self, outputs: Floats, first: int) -> None:
        """Record the outputs of the steps from number `first` on."""
        if not len(outputs):
            return
        self._note_errors(outputs, first)
        self._rows.append(outputs)
        self._now = self._time_at(first + len(outputs))
        self._report_stretches()
        self._record(outputs, first + 1)
        self._record_windows(self._now)
        window = self._windows[0].start if self._windows else np.inf
        needed = min(self._now, window - self._spin_up)
        while len(self._rows) > 1 and self._time_at(self._first + len(self._rows[0])) <= needed:
            self._first += len(self._rows.popleft())

    def _note_errors(self, outputs: Floats, first: int) -> None:
        """Estimate the errors at the starts of steps in slow time."""
        self._note_friction(outputs, first)
        every = self._estimate_every
        starts = np.vstack((self._rows[-1][-1:], outputs[:-1]))[::every]
        amplitude, angle = self._columns.amplitudes(starts), starts[:, self._columns.angle]
        error = self._error.at(amplitude, angle, first, every)
        time = self._plan.schedule.time(slice(first, first + len(outputs) + 1))
        time = np.append(time[:-1:every], time[-1])
        error[full_order_number(self._component, time[:-1]) % 2 == 1] = 0.0
        self._errors.add(error, time)

    def _note_friction(self, outputs: Floats, first: int) -> None:
        every = self._friction_every
        steps = slice(-first % every, len(outputs), every)
        starts = np.vstack((self._rows[-1][-1:], outputs[:-1]))[steps]
        if len(starts):
            number = first + steps.start
            time = self._plan.schedule.time(slice(number, first + len(outputs), every))
            in_slow_time = full_order_number(self._component, time) % 2 == 0
            amplitude = self._columns.amplitudes(starts)
            self._friction.add(amplitude, in_slow_time, number, every)

    def _time_at(self, point: int) -> float:
        return float(self._plan.schedule.time(slice(point, point + 1))[0])

    def _record(self, outputs: Floats, first: int) -> None:
        """Record slow channels of the communication points from number `first` on."""
        amplitude, power = self._columns.amplitudes(outputs), outputs[:, self._columns.power]
        energy = self._balance.rows(power, amplitude, first)
        record_points(self._plan, self._recorder, first, amplitude.view(float), energy)

    def _record_window(self, window: Window) -> None:
        outputs = np.concatenate(self._rows)
        self._rows = deque([outputs])
        names = self._component.output_names
        self._trajectory = slow_trajectory(self._plan, self._model, names, outputs, self._first)
        self._record_motion(window, self._plan.excited.contacts[0], self._motion)
        if self._plan.excited.waves is not None:
            record_disk(self._plan, self._recorder, self._model, self._trajectory, window)
        elif self._is_on_torus(window):
            torus = torus_motion(self._model, self._trajectory, window.end)
            self._recorder.write(channels.TORUS, np.full(len(torus), window.end), torus)

    def _motion(self, times: Floats) -> tuple[FastMotion, Floats | float, Floats]:
        slow = self._trajectory
        moved = fast_motion(self._component, self._plan, self._model, slow, times)
        return moved, slow.scale_at(times), carrier_phases(slow, times)


class IntegratedPass(Pass[Plan]):
    """Integration of all of a scene at full order; its amplitudes are demodulated."""

    def __init__(
        self, plan: Plan, recorder: Recorder, raise_if_interrupted: Callable[[], None]
    ) -> None:
        super().__init__(plan, recorder, raise_if_interrupted)
        self._full = FullOrder(plan, plan.excited.reduced)
        self._stretch = Stretch(self._full, self._full.first())
        self._points = plan.schedule.time(slice(0, plan.schedule.steps + 1))

    def _advance(self) -> Iterator[int]:
        plan, stretch, end = self._plan, self._stretch, self._plan.scene.run.duration
        recorder, length = self._recorder, self._full.window
        last = max(end, length)  # a demodulation needs a window
        recorder.event(0.0, "info", f"{plan.scene.title}: integrated without a friction table")
        record_findings(recorder, plan.decisions)
        done = 0
        while done < self._points.size:
            self._raise_if_interrupted()
            started = time.perf_counter()
            stretch.advance(min(stretch.reached + 16.0 * length, last))  # bounds the memory
            known = end if stretch.reached >= last else stretch.reached - 0.5 * length
            count = int(np.searchsorted(self._points, known, "right"))
            points = self._points[done:count]
            slow = stretch.slow(points)
            self.seconds += time.perf_counter() - started
            if not done:  # the start is given; a fit of later motion is less accurate
                slow.amplitude[0], slow.power[0] = plan.excited.initial, 0.0
            _, frequency, _ = self._full.excitation.at(points)
            energy = full_order_balance(plan.excited.reduced.frequency, frequency, slow)
            energy[0] *= done > 0
            record_points(plan, recorder, done, slow.amplitude.view(float), energy)
            yield count - done
            done = count
            self._record_windows(known)

    def _record_window(self, window: Window) -> None:
        self._record_motion(window, self._plan.excited.contacts[0], self._motion)

    def _motion(self, times: Floats) -> tuple[FastMotion, Floats | float, Floats]:
        angle, *_ = self._full.excitation.at(times)
        return self._stretch.motion(times), 1.0, angle % (2.0 * np.pi)


def integration_cost(plan: Plan) -> list[Finding]:
    """Return the cost of full order, for the scene without a table and for stretches of it.

    It is extrapolated from four windows of demodulation, and eight points.
    """
    full = FullOrder(plan, plan.excited.reduced)
    stretch = Stretch(full, full.first())
    started = time.process_time()
    stretch.advance(4.0 * full.window)
    integrated = time.process_time()
    stretch.slow(np.linspace(0.0, stretch.reached, 8))
    demodulated = time.process_time()
    seconds = (integrated - started) * plan.scene.run.duration / stretch.reached
    seconds += (demodulated - integrated) * plan.schedule.steps / 8
    reason = 'a run with model.table = "none"; for many runs a friction table is faster'
    found = [Finding("full-order run", f"about {seconds:.2g} s of processor time", reason)]
    if plan.full_order:
        share = plan.full_order_share
        choice = f"about {share * seconds:.2g} s of processor time"
        reason = f"integrates {percentage(share)} of the scene; the rest is in slow time"
        found.append(Finding("full order in this run", choice, reason))
    return found
