"""What a run of a scene records as it goes, through slow time or integrated."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.validity import Finding
from slipmode.runner.contact_record import ContactRecord, said
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.full_order import FastMotion

SAMPLES_PER_BATCH = 16384


def record_findings(recorder: Recorder, found: Iterable[Finding]) -> None:
    """What of a plan and a model is more than information, as events at t = 0."""
    for each in found:
        if each.level != "info":
            recorder.event(0.0, each.level, f"{each.subject} {each.choice}: {each.reason}")


def record_points(
    plan: Plan, recorder: Recorder, first: int, amplitude: Floats, energy: Floats
) -> None:
    """Slow channels of communication points from number `first` on.

    Parameters
    ----------
    amplitude : (points, 2 modes) ndarray
        Real and imaginary part of each a_j.
    energy : (points, 3) ndarray
        Input power, dissipated power, dissipated energy.
    """
    schedule, points = plan.schedule, slice(first, first + len(amplitude))
    time = schedule.time(points)
    moduli = np.hypot(amplitude[:, 0::2], amplitude[:, 1::2])
    recorder.write("/modes", time, np.hstack((amplitude, moduli)))
    names = [f"{q}_{m}" for m in plan.excited.modes for q in ("force", "frequency", "phase")]
    recorder.write("/forcing", time, schedule.at_points(names, points))
    recorder.write("/energy", time, energy)


class WindowRecord:
    """Fast motion of a window, and what the contacts do in it.

    Attributes
    ----------
    of_contacts : bool
        Whether it is a [[contact]] window.
    samples : int
        So far.
    """

    def __init__(self, plan: Plan, recorder: Recorder, window: Window) -> None:
        reduced = plan.excited.reduced
        self._contacts = ContactRecord(reduced.contacts, reduced.n_contacts)
        self._recorder = recorder
        self._window = window
        self._elastic = bool(plan.scene.output.elastic)
        self._states: list[Floats] = []
        self.of_contacts = window in plan.scene.contact
        self.samples = 0

    def add(self, motion: FastMotion, scale: Floats | float = 1.0) -> None:
        """Write motion that follows, limits and preloads scaled."""
        moved = motion.displacement, motion.velocity, motion.force
        if self.of_contacts:
            rows = self._contacts.rows(*moved, scale)
            for channel, values in zip(self._contacts.channels, rows, strict=True):
                self._recorder.write(channel.topic, motion.time, values)
            told = self._contacts.states(motion.displacement, motion.force, scale)
            if told is not None:
                self._states.append(motion.time.size * told.shares())
        if self._elastic:
            self._recorder.write("/elastic", motion.time, motion.elastic)
        self.samples += motion.time.size

    def finish(self) -> None:
        """Say which part of the time contacts spent in each state."""
        if not self._states:
            return
        start, end = self._window.start, self._window.end
        shares = np.sum(self._states, axis=0) / self.samples
        self._recorder.write(channels.SHARE, np.array([end]), shares.reshape(1, -1))
        self._recorder.event(end, "info", f"{start:g} to {end:g} s: {said(shares)}")
