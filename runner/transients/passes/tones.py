"""A pass of several modes on one or two tones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import Elements
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
from slipmode.runner.transients.passes.loop import AnyPlan, Pass, Recording


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

    def _forces(self, elements: Elements, displacement: Floats, first: int) -> Floats:
        """Return forces of contacts (points, N_c) from their motion from point `first` on."""
        times = self._schedule.time(slice(first, first + len(displacement)))
        return force_along(elements, times, displacement)


class SharedTonePass(SampledPass[SharedTonePlan]):
    """A pass of several modes."""

    def __init__(self, plan: SharedTonePlan, recording: Recording) -> None:
        super().__init__(plan, recording, plan.component())
        names, excited = self._component.output_names, plan.excited
        self._columns = OutputColumns.of(names, excited.mode_names, excited.modes)
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
        reduced, (first, rows) = self._plan.model.reduced, self._kept()
        assert reduced.contacts is not None
        names, dofs = self._component.output_names, self._plan.scene.output.elastic
        contacts = range(reduced.n_contacts)
        x, v = ([names.index(f"contact_{i}_{part}") for i in contacts] for part in "xv")
        elastic = [names.index(f"x_{dof}") for dof in dofs]
        angle = rows[:, self._columns.angle]
        carrier = np.exp(1j * angle)[:, reduced.tone_numbers]
        modal = 2.0 * (self._columns.amplitudes(rows) * carrier).real
        force = self._forces(reduced.contacts, rows[:, x], first)
        columns = rows[:, x], rows[:, v], force, modal, rows[:, elastic]

        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            at = self._schedule.numbers(times) - first
            return FastMotion(times, *(each[at] for each in columns)), 1.0, angle[at]

        self._record_motion(window, reduced, motion_at)
