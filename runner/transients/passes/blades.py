"""A pass of a mistuned disk through a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import joined
from slipmode.rom.laws.states import contact_states
from slipmode.runner.plan.blades import BladesPlan, ExcitedBlades
from slipmode.runner.recording import channels
from slipmode.runner.scene.keys import Window
from slipmode.runner.transients.passes.loop import Destination, Pass
from slipmode.runner.transients.passes.waves import SAMPLES

_INPUTS = ("force_A", "frequency_A", "phase_A")


class BladePass(Pass[ExcitedBlades]):
    """A pass of a mistuned disk. Forces of contacts follow from their motion.

    Rows have the amplitudes of a DOF of all blades [m], the displacements of this DOF [m], and the
    displacements of all contacts, sector by sector [m].
    """

    steps_per_block = 256  # between recordings: less than a second of work with 24 sectors

    def __init__(self, plan: BladesPlan, destination: Destination) -> None:
        super().__init__(plan, destination)
        self._step_to_samples()
        self._flow = plan.excited.flow(plan.scene.run.tolerance)

    def _first_row(self) -> Floats:
        self._go(0.0, self._schedule.inputs(_INPUTS, slice(1))[0])
        return self._row()[np.newaxis]

    def _step(self, steps: slice) -> Floats:
        schedule, flow, rows = self._schedule, self._flow, []
        starts, ends = schedule.inputs(_INPUTS, steps), schedule.at_ends(_INPUTS, steps)
        for k, duration in enumerate(schedule.durations(steps).tolist()):
            now = flow.magnitude, flow.frequency, flow.phase
            if not np.allclose(now, starts[k], 1e-12, 0.0):  # more than rounding
                self._go(0.0, starts[k])
            self._go(duration, ends[k])
            rows.append(self._row())
        return np.array(rows)

    def _go(self, duration: float, inputs: Sequence[float] | Floats) -> None:
        magnitude, frequency, phase = map(float, inputs)
        self._flow.step(duration, frequency=frequency, magnitude=magnitude, phase=phase)

    def _row(self) -> Floats:
        moved = self._flow.displacement()[:, self._plan.excited.dof]
        harmonics = np.concatenate((moved, self._flow.contact_displacement()))
        turned = harmonics * np.exp(1j * self._flow.angle)
        return np.concatenate((2.0 * np.abs(moved), 2.0 * turned.real))

    def _sample_times(self, window: Window) -> Floats:
        return super()._sample_times(window)[-SAMPLES:]

    def _record(self, rows: Floats) -> None:
        schedule, sectors = self._plan.schedule, self._plan.excited.disk.structure.sectors
        points = slice(self._recorded, self._recorded + len(rows))
        time = schedule.time(points)
        self._recorder.write(channels.BLADES, time, rows[:, :sectors])
        self._recorder.write("/forcing", time, schedule.at_points(_INPUTS, points))

    def _record_window(self, window: Window) -> None:
        """Record one DOF, and the state of the first contact, of every sector."""
        mistuned, times = self._plan.excited.disk, self._sample_times(window)
        disk, (first, kept) = mistuned.structure, self._kept()
        at = self._schedule.numbers(times) - first
        own = mistuned.law.elements(disk.n_contacts)
        columns = np.arange(disk.sectors * disk.n_contacts).reshape(disk.sectors, -1)
        elements = joined([(own, each.tolist()) for each in columns], columns.size)
        _, moved, x = np.split(kept, [disk.sectors, 2 * disk.sectors], axis=1)
        force = self._forces(elements, x, first)
        states = contact_states(elements, x[at], force[at]).state[:, :: len(own.element)]
        self._recorder.write(channels.DISK, times, np.hstack((moved[at], states)))
        self.samples += len(times)
