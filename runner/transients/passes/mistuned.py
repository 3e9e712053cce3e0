"""A pass of a mistuned disk through a scene, with its recording."""

from __future__ import annotations

import numpy as np

from slipmode.fmu.inputs import rate_of
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import joined
from slipmode.rom.laws.states import contact_states
from slipmode.runner.plan.mistuned import MistunedPlan
from slipmode.runner.recording import channels
from slipmode.runner.scene.keys import Window
from slipmode.runner.transients.disk_motion import SAMPLES
from slipmode.runner.transients.passes.loop import Recording
from slipmode.runner.transients.passes.tones import SampledPass

_INPUTS = ("force_A", "frequency_A", "phase_A")


class MistunedComponent:
    """The slow flow of a mistuned disk, stepped as `fmu.Component` is.

    Its outputs are the amplitudes of a DOF of all blades [m], the displacements of this DOF [m],
    and the displacements of all contacts, sector by sector [m].
    """

    def __init__(self, plan: MistunedPlan) -> None:
        disk = plan.disk.structure
        self._flow, self._dof = plan.flow(), plan.dof
        self.input_names = (*_INPUTS, *map(rate_of, _INPUTS))
        blades, contacts = range(disk.sectors), range(disk.sectors * disk.n_contacts)
        self.output_names = (
            *(f"blade_{j}_amplitude" for j in blades),
            *(f"x_{j}" for j in blades),
            *(f"contact_{i}_x" for i in contacts),
        )

    def set_inputs(self, **values: float) -> None:
        """Let inputs jump to values by name, see `Stepper`; rates act in steps alone."""
        now = dict(zip(_INPUTS, self._inputs, strict=True))
        self._go(0.0, [values.get(name, now[name]) for name in _INPUTS])

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time, see `Stepper`."""
        return dict(zip(self.output_names, self._row().tolist(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Return the outputs after each step, see `Stepper`."""
        rows = np.empty((len(durations), len(self.output_names)))
        starts, rates = np.split(inputs, 2, axis=1)
        ends = starts + rates * durations[:, np.newaxis]
        for k, duration in enumerate(durations.tolist()):
            if not np.allclose(self._inputs, starts[k], 1e-12, 0.0):  # more than rounding
                self._go(0.0, starts[k].tolist())
            self._go(duration, ends[k].tolist())
            rows[k] = self._row()
        return rows

    @property
    def _inputs(self) -> list[float]:
        flow = self._flow
        return [flow.magnitude, flow.frequency, flow.phase]

    def _go(self, duration: float, inputs: list[float]) -> None:
        magnitude, frequency, phase = inputs
        self._flow.step(duration, frequency=frequency, magnitude=magnitude, phase=phase)

    def _row(self) -> Floats:
        moved = self._flow.displacement()[:, self._dof]
        harmonics = np.concatenate((moved, self._flow.contact_displacement()))
        turned = harmonics * np.exp(1j * self._flow.angle)
        return np.concatenate((2.0 * np.abs(moved), 2.0 * turned.real))


class MistunedPass(SampledPass[MistunedPlan]):
    """A pass of a mistuned disk."""

    def __init__(self, plan: MistunedPlan, recording: Recording) -> None:
        super().__init__(plan, recording, MistunedComponent(plan))

    def _times(self, window: Window) -> Floats:
        return super()._times(window)[-SAMPLES:]

    def _record(self, rows: Floats) -> None:
        schedule, first = self._plan.schedule, self._recorded
        points = slice(first, first + len(rows))
        time = schedule.time(points)
        self._recorder.write(channels.BLADES, time, rows[:, : self._plan.disk.structure.sectors])
        self._recorder.write("/forcing", time, schedule.at_points(_INPUTS, points))

    def _record_window(self, window: Window) -> None:
        """Record one DOF, and the state of the first contact, of every sector."""
        disk, times = self._plan.disk.structure, self._times(window)
        first, kept = self._kept()
        at = self._schedule.numbers(times) - first
        own = self._plan.disk.law.elements(disk.n_contacts)
        columns = np.arange(disk.sectors * disk.n_contacts).reshape(disk.sectors, -1)
        elements = joined([(own, each.tolist()) for each in columns], columns.size)
        _, moved, x = np.split(kept, [disk.sectors, 2 * disk.sectors], axis=1)
        force = self._forces(elements, x, first)
        states = contact_states(elements, x[at], force[at]).state[:, :: len(own.element)]
        rows = np.hstack((moved[at], states))
        self._recorder.write(channels.DISK, times, rows)
        self.samples += len(rows)
