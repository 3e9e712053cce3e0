"""The loop of all passes through a scene: steps of a component, points and windows recorded."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Reduced
from slipmode.rom.arrays import Floats
from slipmode.rom.progress import progress_bar
from slipmode.rom.slow.motion import SPIN_UP_PERIODS
from slipmode.runner.plan.scene_plan import ScenePlan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.motion import (
    FastMotion,
    Stepper,
    output_row,
    record_contacts,
    record_findings,
    shares_in_words,
)

SAMPLES_PER_BATCH = 16384

# Fast motion at times, the factor on limits and preloads, and the phases of the carriers.
MotionAt = Callable[[Floats], tuple[FastMotion, Floats | float, Floats]]
AnyPlan = TypeVar("AnyPlan", bound=ScenePlan)


class Recording(NamedTuple):
    """Where a pass records, and what it calls between batches to end at once."""

    recorder: Recorder
    raise_if_interrupted: Callable[[], None]


class Pass(ABC, Generic[AnyPlan]):
    """A pass through the schedule of a plan, with its recording.

    `samples` counts the samples of fast motion so far. `seconds` is the wall time of the
    integration alone.
    """

    steps_per_block = 1024  # between recordings: about a millisecond of work

    def __init__(self, plan: AnyPlan, recording: Recording, component: Stepper) -> None:
        self.samples, self.seconds = 0, 0.0
        self._plan, self._component = plan, component
        self._recorder, self._raise_if_interrupted = recording
        self._windows = plan.scene.windows
        self._schedule = plan.schedule  # of steps; a pass may add points to it
        self._recorded = 0  # communication points
        carriers = [name for name in plan.schedule.scripts if name.startswith("frequency_")]
        slowest, _ = plan.schedule.extremes(carriers)
        self._spin_up = SPIN_UP_PERIODS * 2.0 * np.pi / float(slowest.min())
        # numbers of first points, and rows from there on, as far back as windows need them
        self._rows: deque[tuple[int, Floats]] = deque()

    def run(self, progress: bool) -> None:
        """Go through the scene, and record each window once its end is reached."""
        steps = self._plan.schedule.steps
        with progress_bar(total=steps, unit=" steps", delay=1.0, shown=progress) as bar:
            for done in self._advance():
                bar.update(done)
        self._recorder.event(self._plan.schedule.duration, "info", "end of the scene")

    @abstractmethod
    def _record(self, rows: Floats) -> None:
        """Record slow channels of communication points from number `_recorded` on."""

    @abstractmethod
    def _record_window(self, window: Window) -> None:
        """Record fast motion in a window."""

    def _note(self, starts: Floats, first: int) -> None:
        """Note the outputs at the starts of steps from number `first` on."""

    def _end(self) -> None:
        """Record what is known when the steps end, or the run stops."""

    def _advance(self) -> Iterator[int]:
        """Integrate and record; yield the number of communication points each time."""
        schedule, component = self._schedule, self._component
        self._recorder.event(0.0, "info", f"{self._plan.scene.title}: {self._plan.summary}")
        record_findings(self._recorder, self._plan.decisions)  # `run` has printed them
        start = schedule.inputs(component.input_names, slice(1))[0].tolist()
        component.set_inputs(**dict(zip(component.input_names, start, strict=True)))
        self._keep(output_row(component), 0)
        for first in range(0, schedule.steps, self.steps_per_block):
            block = slice(first, min(first + self.steps_per_block, schedule.steps))
            inputs = schedule.inputs(component.input_names, block)
            self._raise_if_interrupted()
            started, before = time.perf_counter(), self._recorded
            try:
                rows = component.run(schedule.durations(block), inputs)
            except StoppedError as stop:
                self._keep(stop.outputs, first + 1)
                self._end()
                raise
            finally:
                self.seconds += time.perf_counter() - started
            self._keep(rows, first + 1)
            yield self._recorded - before
        self._end()

    def _keep(self, rows: Floats, first: int) -> None:
        """Record points from number `first` on, and windows that end there."""
        if not len(rows):
            return
        if self._rows:
            _, before = self._rows[-1]
            self._note(np.vstack((before[-1:], rows[:-1])), first - 1)
        self._rows.append((first, rows))
        recorded = self._communication_rows(rows, first)
        self._record(recorded)
        self._recorded += len(recorded)
        now = self._time_at(first + len(rows) - 1)
        while self._windows and self._windows[0].end <= now:
            self._record_window(self._windows.pop(0))
        needed = min(now, self._windows[0].start - self._spin_up) if self._windows else now
        while len(self._rows) > 1 and self._time_at(self._rows[1][0]) <= needed:
            self._rows.popleft()

    def _communication_rows(self, rows: Floats, first: int) -> Floats:
        """Return rows at points of the plan's schedule, out of those from number `first` on."""
        if self._schedule is self._plan.schedule:
            return rows
        times = self._plan.schedule.time(slice(self._recorded, self._recorded + len(rows)))
        at = self._schedule.numbers(times) - first
        return np.asarray(rows[at[at < len(rows)]])

    def _kept(self) -> tuple[int, Floats]:
        """Return the number of the first point that is kept, and the rows from there on."""
        first = self._rows[0][0]
        rows = np.concatenate([each for _, each in self._rows])
        self._rows = deque([(first, rows)])
        return first, rows

    def _time_at(self, point: int) -> float:
        return float(self._schedule.time(slice(point, point + 1))[0])

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
