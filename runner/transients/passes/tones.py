"""A pass of several modes on one or two tones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.scene.keys import Window
from slipmode.runner.transients.energy import ToneBalance
from slipmode.runner.transients.motion import (
    FastMotion,
    OutputColumns,
    Stepper,
    force_along,
    record_amplitudes,
)
from slipmode.runner.transients.passes.loop import SAME, AnyPlan, Pass, Recording


class SampledPass(Pass[AnyPlan]):
    """A pass that takes steps to the samples of windows as well.

    The samples begin some periods before a window, so that the forces of its contacts follow from
    their motion.
    """

    steps_per_block = 256  # between recordings: less than a second of work with 24 sectors

    def __init__(self, plan: AnyPlan, recording: Recording, component: Stepper) -> None:
        super().__init__(plan, recording, component)
        sampled = [self._with_spin_up(window) for window in self._windows]
        points = tuple(np.concatenate([[], *sampled]).tolist())
        self._schedule = replace(plan.schedule, points=points)

    def _times(self, window: Window) -> Floats:
        """Return the times of the samples in a window."""
        return self._plan.schedule.sample_times(window)

    def _with_spin_up(self, window: Window) -> Floats:
        times = self._times(window)
        before = replace(window, window=(max(times[0] - self._spin_up, 0.0), times[0]))
        return np.append(self._plan.schedule.sample_times(before), times)

    def _sampled(self) -> tuple[Floats, Floats]:
        """Return the times of the points that are kept, and their rows."""
        first, rows = self._kept()
        return self._schedule.time(slice(first, first + len(rows))), rows

    def _numbers(self, points: Floats, times: Floats) -> NDArray[np.intp]:
        """Return which points have these times."""
        return np.searchsorted(points, times - SAME * self._plan.scene.run.step)


class SharedTonePass(SampledPass[SharedTonePlan]):
    """A pass of several modes."""

    def __init__(self, plan: SharedTonePlan, recording: Recording) -> None:
        super().__init__(plan, recording, plan.component())
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
        reduced, (points, rows) = self._plan.model.reduced, self._sampled()
        assert reduced.contacts is not None
        names, dofs = self._component.output_names, self._plan.scene.output.elastic
        contacts = range(reduced.n_contacts)
        x, v = ([names.index(f"contact_{i}_{part}") for i in contacts] for part in "xv")
        elastic = [names.index(f"x_{dof}") for dof in dofs]
        angle = rows[:, self._columns.angle]
        carrier = np.exp(1j * angle)[:, reduced.tone_numbers]
        modal = 2.0 * (self._columns.amplitudes(rows) * carrier).real
        force = force_along(reduced.contacts, points, rows[:, x])
        columns = rows[:, x], rows[:, v], force, modal, rows[:, elastic]

        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            at = self._numbers(points, times)
            return FastMotion(times, *(each[at] for each in columns)), 1.0, angle[at]

        self._record_motion(window, reduced, motion_at)
