"""A pass of a mistuned disk through a scene, with its recording."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import ValidityWarning
from slipmode.rom.laws.states import harmonic_states
from slipmode.runner.plan.mistuned import MistunedPlan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.transients.disk_motion import SAMPLES
from slipmode.runner.transients.motion import record_findings

_STEPS_PER_BLOCK = 256  # between recordings: less than a second of work with 24 sectors


class MistunedPass:
    """Steps of a mistuned disk through slow time.

    `samples` counts the samples of fast motion so far. `seconds` is the wall time of the
    integration alone. `raise_if_interrupted` is called between blocks of steps.
    """

    def __init__(
        self, plan: MistunedPlan, recorder: Recorder, raise_if_interrupted: Callable[[], None]
    ) -> None:
        self.samples, self.seconds = 0, 0.0
        self._plan, self._recorder = plan, recorder
        self._raise_if_interrupted = raise_if_interrupted
        structure = plan.disk.structure
        self._elements = plan.disk.law.elements(structure.n_contacts)
        middle, force = 0.5 * sum(plan.frequency_range), plan.force
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)  # the plan has this finding
            tolerance = plan.scene.run.tolerance
            self._flow = plan.disk.flow(middle, plan.engine_order, force, tolerance=tolerance)
        self._angle = 0.0  # of the force [rad]
        times = [plan.schedule.sample_times(each)[-SAMPLES:] for each in plan.scene.windows]
        # windows may touch
        self._sample_times = np.unique(np.concatenate(times)) if times else np.zeros(0)

    def run(self, progress: bool) -> None:
        """Go through the scene."""
        plan, recorder = self._plan, self._recorder
        words = f"{plan.disk.structure!r}, mistuned, engine order {plan.engine_order}"
        recorder.event(0.0, "info", f"{plan.scene.title}: {words}")
        record_findings(recorder, plan.decisions)
        steps = plan.schedule.steps
        with tqdm(total=steps, unit=" steps", delay=1.0, disable=not progress) as bar:
            for done in self._advance():
                bar.update(done)
        recorder.event(plan.schedule.duration, "info", "end of the scene")

    def _advance(self) -> Iterator[int]:
        """Integrate and record blocks of steps; yield the number of steps each time."""
        schedule, names = self._plan.schedule, ("frequency_A", "force_A")
        for first in range(0, schedule.steps, _STEPS_PER_BLOCK):
            self._raise_if_interrupted()
            block = slice(first, min(first + _STEPS_PER_BLOCK, schedule.steps))
            points = schedule.time(slice(first, block.stop + 1))
            starts, ends = schedule.inputs(names, block), schedule.at_ends(names, block)
            if first == 0:
                self._set(*starts[0].tolist())
                self._record(0, [self._amplitudes()], self._samples_at(0.0))
            rows: list[Floats] = []
            samples: list[Floats] = []
            started = time.perf_counter()
            try:
                for k in range(len(starts)):
                    self._set(*starts[k].tolist())
                    samples += self._step(points[k : k + 2], np.stack((starts[k], ends[k])))
                    rows.append(self._amplitudes())
            finally:
                self.seconds += time.perf_counter() - started
                self._record(first + 1, rows, samples)
            yield block.stop - first

    def _set(self, frequency: float, magnitude: float) -> None:
        """Let the inputs jump, if they do by more than rounding."""
        now = self._flow.frequency, self._flow.magnitude
        if not np.allclose(now, (frequency, magnitude), rtol=1e-12, atol=0.0):
            self._flow.step(0.0, frequency=frequency, magnitude=magnitude)

    def _step(self, ends: Floats, inputs: Floats) -> list[Floats]:
        """Go from one time to another; return the samples that lie between, or at the end.

        `inputs` (2, 2) are frequency and magnitude at both times, straight lines in between.
        """
        wanted, samples, now = self._sample_times, list[Floats](), ends[0]
        inside = wanted[(wanted > ends[0]) & (wanted < ends[1])]
        for until in (*inside.tolist(), float(ends[1])):
            before = self._flow.frequency
            frequency, magnitude = (np.interp(until, ends, each).item() for each in inputs.T)
            self._flow.step(until - now, frequency=frequency, magnitude=magnitude)
            self._angle += 0.5 * (before + frequency) * (until - now)
            samples += self._samples_at(until)
            now = until
        return samples

    def _amplitudes(self) -> Floats:
        return self._flow.amplitude(self._plan.dof)

    def _samples_at(self, now: float) -> list[Floats]:
        """Return a DOF and the state of the first contact of every sector, if it is wanted now."""
        if now not in self._sample_times:
            return []
        turned = self._flow.displacement()[:, self._plan.dof] * np.exp(1j * self._angle)
        contacts = self._flow.contact_displacement().reshape(turned.size, -1)
        states = harmonic_states(self._elements, contacts, self._angle)[:, 0]
        return [np.concatenate((2.0 * turned.real, states))]

    def _record(self, first: int, rows: list[Floats], samples: list[Floats]) -> None:
        """Record communication points from number `first` on, and the next samples."""
        if not rows:
            return
        schedule, recorder = self._plan.schedule, self._recorder
        points = slice(first, first + len(rows))
        at = schedule.time(points)
        recorder.write(channels.BLADES, at, np.array(rows))
        inputs = schedule.at_points(["force_A", "frequency_A", "phase_A"], points)
        recorder.write("/forcing", at, inputs)
        if samples:
            reached = slice(self.samples, self.samples + len(samples))
            recorder.write(channels.DISK, self._sample_times[reached], np.array(samples))
            self.samples += len(samples)
