"""The loop of all passes through a scene: steps, points and windows recorded."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Generic, NamedTuple

import numpy as np

from slipmode.fmu import Steppable, StoppedError
from slipmode.rom import Reduced
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.elements import Elements
from slipmode.rom.progress import progress_bar
from slipmode.rom.slow.motion import SPIN_UP_PERIODS
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import Kind, ModesPlan, Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.band import SampleBand
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    force_along,
    record_contacts,
    record_points,
    shares_in_words,
)

SAMPLES_PER_BATCH = 16384

# Fast motion at times, the factor on limits and preloads, and the phases of the carriers.
MotionAt = Callable[[Floats], tuple[FastMotion, Floats | float, Floats]]
EnergyRows = Callable[[Floats, Complexes, int], Floats]


class Destination(NamedTuple):
    """Where a pass records, and what it calls between batches to end at once."""

    recorder: Recorder
    raise_if_interrupted: Callable[[], None] = lambda: None
    keep: Callable[[FastMotion], Any] = lambda motion: None  # Called with the motion of contacts


class Pass(ABC, Generic[Kind]):
    """A pass through the schedule of a plan, with its recording.

    `samples` counts the samples of fast motion so far. `seconds` is the wall time of the
    integration alone.
    """

    steps_per_block = 1024  # between recordings: about a millisecond of work

    def __init__(self, plan: Plan[Kind], destination: Destination) -> None:
        self.samples, self.seconds = 0, 0.0
        self._plan = plan
        self._recorder, self._raise_if_interrupted, self._keep_motion = destination
        self._windows = plan.scene.windows
        self._schedule = plan.schedule  # of steps; a pass may add points to it
        self._point, self._recorded = -1, 0  # the last point; number of communication points
        carriers = [name for name in plan.schedule.scripts if name.startswith("frequency_")]
        slowest, _ = plan.schedule.extremes(carriers)
        self._spin_up = SPIN_UP_PERIODS * 2.0 * np.pi / float(slowest.min())
        # numbers of first points, and rows from there on, as far back as windows need them
        self._rows: deque[tuple[int, Floats]] = deque()

    def run(self, progress: bool = False) -> None:
        """Go through the scene, and record each window once its end is reached."""
        steps = self._plan.schedule.steps
        with progress_bar(total=steps, unit=" steps", delay=1.0, shown=progress) as bar:
            for done in self._advance():
                bar.update(done)
        self._recorder.event(self._plan.schedule.duration, "info", "end of the scene")

    @property
    def last_row(self) -> Floats:
        """Outputs at the last point, (outputs,)."""
        return np.asarray(self._rows[-1][1][-1])

    @abstractmethod
    def _first_row(self) -> Floats:
        """Return the outputs at the start of the scene, (1, outputs)."""

    @abstractmethod
    def _step(self, steps: slice) -> Floats:
        """Take some of these steps; return the outputs after each, (steps, outputs)."""

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
        self._recorder.event(0.0, "info", f"{self._plan.scene.title}: {self._plan.summary}")
        for each in self._plan.decisions:
            if each.level != "info":  # `run` has printed them
                self._recorder.event(0.0, each.level, command_words(each.line()))
        self._keep(self._first_row())
        steps = self._schedule.steps
        for last in [*range(self.steps_per_block, steps, self.steps_per_block), steps]:
            self._raise_if_interrupted()
            before = self._recorded
            while self._point < last:
                started = time.perf_counter()
                try:
                    rows = self._step(slice(self._point, last))
                except StoppedError as stop:
                    self._keep(stop.outputs)
                    self._end()
                    raise
                finally:
                    self.seconds += time.perf_counter() - started
                self._keep(rows)
            yield self._recorded - before
        self._end()

    def _keep(self, rows: Floats) -> None:
        """Record the next points, and windows that end there."""
        if not len(rows):
            return
        first = self._point + 1
        if self._rows:
            self._note(np.vstack((self.last_row, rows[:-1])), first - 1)
        self._rows.append((first, rows))
        self._point += len(rows)
        recorded = self._communication_rows(rows, first)
        self._record(recorded)
        self._recorded += len(recorded)
        now = self._time_at(self._point)
        while self._windows and self._windows[0].end <= now:
            self._record_window(self._windows.pop(0))
        needed = self._needed(now)
        while len(self._rows) > 1 and self._time_at(self._rows[1][0]) <= needed:
            self._rows.popleft()

    def _needed(self, now: float) -> float:
        """Return the time from which on rows are needed [s]."""
        return min(now, self._windows[0].start - self._spin_up) if self._windows else now

    def _communication_rows(self, rows: Floats, first: int) -> Floats:
        """Return rows at points of the plan's schedule, out of those from number `first` on."""
        if self._schedule is self._plan.schedule:
            return rows
        times = self._plan.schedule.time(slice(self._recorded, self._recorded + len(rows)))
        at = self._schedule.numbers(times) - first
        return np.asarray(rows[at[at < len(rows)]])

    def _step_to_samples(self) -> None:
        """Take steps to the samples of windows as well, from some periods before each window.

        The forces of contacts follow from their motion since then.
        """
        points: list[float] = []
        for window in self._windows:
            times = self._sample_times(window)
            before = replace(window, window=(max(times[0] - self._spin_up, 0.0), times[0]))
            points += [*self._plan.schedule.sample_times(before).tolist(), *times.tolist()]
        self._schedule = replace(self._plan.schedule, points=tuple(points))

    def _sample_times(self, window: Window) -> Floats:
        """Return the times of the samples in a window."""
        return self._plan.schedule.sample_times(window)

    def _forces(self, elements: Elements, displacement: Floats, first: int) -> Floats:
        """Return forces of contacts (points, N_c) from their motion from point `first` on."""
        times = self._schedule.time(slice(first, first + len(displacement)))
        return force_along(elements, times, displacement)

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
        times = self._sample_times(window)
        for first in range(0, times.size, SAMPLES_PER_BATCH):
            self._raise_if_interrupted()
            batch = times[first : first + SAMPLES_PER_BATCH]
            moved, scale, phases = motion_at(batch)
            if window in plan.scene.contact:
                self._keep_motion(moved)
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
        return len(self._plan.excited.modes) == 2 and window in self._plan.scene.contact


class ComponentPass(Pass[Excited]):
    """A pass of modes whose steps a component takes.

    `energy` returns the rows of ``/energy``, see `SlowBalance.rows`.
    """

    def __init__(
        self, plan: ModesPlan, destination: Destination, component: Steppable, energy: EnergyRows
    ) -> None:
        super().__init__(plan, destination)
        self._component, self._energy_rows = component, energy
        self._columns = OutputColumns.of(component.output_names, plan.excited)
        self._band: SampleBand | None = None

    def _first_row(self) -> Floats:
        component = self._component
        start = self._schedule.inputs(component.input_names, slice(1))[0].tolist()
        component.set_inputs(**dict(zip(component.input_names, start, strict=True)))
        now = component.outputs()
        return np.array([[now[name] for name in component.output_names]])

    def _step(self, steps: slice) -> Floats:
        inputs = self._schedule.inputs(self._component.input_names, steps)
        return self._component.run(self._schedule.durations(steps), inputs)

    def _record(self, rows: Floats) -> None:
        amplitude, first = self._columns.amplitudes(rows), self._recorded
        energy = self._energy_rows(rows[:, self._columns.power], amplitude, first)
        slow = first, amplitude.view(float), energy
        record_points(self._plan, self._recorder, *slow, self._band)
