"""Passes of several modes on one or two tones through a scene, with their recordings."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from slipmode.fmu import Steppable, StoppedError
from slipmode.rom.arrays import Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS
from slipmode.runner.plan.mistuned import MistunedPlan
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.sections import Window
from slipmode.runner.transients.energy import ToneBalance
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    force_along,
    output_row,
    record_amplitudes,
    record_findings,
)
from slipmode.runner.transients.passes import Pass

_STEPS_PER_BLOCK = 256  # between recordings: less than a second of work with 24 sectors
_SAME = 2e-9  # Of a step: communication points of a schedule that are closer are one point

AnyTonePlan = TypeVar("AnyTonePlan", bound=SharedTonePlan | MistunedPlan)


class TonePass(Pass[AnyTonePlan]):
    """Steps of a component to communication points and to the samples of windows.

    The samples begin some periods before a window, so that the forces of its contacts follow from
    their motion.
    """

    def __init__(
        self,
        plan: AnyTonePlan,
        recorder: Recorder,
        raise_if_interrupted: Callable[[], None],
        component: Steppable,
    ) -> None:
        super().__init__(plan, recorder, raise_if_interrupted)
        self._component, schedule = component, plan.schedule
        tones = list(plan.scene.forcing)
        slowest = float(schedule.frequency_range(tones)[0].min())
        self._spin_up = SPIN_UP_PERIODS * 2.0 * np.pi / slowest
        sampled = [self._with_spin_up(window) for window in self._windows]
        self._fine = replace(schedule, points=tuple(np.concatenate([[], *sampled]).tolist()))
        self._is_point = np.zeros(self._fine.steps + 1, dtype=bool)
        self._is_point[self._numbers(self._fine.time(), schedule.time())] = True
        self._recorded = 0  # communication points
        self._time, self._rows = np.empty(0), np.empty((0, len(component.output_names)))

    @abstractmethod
    def _record(self, rows: Floats) -> None:
        """Record slow channels of communication points from number `_recorded` on."""

    def _times(self, window: Window) -> Floats:
        """Return the times of the samples in a window."""
        return self._plan.schedule.sample_times(window)

    def _with_spin_up(self, window: Window) -> Floats:
        times = self._times(window)
        before = replace(window, start=max(times[0] - self._spin_up, 0.0), end=times[0])
        return np.append(self._plan.schedule.sample_times(before), times)

    def _numbers(self, points: Floats, times: Floats) -> NDArray[np.intp]:
        """Return which points have these times."""
        return np.searchsorted(points, times - _SAME * self._plan.scene.run.step)

    def _advance(self) -> Iterator[int]:
        plan, fine, component = self._plan, self._fine, self._component
        self._recorder.event(0.0, "info", f"{plan.scene.title}: {plan.summary}")
        record_findings(self._recorder, plan.decisions)
        start = fine.inputs(component.input_names, slice(1))[0].tolist()
        component.set_inputs(**dict(zip(component.input_names, start, strict=True)))
        self._keep(output_row(component), 0)
        for first in range(0, fine.steps, _STEPS_PER_BLOCK):
            block = slice(first, min(first + _STEPS_PER_BLOCK, fine.steps))
            inputs = fine.inputs(component.input_names, block)
            self._raise_if_interrupted()
            started, before = time.perf_counter(), self._recorded
            try:
                rows = component.run(fine.durations(block), inputs)
            except StoppedError as stop:
                self._keep(stop.outputs, first + 1)
                raise
            finally:
                self.seconds += time.perf_counter() - started
            self._keep(rows, first + 1)
            yield self._recorded - before

    def _keep(self, rows: Floats, first: int) -> None:
        """Record communication points among points from number `first` on, and windows."""
        points = slice(first, first + len(rows))
        recorded = rows[self._is_point[points]]
        self._record(recorded)
        self._recorded += len(recorded)
        self._time = np.append(self._time, self._fine.time(points))
        self._rows = np.vstack((self._rows, rows))
        self._record_windows(float(self._time[-1]))
        window = self._times(self._windows[0])[0] if self._windows else np.inf
        kept = self._time >= window - self._spin_up
        self._time, self._rows = self._time[kept], self._rows[kept]


class SharedTonePass(TonePass[SharedTonePlan]):
    """A pass of several modes."""

    def __init__(
        self, plan: SharedTonePlan, recorder: Recorder, raise_if_interrupted: Callable[[], None]
    ) -> None:
        super().__init__(plan, recorder, raise_if_interrupted, plan.component())
        names, modes = self._component.output_names, plan.model.reduced.mode_names
        self._columns = OutputColumns.of(names, modes, plan.excited.modes)
        self._balance = ToneBalance(plan.model.reduced)

    def _record(self, rows: Floats) -> None:
        schedule, tones, first = self._plan.schedule, self._plan.excited.modes, self._recorded
        points, amplitude = slice(first, first + len(rows)), self._columns.amplitudes(rows)
        record_amplitudes(schedule, tones, self._recorder, first, amplitude.view(float))
        time = schedule.time(points)
        frequency = schedule.at_points([f"frequency_{name}" for name in tones], points)
        energy = self._balance.rows(time, rows[:, self._columns.power], amplitude, frequency)
        self._recorder.write("/energy", time, energy)

    def _record_window(self, window: Window) -> None:
        reduced, rows = self._plan.model.reduced, self._rows
        assert reduced.contacts is not None
        names, dofs = self._component.output_names, self._plan.scene.output.elastic
        contacts = range(reduced.n_contacts)
        x, v = ([names.index(f"contact_{i}_{part}") for i in contacts] for part in "xv")
        elastic = [names.index(f"x_{dof}") for dof in dofs]
        angle = rows[:, self._columns.angle]
        carrier = np.exp(1j * angle)[:, reduced.tone_numbers]
        modal = 2.0 * (self._columns.amplitudes(rows) * carrier).real
        force = force_along(reduced.contacts, self._time, rows[:, x])
        columns = rows[:, x], rows[:, v], force, modal, rows[:, elastic]

        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            at = self._numbers(self._time, times)
            return FastMotion(times, *(each[at] for each in columns)), 1.0, angle[at]

        self._record_motion(window, reduced, motion_at)
