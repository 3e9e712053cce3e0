"""A scene without a friction table: all of it at full order, on the reduced coordinates."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Floats
from slipmode.rom.validity import Finding
from slipmode.runner.motion.record import (
    SAMPLES_PER_BATCH,
    WindowRecord,
    record_findings,
    record_points,
)
from slipmode.runner.motion.trajectory import scripted, window_times
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.full_order import FullOrder, Stretch

_WINDOWS_AT_ONCE = 16.0  # of demodulation: a bound of memory
_TIMED, _TIMED_POINTS = 4.0, 8  # windows and points from which the cost is extrapolated


class IntegratedPass:
    """Integrates the schedule of a plan at full order, and records demodulated amplitudes.

    Attributes
    ----------
    samples : int
        Number of samples of fast motion so far.
    seconds : float
        Wall time of integration and demodulation, without windows.
    """

    def __init__(self, plan: Plan) -> None:
        self.samples = 0
        self.seconds = 0.0
        self._plan = plan
        self._script = scripted(plan.excited, plan.schedule, slice(0, plan.schedule.steps))
        self._full = FullOrder(plan, plan.excited.reduced)
        self._stretch = Stretch(self._full, self._full.first())

    def record(
        self, recorder: Recorder, raise_if_interrupted: Callable[[], None], progress: bool
    ) -> None:
        """Integrate, record, and sample each window once its end is reached."""
        plan, stretch, end = self._plan, self._stretch, self._plan.scene.run.duration
        length = self._full.window
        last = max(end, length)  # a demodulation needs a window
        recorder.event(0.0, "info", f"{plan.scene.title}: integrated, without a friction table")
        record_findings(recorder, plan.decisions)
        points = plan.schedule.time(slice(0, plan.schedule.steps + 1))
        windows, done = plan.scene.windows, 0
        with tqdm(total=points.size, unit=" steps", delay=1.0, disable=not progress) as bar:
            while done < points.size:
                raise_if_interrupted()
                started = time.perf_counter()
                stretch.advance(min(stretch.reached + _WINDOWS_AT_ONCE * length, last))
                known = end if stretch.reached >= last else stretch.reached - 0.5 * length
                count = int(np.searchsorted(points, known, "right"))
                slow = stretch.slow(points[done:count])
                self.seconds += time.perf_counter() - started
                if not done:  # the start is given; a fit of later motion is less accurate
                    slow.amplitude[0], slow.power[0] = plan.excited.initial, 0.0
                record_points(plan, recorder, done, slow.amplitude.view(float), slow.power)
                bar.update(count - done)
                done = count
                while windows and windows[0].end <= known:
                    self._sample(windows.pop(0), points, recorder, raise_if_interrupted)
        recorder.event(end, "info", "end of the scene")

    def _sample(
        self,
        window: Window,
        points: Floats,
        recorder: Recorder,
        raise_if_interrupted: Callable[[], None],
    ) -> None:
        """Record the fast motion of a window that has been integrated."""
        record = WindowRecord(self._plan, recorder, window)
        phases = record.of_contacts and len(self._plan.excited.modes) == 2
        times = window_times(window, points, self._script.frequency, self._script.frequency_rate)
        for start in range(0, times.size, SAMPLES_PER_BATCH):
            raise_if_interrupted()
            batch = times[start : start + SAMPLES_PER_BATCH]
            record.add(self._stretch.motion(batch))
            if phases:
                angle, *_ = self._full.excitation.at(batch)
                recorder.write(channels.PHASES, batch, angle % (2.0 * np.pi))
        record.finish()
        self.samples += record.samples


def integration_cost(plan: Plan) -> list[Finding]:
    """Return the cost of full order, for the scene without a table and for stretches of it.

    It is extrapolated from the first part of the scene.
    """
    full = FullOrder(plan, plan.excited.reduced)
    stretch = Stretch(full, full.first())
    started = time.process_time()
    stretch.advance(_TIMED * full.window)
    integrated = time.process_time()
    stretch.slow(np.linspace(0.0, stretch.reached, _TIMED_POINTS))
    demodulated = time.process_time()
    seconds = (integrated - started) * plan.scene.run.duration / stretch.reached
    seconds += (demodulated - integrated) * plan.schedule.steps / _TIMED_POINTS
    reason = 'model.table = "none" needs no friction table, which pays for many runs'
    found = [Finding("a single run", f"{seconds:.2g} s of a processor integrated", reason)]
    if plan.full_order:
        share = sum(end - start for start, end in plan.full_order) / plan.scene.run.duration
        choice = f"about {share * seconds:.2g} s of a processor"
        found.append(Finding("full order", choice, f"for {share:.1%} of the scene"))
    return found
