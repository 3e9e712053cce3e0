"""A pass of amplitudes on one tone through a scene, with its recording."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.states import contact_states, harmonic_force
from slipmode.runner.plan.mistuned import MistunedPlan
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.plan.tone_plan import TonePlan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.keys import Window
from slipmode.runner.transients.disk_motion import SAMPLES
from slipmode.runner.transients.motion import FastMotion, record_amplitudes, record_findings
from slipmode.runner.transients.passes import Pass

_STEPS_PER_BLOCK = 256  # between recordings: less than a second of work with 24 sectors
_INPUTS = ("frequency_A", "force_A", "phase_A")

AnyTonePlan = TypeVar("AnyTonePlan", bound=TonePlan)


class TonePass(Pass[AnyTonePlan]):
    """Steps of a tone through slow time, to communication points and samples of windows."""

    def __init__(
        self, plan: AnyTonePlan, recorder: Recorder, raise_if_interrupted: Callable[[], None]
    ) -> None:
        super().__init__(plan, recorder, raise_if_interrupted)
        self._flow = plan.flow()
        times = [self._times(each) for each in self._windows]
        # windows may touch
        self._sample_times = np.unique(np.concatenate(times)) if times else np.zeros(0)
        self._sampled: dict[float, Complexes] = {}

    @abstractmethod
    def _row(self) -> Floats:
        """Return what is recorded at a communication point."""

    @abstractmethod
    def _record_rows(self, first: int, rows: Floats) -> None:
        """Record the rows of communication points from number `first` on."""

    @abstractmethod
    def _harmonics(self) -> Complexes:
        """Return the present harmonics of what is sampled in windows."""

    def _times(self, window: Window) -> Floats:
        """Return the times of the samples in a window."""
        return self._plan.schedule.sample_times(window)

    def _advance(self) -> Iterator[int]:
        """Integrate and record blocks of steps; yield the number of steps each time."""
        plan, schedule = self._plan, self._plan.schedule
        self._recorder.event(0.0, "info", f"{plan.scene.title}: {plan.summary}")
        record_findings(self._recorder, plan.decisions)
        for first in range(0, schedule.steps, _STEPS_PER_BLOCK):
            self._raise_if_interrupted()
            block = slice(first, min(first + _STEPS_PER_BLOCK, schedule.steps))
            points = schedule.time(slice(first, block.stop + 1))
            starts, ends = schedule.inputs(_INPUTS, block), schedule.at_ends(_INPUTS, block)
            if first == 0:
                self._set(starts[0])
                self._record_rows(0, self._row()[np.newaxis])
                self._sample(0.0)
            rows: list[Floats] = []
            started = time.perf_counter()
            try:
                for k in range(len(starts)):
                    self._set(starts[k])
                    self._step(points[k : k + 2], np.stack((starts[k], ends[k])))
                    rows.append(self._row())
            finally:
                self.seconds += time.perf_counter() - started
                if rows:
                    self._record_rows(first + 1, np.array(rows))
                self._record_windows(float(points[len(rows)]))
            yield block.stop - first

    def _set(self, inputs: Floats) -> None:
        """Let the inputs jump, if they do by more than rounding."""
        flow = self._flow
        if not np.allclose((flow.frequency, flow.magnitude, flow.phase), inputs, 1e-12, 0.0):
            self._go(0.0, inputs)

    def _go(self, duration: float, inputs: Floats) -> None:
        frequency, magnitude, phase = inputs.tolist()
        self._flow.step(duration, frequency=frequency, magnitude=magnitude, phase=phase)

    def _step(self, ends: Floats, inputs: Floats) -> None:
        """Go from one time to another, with the samples that lie between, or at the end.

        `inputs` (2, 3) are the inputs at both times, straight lines in between.
        """
        wanted, now = self._sample_times, ends[0]
        inside = wanted[(wanted > ends[0]) & (wanted < ends[1])]
        for until in (*inside.tolist(), float(ends[1])):
            self._go(until - now, np.array([np.interp(until, ends, each) for each in inputs.T]))
            self._sample(until)
            now = until

    def _sample(self, now: float) -> None:
        """Keep the harmonics, times exp(i theta), and the carrier, if they are wanted now."""
        if now in self._sample_times:
            turned = self._harmonics() * np.exp(1j * self._flow.angle)
            carrier = self._flow.frequency + 1j * self._flow.angle
            self._sampled[now] = np.append(turned, carrier)

    def _samples(self, times: Floats) -> tuple[Complexes, Floats, Floats]:
        """Return harmonics (n, signals), frequencies and angles (n,) at times."""
        rows = np.array([self._sampled[each] for each in times.tolist()])
        return rows[:, :-1], rows[:, -1].real, rows[:, -1].imag

    def _record_windows(self, reached: float) -> None:
        super()._record_windows(reached)
        needed = self._windows[0].start if self._windows else np.inf
        self._sampled = {now: row for now, row in self._sampled.items() if now >= needed}


class SharedTonePass(TonePass[SharedTonePlan]):
    """A pass of several modes."""

    def _row(self) -> Floats:
        return self._flow.modal_amplitude()[: self._plan.model.modes].view(float)

    def _record_rows(self, first: int, rows: Floats) -> None:
        record_amplitudes(self._plan.schedule, ("A",), self._recorder, first, rows)

    def _harmonics(self) -> Complexes:
        """Return the harmonics of output.elastic, contacts and modes."""
        dofs = list(self._plan.scene.output.elastic)
        moved = self._flow.displacement()[dofs] if dofs else np.zeros(0)
        modal = self._flow.modal_amplitude()[: self._plan.model.modes]
        return np.concatenate((moved, self._flow.contact_displacement(), modal))

    def _record_window(self, window: Window) -> None:
        self._record_motion(window, self._plan.model.reduced, self._motion)

    def _motion(self, times: Floats) -> tuple[FastMotion, Floats | float, Floats]:
        turned, frequency, angle = self._samples(times)
        reduced, dofs = self._plan.model.reduced, len(self._plan.scene.output.elastic)
        assert reduced.contacts is not None
        moved, contacts, modal = np.split(turned, [dofs, dofs + reduced.n_contacts], axis=1)
        motion = FastMotion(
            time=times,
            displacement=2.0 * contacts.real,
            velocity=-2.0 * frequency[:, np.newaxis] * contacts.imag,
            force=harmonic_force(reduced.contacts, contacts),
            modal=2.0 * modal.real,
            elastic=2.0 * moved.real,
        )
        return motion, 1.0, angle[:, np.newaxis]


class MistunedPass(TonePass[MistunedPlan]):
    """A pass of a mistuned disk."""

    def _row(self) -> Floats:
        return self._flow.amplitude(self._plan.dof)

    def _record_rows(self, first: int, rows: Floats) -> None:
        schedule, points = self._plan.schedule, slice(first, first + len(rows))
        at = schedule.time(points)
        self._recorder.write(channels.BLADES, at, rows)
        inputs = schedule.at_points(["force_A", "frequency_A", "phase_A"], points)
        self._recorder.write("/forcing", at, inputs)

    def _times(self, window: Window) -> Floats:
        return super()._times(window)[-SAMPLES:]

    def _harmonics(self) -> Complexes:
        """Return the harmonics of the recorded DOF of every blade, then of all contacts."""
        moved = self._flow.displacement()[:, self._plan.dof]
        return np.concatenate((moved, self._flow.contact_displacement()))

    def _record_window(self, window: Window) -> None:
        """Record one DOF, and the state of the first contact, of every sector."""
        disk, times = self._plan.disk.structure, self._times(window)
        sectors, contacts = disk.sectors, disk.n_contacts
        turned, *_ = self._samples(times)
        # each contact of a sector is one of the elements, at sectors times as many instants
        c = turned[:, sectors:].reshape(-1, contacts)
        elements = self._plan.disk.law.elements(contacts)
        states = contact_states(elements, 2.0 * c.real, harmonic_force(elements, c)).state[:, 0]
        rows = np.hstack((2.0 * turned[:, :sectors].real, states.reshape(-1, sectors)))
        self._recorder.write(channels.DISK, times, rows)
        self.samples += len(rows)
