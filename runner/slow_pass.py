"""A pass of a component through the schedule of a plan, with its recording."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from tqdm import tqdm

from slipmode.fmu import Steppable, StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS
from slipmode.rom.slow.transient import said_error
from slipmode.runner.motion.record import (
    SAMPLES_PER_BATCH,
    WindowRecord,
    record_findings,
    record_points,
)
from slipmode.runner.motion.torus_motion import carrier_phases, torus_motion
from slipmode.runner.motion.trajectory import sample_times, slow_trajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.estimate import ErrorRecord, RunError
from slipmode.runner.transients.hybrid import Hybrid, fast_motion, full_order_number

# Steps and periods between recordings: about a millisecond of work, less than a second even if a
# step is long.
_STEPS_PER_BLOCK, _PERIODS_PER_BLOCK = 1024, 1e5
_ESTIMATE_PERIODS = 0.25  # between steps whose transient error is estimated: it changes in cycles


class SlowPass:
    """Steps through slow time, and the fast motion of the windows passed.

    Attributes
    ----------
    samples : int
        Number of samples of fast motion so far.
    seconds : float
        Wall time of the steps alone.
    """

    def __init__(
        self,
        plan: Plan,
        model: Model,
        component: Steppable,
        recorder: Recorder,
        raise_if_interrupted: Callable[[], None],
    ) -> None:
        self.samples = 0
        self.seconds = 0.0
        self._plan = plan
        self._model = model
        self._component = component
        self._recorder = recorder
        self._raise_if_interrupted = raise_if_interrupted
        self._error = RunError(plan, model)
        self._errors = ErrorRecord(plan)
        self._reported = 0  # stretches at full order
        self._now = 0.0  # from the schedule: a sum of steps is rounded differently
        inputs = plan.schedule.inputs(component.input_names, slice(1))
        component.set_inputs(**dict(zip(component.input_names, inputs[0].tolist(), strict=True)))
        self._columns = {name: k for k, name in enumerate(component.output_names)}
        self._rows = deque([self._present_row()])
        self._first = 0  # communication point of the first row
        self._windows = plan.scene.windows
        reached = plan.schedule.frequency_range(plan.excited.modes)
        longest, shortest = (
            2 * np.pi / frequency for frequency in (reached[0].min(), reached[1].max())
        )
        self._spin_up = SPIN_UP_PERIODS * longest
        self._estimate_every = max(int(_ESTIMATE_PERIODS * shortest / plan.scene.run.step), 1)
        at_once = int(_PERIODS_PER_BLOCK * shortest / plan.scene.run.step)
        self._steps_per_block = min(max(at_once, 1), _STEPS_PER_BLOCK)

    def through_slow_time(self, progress: bool) -> None:
        """Step, record, and reconstruct each window once its end is reached."""
        schedule = self._plan.schedule
        recorder = self._recorder
        recorder.event(0.0, "info", _summary(self._plan, self._model))
        found = self._model.accuracy.findings()
        reached = schedule.frequency_range(self._plan.excited.modes)
        found += self._model.detuning_findings(np.array(reached))
        record_findings(recorder, (*self._plan.decisions, *found))
        self._record(self._rows[0], 0)
        steps, at_once = schedule.steps, self._steps_per_block
        with tqdm(total=steps, unit=" steps", delay=1.0, disable=not progress) as bar:
            for first in range(0, steps, at_once):
                block = slice(first, min(first + at_once, steps))
                inputs = schedule.inputs(self._component.input_names, block)
                self._advance(schedule.durations(block), inputs, first)
                bar.update(block.stop - first)
        self._report_stretches(over=True)
        largest = self._errors.finding()
        recorder.event(self._now, largest.level, largest.reason)
        recorder.event(self._now, "info", "end of the scene")

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

    def _advance(self, durations: Floats, inputs: Floats, first: int) -> None:
        self._raise_if_interrupted()
        started = time.perf_counter()
        try:
            outputs = self._component.run(durations, inputs)
        except StoppedError as stop:
            self._keep(stop.outputs, first)
            raise
        finally:
            self.seconds += time.perf_counter() - started
        self._keep(outputs, first)

    def _keep(self, outputs: Floats, first: int) -> None:
        """Record the outputs of the steps from number `first` on."""
        if not len(outputs):
            return
        self._note_errors(outputs, first)
        self._rows.append(outputs)
        self._now = self._time_at(first + len(outputs))
        self._report_stretches()
        self._record(outputs, first + 1)
        while self._windows and self._windows[0].end <= self._now:
            self._reconstruct(self._windows.pop(0))
        self._forget()

    def _note_errors(self, outputs: Floats, first: int) -> None:
        """Estimate the transient error at the starts of steps in slow time."""
        modes, every = self._plan.excited.modes, self._estimate_every
        starts = np.vstack((self._rows[-1][-1:], outputs[:-1]))[::every]
        parts = self._take(starts, [f"{m}_{p}" for m in modes for p in ("re", "im")])
        angle = self._take(starts, [f"theta_{m}" for m in modes])
        error = self._error.at(np.ascontiguousarray(parts).view(complex), angle, first, every)
        time = self._plan.schedule.time(slice(first, first + len(outputs) + 1))
        time = np.append(time[:-1:every], time[-1])
        error[full_order_number(self._component, time[:-1]) % 2 == 1] = 0.0
        self._errors.add(error, time)

    def _forget(self) -> None:
        """Drop rows that no later window needs."""
        needed = self._now
        if self._windows:
            needed = min(needed, self._windows[0].start - self._spin_up)
        while len(self._rows) > 1 and self._time_at(self._first + len(self._rows[0])) <= needed:
            self._first += len(self._rows.popleft())

    def _time_at(self, point: int) -> float:
        return float(self._plan.schedule.time(slice(point, point + 1))[0])

    def _present_row(self) -> Floats:
        now = self._component.outputs()
        return np.array([[now[name] for name in self._columns]])

    def _record(self, outputs: Floats, first: int) -> None:
        """Record slow channels of the communication points from number `first` on."""
        modes = self._plan.excited.modes
        parts = self._take(outputs, [f"{m}_{p}" for m in modes for p in ("re", "im")])
        energy = self._take(outputs, ["input_power", "dissipated_power", "dissipated_energy"])
        record_points(self._plan, self._recorder, first, parts, energy)

    def _take(self, outputs: Floats, names: Sequence[str]) -> Floats:
        return outputs[:, [self._columns[name] for name in names]]

    def _reconstruct(self, window: Window) -> None:
        outputs = np.concatenate(self._rows)
        self._rows = deque([outputs])
        names = list(self._columns)
        trajectory = slow_trajectory(self._plan, self._model, names, outputs, self._first)
        record = WindowRecord(self._plan, self._recorder, window)
        on_torus = record.of_contacts and self._model.modes == 2 and self._recorder.keeps
        summed = not record.of_contacts and self._plan.elastic_order is not None
        times = sample_times(window, trajectory)
        for start in range(0, times.size, SAMPLES_PER_BATCH):
            self._raise_if_interrupted()
            batch = times[start : start + SAMPLES_PER_BATCH]
            motion = fast_motion(
                self._component, self._plan, self._model, trajectory, batch, summed=summed
            )
            record.add(motion, trajectory.scale_at(batch))
            if on_torus:
                self._recorder.write(channels.PHASES, batch, carrier_phases(trajectory, batch))
            self.samples += batch.size
        record.finish()
        if on_torus:
            torus = torus_motion(self._model, trajectory, window.end)
            self._recorder.write(channels.TORUS, np.full(len(torus), window.end), torus)


def _summary(plan: Plan, model: Model) -> str:
    modes = " and ".join(plan.excited.modes)
    return (
        f"{plan.scene.title}: mode {modes}, {model.reduced.n_contacts} contacts, "
        f"{model.reduced.formulation} formulation, table tolerance {model.accuracy.tolerance:g}"
    )
